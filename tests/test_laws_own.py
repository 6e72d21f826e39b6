"""The user-defined law of docs/laws.md, run as printed there."""

from __future__ import annotations

import contextlib
import io
import json
import re
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stribeck
from stribeck import cli
from stribeck.friction import slip_law

PAGE = Path(__file__).parent.parent / "docs" / "laws.md"
#: Friction of the twin's slide leftward: the published set, SI.
F_S, F_C = 152.28, 40.42

_REPORT = """
import json
import numpy as np
from stribeck.rig.motion.command import Drive
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.twin import TestBed
from stribeck.rig.motion.track import track

v = np.array([-1e-2, 0.0, 1e-3, 1e-2])
truth = np.array([150.0, 45.0, 900.0, 2e-3, 700.0])  # k_spring, N/m, last
twin = TestBed().run("down", law=MY_LAW, truth=truth).recording
own = identify(twin, rig=SLIDE_BED.exact(), law=MY_LAW, train="325:127")
t = np.arange(0.0, 20.0, 0.01)
on = track(Drive.line(0.0, 0.112, 20.0, 5e-3), t, 0.112)
rows = np.vstack([truth, np.where(np.eye(5, dtype=bool), 1.05 * truth, truth)])
x = SLIDE_BED.move(MY_LAW, rows, on).position
steps = [
    SLIDE_BED.move(MY_LAW, truth[None], on, scheme="reference", dt=dt).position[0]
    for dt in (3.2e-4, 1.6e-4, 8e-5)
]
speeds = np.linspace(-0.1, 0.1, 401)
print(json.dumps({
    "values": fit.values, "J": fit.score.value, "held": fit.holdout[0].score.value,
    "force": MY_LAW.friction(v, np.array([100.0, 40.0, 500.0, 2e-3])).tolist(),
    "own": {
        q.name: [value, e.value, e.low, e.high, e.verdict]
        for q, value, e in zip(own.parameters.every, truth.tolist(), own.estimates)
    },
    "own_J": own.score.value,
    "change": np.abs(x[1:] - x[0]).max(axis=1).tolist(),
    "off": [float(np.sqrt(np.mean((s - x[0]) ** 2))) for s in steps],
    "power": float((speeds * MY_LAW.friction(speeds, truth[:4])).min()),
}))
"""


@pytest.fixture(scope="module")
def findings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The results of the block on its twin, as a program in a folder of its own."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (block,) = (b for b in blocks if "@slip_law" in b)
    folder = tmp_path_factory.mktemp("own")
    (folder / "demo").mkdir()
    (folder / "mine.py").write_text(block + _REPORT, encoding="utf-8")
    printed = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(printed):
        patch.chdir(folder)
        patch.setattr(sys, "argv", ["stribeck", "twin", "demo/twin.csv", "--loop", "ideal"])
        cli.main()
        runpy.run_path("mine.py", run_name="__main__")
    output: dict[str, Any] = json.loads(printed.getvalue().splitlines()[-1])
    return output


def test_the_law_of_the_page_is_the_function_it_shows(findings: dict[str, Any]) -> None:
    v, F = np.array([-1e-2, 0.0, 1e-3, 1e-2]), np.array(findings["force"])
    expected = np.where(v < 0, -1, 1) * (40 + 60 * 2 / (np.exp(v / 2e-3) + np.exp(-v / 2e-3)))
    np.testing.assert_allclose(F, expected + 500 * v, rtol=1e-12)


def test_it_finds_the_friction_of_the_twin(findings: dict[str, Any]) -> None:
    # Sensor noise is 0.3 mm: a law that differs from the twin's by the shape of its drop comes
    # down to the noise, both in training and held out.
    assert 0.28 < findings["J"] < 0.35
    assert 0.28 < findings["held"] < 0.40
    assert abs(findings["values"]["F_S"] / F_S - 1) < 0.1
    assert abs(findings["values"]["F_C"] / F_C - 1) < 0.1


def test_it_finds_its_own_twin_again(findings: dict[str, Any]) -> None:
    assert 0.28 < findings["own_J"] < 0.32
    identified = {n for n, (*_, verdict) in findings["own"].items() if verdict == "identified"}
    assert identified >= {"F_S", "F_C"}  # where it starts and stops; the drop passes in a few ms
    for name in identified:
        truth, value, low, high, _ = findings["own"][name]
        half = high - value if truth > value else value - low
        assert abs(truth - value) <= 2 * half, name


def test_it_takes_energy_and_each_of_its_parameters_matters(findings: dict[str, Any]) -> None:
    assert findings["power"] >= 0
    assert min(findings["change"]) > 1e-4


def test_its_motion_is_that_of_ever_finer_plain_steps(findings: dict[str, Any]) -> None:
    coarse, fine, finest = findings["off"]
    assert coarse > 2 * fine > 4 * finest
    assert finest < 1e-6


def test_a_law_typed_at_a_prompt_compiles_too() -> None:
    space: dict[str, Any] = {"slip_law": slip_law}
    exec("@slip_law\ndef slip(v, p):\n    return p[0] * v\n", space)  # noqa: S102 - a prompt does that
    assert space["slip"](0.5, np.array([3.0])) == 1.5


def test_the_page_shows_every_law_there_is() -> None:
    text = PAGE.read_text(encoding="utf-8")
    for name in stribeck.LAWS:
        assert f"`{name.removesuffix('-directional')}`" in text, name
