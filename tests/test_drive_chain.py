"""Drive chains: factors against the examples of the makers' own documents, and what is refused."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import numpy as np
import pytest

from command import Completed, caller
from stribeck.drive import CONVENTIONS, DriveChain, missing_chain
from stribeck.drive.chain_numbers import example_of
from stribeck.errors import InputError
from stribeck.units import unit


def chain(**table: object) -> DriveChain:
    """A chain of a `[drive]` table."""
    return DriveChain.of_table(table)


def force(table: dict[str, object], value: float) -> float:
    """What a value of the signal, in the signal's unit, is in SI."""
    built = chain(**table)
    return built.gain * unit(built.signal.unit).factor * value


#: Values and torques that stand in, or follow by one multiplication from, the documents.
DOCUMENTED = [
    # Nanotec, 6077h: "500" means 50 % of the rated torque, "1100" is 110 %.
    ({"convention": "nanotec", "rated_torque": "2 N m"}, 500.0, 1.0),
    ({"convention": "nanotec", "rated_torque": "2 N m"}, 1100.0, 2.2),
    # Bonfiglioli, 12.5.25: 1000 is the rated torque; -1 is -0.1 %.
    ({"convention": "active-cube", "rated_torque": "30 N m"}, 1000.0, 30.0),
    ({"convention": "active-cube", "rated_torque": "30 N m"}, -1.0, -0.03),
    # EL72x1, 2001:11: M = value/1000 x (rated current/sqrt 2) x kt, and without the root.
    (
        {"convention": "el72x1-peak", "rated_current": "2.7 A peak", "kt": "0.1 Nm/A rms"},
        1000.0,
        2.7 / math.sqrt(2) * 0.1,
    ),
    (
        {"convention": "el72x1-rms", "rated_current": "2.7 A rms", "kt": "0.1 Nm/A rms"},
        1000.0,
        2.7 * 0.1,
    ),
    # AX8000, 6077: per thousand of the standstill torque. AX5000: tenths of a percent of P-0-0094.
    ({"convention": "ax8000", "standstill_torque": "1.4 N m"}, 250.0, 0.35),
    ({"convention": "ax5000", "peak_torque": "8.4 N m"}, 100.0, 0.84),
    # Panasonic MINAS E: the rated torque is 2000.
    ({"convention": "panasonic-minas-e", "scale": "0.00064 N m"}, 2000.0, 1.28),
    # MR-J2S-A, 5.2.2: 8 V is the maximum torque, here 3.84 N m.
    ({"convention": "mr-j2s-analog", "scale": "0.48 N m/V"}, 8.0, 3.84),
    # Robotis: XM430, a unit of about 2.69 mA; 1193 units are the limit of 3.2 A. XL330: 1 mA.
    ({"convention": "dynamixel-xm430", "kt": "1 N m/A"}, 1193.0, 3.209),
    ({"convention": "dynamixel-xl330", "kt": "1 N m/A"}, 1750.0, 1.75),
    # ODrive: torque = 8.27 current/KV.
    ({"convention": "odrive", "kt": f"{8.27 / 150} N m/A"}, 10.0, 8.27 * 10 / 150),
]


@pytest.mark.parametrize(("table", "value", "torque"), DOCUMENTED)
def test_a_value_is_the_torque_that_its_document_says(
    table: dict[str, object], value: float, torque: float
) -> None:
    assert force(table, value) == pytest.approx(
        torque, rel=1e-3 if "xm430" in str(table) else 1e-12
    )


@pytest.mark.parametrize("name", CONVENTIONS)
def test_a_convention_with_its_numbers_is_a_chain_that_is_read_back(name: str) -> None:
    c = CONVENTIONS[name]
    table = {n: c.examples.get(n, example_of(n)) for n in c.needs}
    built = chain(convention=name, **table)
    assert built.unit == "N m"
    assert chain(**built.table()) == built
    assert c.document
    assert c.address.startswith("http")
    for missing in c.needs:
        less = {n: text for n, text in table.items() if n != missing}
        if missing == "kt":
            assert chain(convention=name, **less).unit == "A"
        else:
            with pytest.raises(InputError, match=f"{missing} is missing"):
                chain(convention=name, **less)


def test_gear_and_lead_take_the_torque_to_the_axis() -> None:
    """Work is kept: torque times the motor's angle is force times the axis's travel."""
    built = chain(signal="N m", gear="5", lead="10 mm", counts_per_turn="4096")
    turn = built.resolved("position", "rev")
    assert turn is not None
    assert built.gain * turn.factor == pytest.approx(2 * math.pi)
    assert turn.factor == pytest.approx(0.002)
    count = built.resolved("position", "inc")
    assert count is not None
    assert 4096 * count.factor == pytest.approx(turn.factor)
    speed = built.resolved("velocity", "r/min")
    assert speed is not None
    assert speed.factor == pytest.approx(0.002 / 60)
    assert speed.dimension == "m/s"
    assert built.resolved("position", "mm") is None


