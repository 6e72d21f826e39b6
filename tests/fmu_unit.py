"""A co-simulation unit that is loaded and walked through time, by FMPy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from stribeck.export.fmu.axis import axis
from stribeck.export.model import Model
from stribeck.rig.motion.track import Track, track
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.twin import TestBed
from stribeck.space import Array

fmpy = pytest.importorskip("fmpy", reason="fmpy, of the extra `export`, is not installed")
from fmpy.fmi2 import FMU2Slave  # noqa: E402 - only where it is there

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

    def walk(self, t: Array, inputs: Mapping[str, Array]) -> Array:
        """Outputs at times t under inputs there, linear between them unless held: (4, N)."""
        outputs = np.empty((4, len(t)))
        outputs[:, 0] = self.get(*OUTPUTS)
        slopes = {n: np.diff(x) / np.diff(t) for n, x in inputs.items() if n not in self.discrete}
        for k, h in enumerate(np.diff(t)):
            self.set(**{n: x[k] for n, x in inputs.items()})
            self.slope(**{n: s[k] for n, s in slopes.items()})
            self.slave.doStep(t[k], h)
            outputs[:, k + 1] = self.get(*OUTPUTS)
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
