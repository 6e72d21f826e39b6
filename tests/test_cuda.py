"""The integrator on a GPU against the one on the processor.

A device is at hand in few places. So its programs run in numba's simulator of one, as Python; and
where NVIDIA's compiler is installed, what it makes of them runs as C (ptx.py).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ptx import Device
from stribeck.errors import InputError
from stribeck.friction import LAWS, Law
from stribeck.rig import cuda, kernel
from stribeck.rig.drive import Drive
from stribeck.rig.kernel import LEG, MASS
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.track import Track, track
from stribeck.space import Array

N = 6
OF_THE_RIG = SLIDE_BED.laws
Case = tuple[Array, Array, Track]


def case(law: Law, direction: int, seconds: float) -> Case:
    """Parameters and constants, two of them impossible, and the noisy ramp of the first."""
    params = SLIDE_BED.parameters(law)
    lower, upper = np.array([[q.lower, q.upper] for q in params]).T
    rng = np.random.default_rng(2012)
    p = lower + (upper - lower) * rng.random((N, len(lower)))
    for k, q in enumerate(params):
        if q.fixed is not None:
            p[:, k] = q.fixed * np.linspace(1.0, 1.5, N)
    t = np.arange(round(seconds * 100) + 1) / 100
    x0 = 0.112 if direction > 0 else 0.325
    drive = Drive.line(0.0, x0, seconds, direction * 5e-3)
    x, _ = kernel.trajectories(law, *SLIDE_BED.split(law, p[:1]), track(drive, t, x0))
    p[1, 0] = -1.0 if law.name.startswith("coulomb") else np.nan
    made, c = SLIDE_BED.split(law, p)
    c[2, MASS] = 0.0
    noisy = x[0] + 3e-4 * rng.standard_normal(len(t))
    return np.ascontiguousarray(made), c, track(drive, t, x0, noisy)


def assert_same(found: Array, law: Law, p: Array, c: Array, on: Track) -> None:
    """Equal within 1e-9, or within what the last digit of a parameter does on the processor."""
    expected = kernel.misfits(law, p, c, on)
    assert np.flatnonzero(np.isnan(expected)).tolist() == [1, 2]
    rng, own = np.random.default_rng(1), np.zeros(len(p))
    for _ in range(16):
        q = p * (1 + 2e-16 * rng.integers(-1, 2, p.shape))
        own = np.maximum(own, np.abs(kernel.misfits(law, q, c, on) / expected - 1))
    assert np.isnan(found).tolist() == np.isnan(expected).tolist()
    good = ~np.isnan(expected)
    off = np.abs(found / expected - 1)[good]
    bound = np.full(good.sum(), 1e-9)
    if law.name.startswith("coulomb"):  # they slide on at the edge of stability
        bound = np.maximum(bound, 20 * own[good])
    assert (off <= bound).all(), (off, bound)


# --- in numba's simulator -------------------------------------------------------------------------

_CHILD = """
import json
import numpy as np
import test_cuda as here
from stribeck.rig import cuda
cuda.CHUNK = 4  # less than there are candidates
for name in here.OF_THE_RIG:
    law = here.LAWS[name]
    p, c, on = here.case(law, 1, 4.0)
    with np.errstate(all="ignore"):
        found = cuda.misfits(law, p, c, on)
    print(json.dumps([name, found.tolist()]))
rig = here.SLIDE_BED.on("cuda")
law = here.LAWS["stribeck"]
with np.errstate(all="ignore"):
    found = rig.misfits(law, here.published(), here.case(law, 1, 4.0)[2])
print(json.dumps(["rig", found.tolist()]))
try:
    cuda.misfits(here.replace(law, slip=abs), p, c, on)
except here.InputError as error:
    print(json.dumps(["refused", str(error)]))
for name in ("lugre", "makkar", "coulomb-load"):
    try:
        rig.misfits(here.LAWS[name], here.np.ones((1, 1 + len(here.LAWS[name].params))), on)
    except here.InputError as error:
        print(json.dumps([name, str(error)]))