def test_a_rotary_axis_keeps_its_own_angles_unless_the_motor_s_are_recorded() -> None:
    gear = {"signal": "A", "kt": "0.1 N m/A", "gear": "100"}
    assert chain(**gear).resolved("position", "deg") is None
    motor = chain(**gear, motion="motor").resolved("position", "deg")
    assert motor is not None
    assert motor.factor == pytest.approx(math.radians(0.01))
    assert chain(**gear, side="motor").gain == pytest.approx(0.1)
    assert chain(**gear).gain == pytest.approx(10.0)


def test_the_rotor_s_inertia_is_a_mass_at_the_axis() -> None:
    built = chain(signal="N m", gear="5", lead="10 mm", rotor_inertia="4e-5 kg m**2")
    speed = 0.1  # of the axis, m/s
    motor = speed / 0.01 * 2 * math.pi * 5
    assert built.rotor_mass * speed**2 == pytest.approx(4e-5 * motor**2)


def test_losses_follow_the_way_that_power_goes() -> None:
    built = chain(signal="N m", efficiency=0.8, efficiency_backward="0.5")
    torque, speed = np.array([1.0, 1.0, -1.0, -1.0]), np.array([1.0, -1.0, 1.0, -1.0])
    np.testing.assert_allclose(built.losses(torque, speed), [0.8, 2.0, 2.0, 0.8])


def test_numbers_keep_their_tolerance_and_their_source() -> None:
    built = chain(signal="A rms", kt="0.52 Nm/Arms ± 5 % (data sheet)", gear=3)
    kt, gear = built.constants
    assert (kt.name, kt.source) == ("kt", "data sheet")
    assert kt.tolerance == pytest.approx(0.026)
    assert (gear.origin, gear.tolerance) == ("counted", 0.0)
    nameplate = chain(signal="% of rated torque", rated_torque="1.27 Nm nameplate").constants[0]
    assert nameplate.origin == "nameplate"
    assert nameplate.tolerance == pytest.approx(0.127)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ({}, "signal is missing"),
        ({"signal": "%"}, "does not say what 100 % is"),
        ({"signal": "‰ of something"}, "does not say what 100 % is"),
        ({"signal": "bananas"}, "unknown unit 'bananas'"),
        ({"signal": "mm"}, "is no signal of a drive"),
        ({"signal": "% of rated torque"}, "rated_torque is missing"),
        ({"signal": "% of rated torque", "rated_torque": 1.27}, "must be in N m"),
        ({"signal": "% of rated torque", "rated_torque": "1.27 A"}, "must be in N m"),
        ({"signal": "% of rated torque", "rated_torque": "-1 N m"}, "must be above 0"),
        ({"signal": "A rms", "kt": "0.5 N m/A"}, "rms or peak"),
        ({"signal": "A", "kt": "0.5 N m/A rms"}, "rms or peak"),
        ({"signal": "A", "kt": "0.5 N/A", "gear": "5"}, "no gear and no lead"),
        ({"signal": "N m", "efficiency": "1.1"}, "within 0 and 1"),
        ({"signal": "N m", "side": "left"}, '"axis" or "motor"'),
        ({"signal": "N m", "reversed": "yes"}, "true or false"),
        ({"signal": "N m", "kd": "5"}, "no 'kd'"),
        ({"convention": "nix"}, "no drive convention 'nix'"),
        ({"signal": "N m", "gear": 1e300}, "its numbers make"),
        ({"signal": "N m", "gear": 10**400}, "not a finite number"),
        ({"signal": "A", "kt": " " * 10**6 + "0.5 N m/A"}, "too long"),
        ({"signal": "% of " + "rated " * 10**5 + "torque"}, "too long"),
        ({"signal": "N m", "gear": [5]}, "a number with its unit in quotes"),
        ({"signal": 5}, "must be text"),
    ],
)
def test_what_is_no_chain_is_refused_in_a_line(table: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says) as refused:
        chain(**table)
    assert "\n" not in str(refused.value)


def test_counts_ask_for_the_counts_of_a_turn() -> None:
    with pytest.raises(InputError, match="counts_per_turn"):
        chain(signal="N m").resolved("position", "inc")


def test_percent_alone_lists_what_it_can_mean() -> None:
    line = missing_chain("%")
    assert line is not None
    for quantity in ("torque", "current"):
        assert f'signal = "% of rated {quantity}", rated_{quantity} = "' in line
        assert f"standstill_{quantity}" in line
        assert f"peak_{quantity}" in line
    assert 'kt = "' in line
    assert "stribeck drives" in line
    assert missing_chain("N") is None
    assert missing_chain("1") is None


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    monkeypatch.delenv("COLUMNS", raising=False)  # names are not broken where nobody says a width
    return caller(monkeypatch, capsys)


def test_the_command_shows_conventions_with_their_documents(
    run: Callable[..., Completed],
) -> None:
    listed = run("drives")
    assert listed.status == 0
    assert all(f"\n{name} " in listed.out for name in CONVENTIONS)
    one = run("drives", "el72x1-peak")
    assert "2001:11" in one.out
    assert 'rated_current = "2.4 A peak"' in one.out
    table = json.loads(run("drives", "--json").out)
    assert table["odrive"]["document"].startswith("ODrive")
    assert run("drives", "nix").status == 2
