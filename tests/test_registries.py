"""The lists of laws and rigs: complete, within 80 columns."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from stribeck import Recording, identify
from stribeck.errors import InputError
from stribeck.friction import LAWS, law_named
from stribeck.report.registries import show_laws, show_rigs
from stribeck.rig import RIGS
from two_mass_axes import SERVO, rig_of


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.parametrize("name", [None, *LAWS])
def test_laws_fit_the_terminal(name: str | None, capsys: pytest.CaptureFixture[str]) -> None:
    show_laws(name)
    output = capsys.readouterr().out
    assert max(len(line.rstrip()) for line in output.splitlines()) <= 80
    if name is None:
        heads = [line.split()[0] for line in output.splitlines() if line[:1].strip()]
        assert heads[1 : 1 + len(LAWS)] == [*LAWS]
    else:
        for q in LAWS[name].params:
            assert f"\n{q.name} " in output


def test_a_long_formula_stays_inset(capsys: pytest.CaptureFixture[str]) -> None:
    show_laws("bam-m6")
    paragraph = capsys.readouterr().out.split("\n\n")[1].splitlines()
    assert len(paragraph) > 4
    assert all(line.startswith("  ") for line in paragraph)


@pytest.mark.parametrize("name", list(RIGS))
def test_rigs_fit_the_terminal(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    show_rigs(RIGS[name])
    output = capsys.readouterr().out
    assert max(len(line.rstrip()) for line in output.splitlines()) <= 80
    for c in RIGS[name].constants:
        assert f"\n{c.name} " in output


def test_the_list_of_rigs_says_how_each_is_fitted(capsys: pytest.CaptureFixture[str]) -> None:
    show_rigs(None)
    output = " ".join(capsys.readouterr().out.split())
    assert "emps force balance a ball-screw" in output
    assert "joint simulation a robot" in output


def test_a_rig_shows_the_parameters_of_a_law_of_elements(
    capsys: pytest.CaptureFixture[str],
) -> None:
    show_rigs(replace(RIGS["presliding-rotary"], laws=("maxwell-slip:2",)))
    output = capsys.readouterr().out
    assert "parameters with maxwell-slip:2" in " ".join(output.split())
    _, _, table = output.partition("maxwell-slip:2")
    names = [line.split()[0] for line in table.splitlines()[2:] if line[:1].strip()]
    law_names = [q.name for q in law_named("maxwell-slip:2").params]
    assert names[: len(law_names) + 2] == [*law_names, "J", "offset"]


def test_a_rig_is_loaded_when_it_is_taken() -> None:
    code = "import sys, stribeck; stribeck.RIGS['slide-bed']; print(*sys.modules)"
    completed = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    files = {
        m.rpartition(".")[2] for m in completed.stdout.split() if m.startswith("stribeck.rig.")
    }
    assert "slide_bed" in files
    assert not files & {"balanced", "cylinder", "emps", "joint", "presliding", "servo_pendulum"}


@pytest.mark.parametrize(
    ("side", "sign", "absent"),
    [("load", "F_f is friction", "F_f,m"), ("motor", "F_f,m is friction", "− F_f\n"),
     ("both", "F_f is friction of the load, F_f,m of the motor", "")],
)  # fmt: skip
def test_two_masses_have_the_friction_of_their_sides(
    side: str, sign: str, absent: str, capsys: pytest.CaptureFixture[str]
) -> None:
    show_rigs(rig_of(SERVO, friction={"side": side}))
    shown = capsys.readouterr().out
    assert f"equation of motion, {sign}" in shown
    assert not absent or absent not in shown
    assert ("− T − F_f,m" in shown) == (side != "load")


@pytest.mark.parametrize(
    ("rig", "other"),
    [
        ("forced", "forced-rotary"), ("forced-rotary", "forced"),
        ("presliding", "presliding-rotary"), ("presliding-rotary", "presliding"),
        ("servo-pendulum", "forced if the force was measured"),
        ("slide-bed", "forced-rotary if the torque was measured"),
    ],
)  # fmt: skip
def test_a_log_of_the_other_kind_of_axis_leads_to_the_rig_for_it(rig: str, other: str) -> None:
    turning = not RIGS[rig].rotary
    t = np.arange(0.0, 2.0, 1e-2)
    x = np.sin(5.0 * t)
    stated = {name: np.ones(len(t)) for name in ("kp", "vin", "mass", "length")}
    log = Recording(t=t, position=x, command=x, force=x, rotary=turning, extra=stated)
    with pytest.raises(InputError, match=rf"and rig {rig} is \w+: use {other}$"):
        identify(log, rig=rig)