"""


def published() -> Array:
    return np.array([[144.5463, 47.8514, 958.3, 1.0964e-3, 1.0, 967.98]])


@pytest.fixture(scope="module")
def simulated() -> dict[str, Any]:
    """What the simulator finds; it has to be asked for before numba is imported."""
    here = Path(__file__).parent
    ran = subprocess.run(
        [sys.executable, "-c", _CHILD],
        env=os.environ | {"NUMBA_ENABLE_CUDASIM": "1"},
        cwd=here, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    return dict(json.loads(line) for line in ran.stdout.splitlines())


@pytest.mark.parametrize("name", OF_THE_RIG)
def test_the_programs_of_the_device_find_what_the_processor_finds(
    name: str, simulated: dict[str, Any]
) -> None:
    law = LAWS[name]
    assert_same(np.array(simulated[name]), law, *case(law, 1, 4.0))


def test_a_rig_on_the_device_computes_its_misfits_there(simulated: dict[str, Any]) -> None:
    law = LAWS["stribeck"]
    on = case(law, 1, 4.0)[2]
    expected = SLIDE_BED.misfits(law, published(), on)
    np.testing.assert_allclose(simulated["rig"], expected, rtol=1e-9)


def test_a_law_without_a_source_is_refused_in_a_line(simulated: dict[str, Any]) -> None:
    assert simulated["refused"].startswith("law stribeck: device cuda compiles a law from its")


@pytest.mark.parametrize("name", ["lugre", "makkar", "coulomb-load"])
def test_a_law_that_is_stepped_is_refused_in_a_line(name: str, simulated: dict[str, Any]) -> None:
    expected = f"law {name}: device cuda takes static laws that stick at rest; use device cpu"
    assert simulated[name] == expected


# --- as NVIDIA's compiler makes them --------------------------------------------------------------


def compiled(law: Law, monkeypatch: pytest.MonkeyPatch) -> str:
    """PTX for compute capability 8.0; it takes numba-cuda and its compiler, not a device."""
    if find_spec("numba_cuda") is None:
        pytest.skip("numba-cuda is not installed: pip install 'stribeck[gpu]'")
    import numba.cuda as numba_cuda  # noqa: PLC0415 - where there is one
    from numba.cuda.cudadrv.nvvm import NVVM  # noqa: PLC0415

    try:
        NVVM()
    except Exception as error:  # noqa: BLE001 - numba has many for a library that is not there
        pytest.skip(f"NVIDIA's compiler is not installed: {error}")
    monkeypatch.setattr(
        "numba.cuda.dispatcher.get_current_device",  # functions of the device ask what it can do
        lambda: SimpleNamespace(compute_capability=(8, 0)),
    )
    made = numba_cuda.compile(
        cuda.candidate(law.slip), cuda.SIGNATURE, cc=(8, 0), output="ptx", device=False, abi="numba"
    )
    return str(made[0])


@pytest.mark.parametrize("name", OF_THE_RIG)
def test_what_is_compiled_for_the_device_finds_what_the_processor_finds(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    law = LAWS[name]
    ptx = compiled(law, monkeypatch)
    assert f"[{8 * LEG * kernel.WIDTH}]" in ptx  # a path, and nothing else, for each thread
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed: the program compiles; it cannot be run as C")
    for fuse in (False, True):
        device = Device(ptx, tmp_path, fuse=fuse)
        for direction in (1, -1):
            p, c, on = case(law, direction, 36.6)
            sse, none = np.empty(N), np.empty(0)
            device(
                N, p, c, on.knots_t, on.knots_x, on.extremes, on.t, on.x0, on.measured,
                on.score, on.sums, none, sse, 1.0,
            )  # fmt: skip
            assert_same(sse, law, p, c, on)


# --- on a device, where there is one --------------------------------------------------------------


@pytest.mark.parametrize("name", OF_THE_RIG)
def test_a_device_finds_what_the_processor_finds(name: str) -> None:
    if why := cuda.missing():
        pytest.skip(why)
    law = LAWS[name]
    for direction in (1, -1):
        p, c, on = case(law, direction, 36.6)
        assert_same(cuda.misfits(law, p, c, on), law, p, c, on)


# --- where there is none --------------------------------------------------------------------------


def test_a_missing_package_is_named_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cuda, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install 'stribeck\[gpu\]'; without a GPU"):
        SLIDE_BED.on("cuda")
    law = LAWS["stribeck"]
    with pytest.raises(InputError, match="numba-cuda is not installed"):
        replace(SLIDE_BED, device="cuda").misfits(law, published(), case(law, 1, 1.0)[2])


def test_another_device_is_refused() -> None:
    with pytest.raises(InputError, match="device 'tpu' is not one of cpu, cuda"):
        SLIDE_BED.on("tpu")  # type: ignore[arg-type]


def test_a_rig_goes_back_to_the_processor() -> None:
    assert replace(SLIDE_BED, device="cuda").on("cpu").device == "cpu"
    assert replace(SLIDE_BED, device="cuda").set(m=12.0).device == "cuda"
