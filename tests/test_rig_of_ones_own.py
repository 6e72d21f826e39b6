"""A new rig is one class and one entry in RIGS: all commands take it, or name what it lacks."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from stribeck import LAWS, RIGS, InputError, Law, Param, Recording
from stribeck.constant import constant
from stribeck.rig.equation import Equation, Input
from stribeck.rig.motion.drives import AXIS, FEED_FORWARD, GOAL
from stribeck.rig.motion.track import Track
from stribeck.rig.parts import part_named
from stribeck.rig.parts.axis_of_parts import assembled
from stribeck.rig.rig import Motion
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.stepped import SteppedRig
from stribeck.space import Array


@dataclass(frozen=True, eq=False)
class BeltAxis(SteppedRig):
    """M dv/dt = clip(k_f kv (kp (x_c − x) − v), k_f i_max) − offset − F_f: a cascade controller."""

    @property
    def entry(self) -> int:
        return FEED_FORWARD

    def inputs(self, recording: Recording) -> Mapping[str, Array]:
        if recording.command is None:
            raise InputError(f"{recording.label}: rig {self.name} needs a command")
        return {"goal": recording.command, "feed_forward": np.zeros(len(recording))}

    def coefficients(self, values: Mapping[str, Any]) -> tuple[Any, ...]:
        per_speed = values["k_f"] * values["kv"]
        parts = (
            part_named("controller", "pd"),
            part_named("motor", "force"),
            part_named("load", "mass"),
        )
        return assembled(
            parts,
            {
                "M": values["mass"],
                "kp": per_speed * values["kp"],
                "kd": per_speed,
                "offset": values["pull"],
                "limit": values["k_f"] * values["i_max"],
            },
        )

    def equation(self, law: Law) -> Equation:
        del law
        return Equation(
            AXIS,
            "mass a = clip(k_f kv (kp (command − x) − v) + added_force, k_f i_max) − pull − F_f",
            (
                Input("command", "m", "commanded position", GOAL),
                Input("added_force", "N", "added to the drive's force", FEED_FORWARD),
            ),
            ("kp", "kv", "k_f", "i_max"),
            self.coefficients,
            own_step=True,
        )


BELT = BeltAxis(
    name="belt",
    doc="a belt axis under a cascade of proportional loops",
    cite="this test",
    constants=(
        constant("kp", 20.0, "1/s", "gain of the position loop", "the drive"),
        constant("kv", 0.8, "A s/m", "gain of the velocity loop", "the drive"),
        constant("k_f", 60.0, "N/A", "force constant", "the data sheet"),
        constant("i_max", 8.0, "A", "largest current", "the data sheet"),
        constant("step", 5.0, "ms", "longest step", "a choice"),
        constant("tolerance", 1e-3, "mm", "way by which a step may be off", "a choice"),
    ),
    params=(
        Param("mass", 0.5, 10.0, "kg", "m", True, doc="moving mass"),
        Param("pull", -5.0, 5.0, "N", "F_0", doc="constant force"),
    ),
    laws=("coulomb-viscous", "stribeck"),
    ranges={"F_C": (0.0, 20.0), "F_V": (0.0, 20.0)},
    shows={"position": "mm", "velocity": "mm/s"},
)
#: F_C, F_V, mass, pull.
TRUTH = np.array([6.0, 4.0, 2.5, 0.5])


@dataclass(frozen=True, eq=False)
class CommandFollower(SimulatedRig):
    """An axis that follows its command: a rig with `move` alone."""

    def move(self, law: Law, p: Array, track: Track) -> Motion:
        del law
        x = np.tile(np.interp(track.t, track.knots_t, track.knots_x), (len(p), 1)) + p[:, :1] * 1e-4
        return Motion(track.t, x, np.gradient(x, track.t, axis=1), 0 * x)


CARRIED = CommandFollower(
    name="carried", doc="an axis that goes where it is told", cite="this test",
    laws=("coulomb-viscous",),
)  # fmt: skip


def command(t: Array) -> Array:
    """Strokes of 50 mm at 50 mm/s with rests, m."""
    return np.interp(t % 4.0, [0.0, 0.5, 1.5, 2.0, 2.5, 3.5, 4.0], [0, 0, 0.05, 0.05, 0.05, 0, 0])


@pytest.fixture
def stribeck(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    for rig in (BELT, CARRIED):
        monkeypatch.setitem(RIGS, rig.name, rig)
    return caller(monkeypatch, capsys)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    t = np.arange(0.0, 8.0, 0.01)
    goal = command(t)
    blank = Recording(t=t, position=np.full(len(t), goal[0]), command=goal)
    motion = BELT.simulate(LAWS["coulomb-viscous"], TRUTH[None], blank)
    x = motion.position[0] + 2e-6 * np.random.default_rng(0).standard_normal(len(t))
    path = tmp_path / "belt.csv"
    rows = np.column_stack([t, x, goal])
    np.savetxt(path, rows, delimiter=",", header="time [s],position [m],command [m]", comments="")
    return path


def output_of(completed: Completed) -> str:
    assert completed.status == 0, completed.err
    return completed.out


def test_every_command_takes_it(
    stribeck: Callable[..., Completed], log: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    output = output_of(stribeck(
        "identify", str(log), "--rig", "belt", "--set", "pull=0.5", "--budget", "400",
        "--repeats", "1", "--out", str(out),
    ))  # fmt: skip
    assert "F_C" in output
    card = str(out / "card.json")
    (out / "report.html").unlink()
    output_of(stribeck("report", str(out)))
    assert "a belt axis under a cascade" in (out / "report.html").read_text(encoding="utf-8")
    output = output_of(stribeck("compensate", card, "--scale", "0.8", "--mode", "reference"))
    assert "coulomb-viscous on belt: RMS" in output
    assert "strokes × 2" in output_of(stribeck("plan", card, "--seconds", "4"))
    unit = tmp_path / "belt.fmu"
    output_of(stribeck("export", card, "--to", "fmu", "--out", str(unit)))
    with zipfile.ZipFile(unit) as archive:
        header = archive.read("sources/axis_model.h").decode()
    assert "((r[R_k_f] * r[R_kv]) * r[R_kp])" in header
    for target, name in (
        ("c", "c"), ("matlab", "matlab"), ("st", "friction.st"), ("plcopen", "friction.xml"),
        ("modelica", "Friction.mo"), ("table", "friction.csv"),
    ):  # fmt: skip
        output_of(stribeck("export", card, "--to", target, "--out", str(tmp_path / name)))


def test_what_it_does_not_answer_is_named(
    stribeck: Callable[..., Completed], log: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    output_of(stribeck(
        "identify", str(log), "--rig", "carried", "--method", "random", "--budget", "20",
        "--repeats", "1", "--out", str(out),
    ))  # fmt: skip
    card = str(out / "card.json")
    completed = stribeck("compensate", card)
    assert completed.status == 2
    assert "rig carried has no controller to add a compensation to: " in completed.err
    assert completed.err.rstrip().endswith("(--loop FILE.toml)")
    completed = stribeck("export", card, "--to", "fmu", "--out", str(tmp_path / "carried.fmu"))
    assert completed.status == 2
    assert "rig carried has no equation of motion that could be stepped" in completed.err
