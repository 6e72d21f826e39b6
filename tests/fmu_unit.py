"""A co-simulation unit that is loaded and walked through time, by FMPy."""

from __future__ import annotations

import io
import shutil
import subprocess
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stribeck.export.fmu.axis import axis
from stribeck.export.fmu.build import fmu
from stribeck.export.model import Model
from stribeck.rig.motion.track import Track, track
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.twin import TestBed
from stribeck.space import Array

fmpy = pytest.importorskip("fmpy", reason="fmpy, of the extra `export`, is not installed")
from fmpy.fmi2 import FMU2Slave  # noqa: E402 - only where it is there

#: A unit is compiled where it is made.
needs_compiler = pytest.mark.skipif(
    not any(map(shutil.which, ("cc", "gcc", "clang"))), reason="there is no C compiler here"
)
OUTPUTS = ("position", "velocity", "drive", "friction")


class Unit:
    """A unit that is being simulated."""

    def __init__(self, folder: str, description: Any) -> None:
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.discrete = {v.name for v in description.modelVariables if v.variability == "discrete"}
        self.slave = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="axis",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.slave.instantiate()

    def set(self, **values: float) -> None:
        self.slave.setReal([self.references[n] for n in values], list(values.values()))

    def slope(self, **values: float) -> None:
        self.slave.setRealInputDerivatives(
            [self.references[n] for n in values], [1] * len(values), list(values.values())
        )

    def get(self, *names: str) -> Array:
        return np.array(self.slave.getReal([self.references[n] for n in names]))

    def begin(self, **values: float) -> None:
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.set(**values)
        self.slave.exitInitializationMode()

    def walk(
        self, t: Array, inputs: Mapping[str, Array], names: Sequence[str] = OUTPUTS
    ) -> Array:  # fmt: skip
        """Outputs at times t under inputs there, linear between them unless held: (names, N)."""
        outputs = np.empty((len(names), len(t)))
        outputs[:, 0] = self.get(*names)
        slopes = {n: np.diff(x) / np.diff(t) for n, x in inputs.items() if n not in self.discrete}
        for k, h in enumerate(np.diff(t)):
            self.set(**{n: x[k] for n, x in inputs.items()})
            self.slope(**{n: s[k] for n, s in slopes.items()})
            self.slave.doStep(t[k], h)
            outputs[:, k + 1] = self.get(*names)
        return outputs


def difference(computed: Array, expected: Array) -> float:
    """The largest difference as a share of the range."""
    assert np.isfinite(expected).all()
    assert np.ptp(expected) > 0.0
    return float(np.abs(computed - expected).max() / np.ptp(expected))


def rig_of(model: Model) -> SimulatedRig:
    assert isinstance(model.rig, SimulatedRig)
    return model.rig


def moved(unit: Unit, model: Model, segment: Track, **values: float) -> Array:
    """The unit's motion over a prepared track: (4, N)."""
    places = {v.name: v.place for v in axis(model).of("input") if v.place < len(segment.inputs)}
    series = {name: segment.inputs[place] for name, place in places.items()}
    start = {name: x[0] for name, x in series.items()}
    unit.begin(position_start=segment.x0, velocity_start=segment.v0, **start, **values)
    return unit.walk(segment.t - segment.t[0], series)


def ramp(temperature: float = 293.15) -> Track:
    """The ramp of the paper's test bed, up and down, with its command at the samples of a log."""
    drive, x0 = TestBed().drive("both")
    segment = track(drive, np.arange(0.0, drive.t[-1], 0.01), x0)
    inputs = np.zeros((4, len(segment.t)))
    inputs[1], inputs[2] = temperature, drive(segment.t)
    return segment._replace(inputs=inputs, held=np.array([0.0, 0.0, 0.0, 1.0]))


def unpacked(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _compiler() -> str:
    return str(next(filter(None, map(shutil.which, ("cc", "gcc", "clang")))))


def _sources(model: Model, folder: Path) -> None:
    """The C of a unit, in a folder."""
    for name, text in unpacked(fmu(model, binary=False)).items():
        if name.startswith("sources/"):
            (folder / Path(name).name).write_bytes(text)


def compiled_without_a_warning(model: Model, folder: Path) -> None:
    """Compile the C of a unit as strictly as a compiler can be asked to."""
    _sources(model, folder)
    strict = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    completed = subprocess.run(
        [_compiler(), "-std=c99", "-O1", *strict, "-DFMI2_FUNCTION_PREFIX=friction_", "-c",
         "axis.c", "fmi2.c"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert completed.returncode == 0, completed.stderr


#: A master in C, run under the sanitizers.
MASTER = """
#include "axis.h"
#include "fmi2.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
extern fmi2Component fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String,
                                     const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean);
extern fmi2Status fmi2EnterInitializationMode(fmi2Component);
extern fmi2Status fmi2ExitInitializationMode(fmi2Component);
extern fmi2Status fmi2SetReal(fmi2Component, const fmi2ValueReference[], size_t, const double[]);
extern fmi2Status fmi2GetReal(fmi2Component, const fmi2ValueReference[], size_t, double[]);
extern fmi2Status fmi2DoStep(fmi2Component, double, double, int);
extern fmi2Status fmi2GetFMUstate(fmi2Component, fmi2FMUstate *);
extern fmi2Status fmi2SetFMUstate(fmi2Component, fmi2FMUstate);
extern fmi2Status fmi2FreeFMUstate(fmi2Component, fmi2FMUstate *);
extern void fmi2FreeInstance(fmi2Component);
static int refusals = 0;
static void log_(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c,
                 fmi2String m, ...)
{
    (void)e; (void)n; (void)s; (void)c; (void)m;
    refusals++;
}
int main(void)
{
    fmi2CallbackFunctions host = {log_, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate("a", fmi2CoSimulation, AXIS_GUID, "", &host, 0, 0);
    fmi2ValueReference in = AXIS_FIRST_INPUT, position = AXIS_POSITION, far = 1000;
    fmi2FMUstate state = NULL;
    double x, first = 0.0, again = 0.0;
    int i, turn;
    if (fmi2Instantiate("b", fmi2CoSimulation, "another", "", &host, 0, 0) != NULL) return 2;
    if (fmi2DoStep(c, 0.0, 1e-3, 0) != fmi2Error || fmi2GetReal(c, &far, 1, &x) != fmi2Error)
        return 3;
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    fmi2GetFMUstate(c, &state);
    for (turn = 0; turn < 2; turn++) {
        for (i = 0; i < 500; i++) {
            x = 0.02 * (i % 100) * (i < 250 ? 1.0 : -1.0);
            if (fmi2SetReal(c, &in, 1, &x) != fmi2OK || fmi2DoStep(c, 0.0, 5e-3, 0) != fmi2OK)
                return 4;
        }
        fmi2GetReal(c, &position, 1, turn ? &again : &first);
        fmi2SetFMUstate(c, state);
    }
    fmi2FreeFMUstate(c, &state);
    fmi2FreeInstance(c);
    return refusals == 3 && first == again && first == first && first != 0.0 ? 0 : 5;
}
"""


def run_by_master(model: Model, folder: Path) -> None:
    """Run a unit by a master in C under the sanitizers."""
    _sources(model, folder)
    (folder / "master.c").write_text(MASTER)
    checked = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    completed = subprocess.run(
        [_compiler(), "-std=c99", "-O1", *checked, "master.c", "axis.c", "fmi2.c", "-lm", "-o",
         "master"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert completed.returncode == 0, completed.stderr
    ran = subprocess.run([folder / "master"], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
