"""Heads as drives, PLCs and engineers of seven languages write them."""

import pytest

from stribeck.data.readers.heads import meanings, take_apart

MEASURED, PLAIN, ENDS, COMMANDED = range(4)


@pytest.mark.parametrize(
    ("head", "expected"),
    [
        # CiA 402 object names, and what drives make of them
        ("Position actual value [inc]", {"position": MEASURED}),
        ("Velocity actual value", {"velocity": MEASURED}),
        ("Torque actual value [%]", {"force": MEASURED}),
        ("Position demand value", {"command": PLAIN}),
        ("Velocity demand value", {}),
        ("Torque demand", {"force": COMMANDED}),
        ("Position Feedback Value", {"position": MEASURED}),
        # German, a compound
        ("Istposition [mm]", {"position": MEASURED}),
        ("Lageistwert", {"position": MEASURED}),
        ("Positionsistwert", {"position": MEASURED}),
        ("Lagesollwert [mm]", {"command": PLAIN}),
        ("Istgeschwindigkeit [mm/s]", {"velocity": MEASURED}),
        ("Drehzahlistwert [1/min]", {"velocity": MEASURED}),
        ("Drehzahlsollwert [1/min]", {}),
        ("Momentenistwert", {"force": MEASURED}),
        ("Stromistwert [A]", {"current": MEASURED}),
        ("Antriebskraft [N]", {"force": PLAIN}),
        ("Thrust [N]", {"force": PLAIN}),
        ("Friction_force [N]", {"force": ENDS}),  # a result: what is called force comes before it
        ("Achse1.Istposition", {"position": ENDS}),
        # Romance languages, with and without accents
        ("position mesurée [mm]", {"position": MEASURED}),
        ("consigne de position", {"command": PLAIN}),
        ("posizione reale", {"position": MEASURED}),
        ("velocità attuale", {"velocity": MEASURED}),
        ("posición actual", {"position": MEASURED}),
        ("accélération", {"acceleration": PLAIN}),
        # Chinese and Japanese
        ("实际位置", {"position": MEASURED}),
        ("反馈速度", {"velocity": MEASURED}),
        ("指令位置", {"command": PLAIN}),
        ("実トルク", {"force": MEASURED}),
        ("フィードバック位置", {"position": MEASURED}),
        # words that only look like compounds
        ("fist", {}),
        ("list", {}),
        ("value", {}),
    ],
)
def test_what_a_head_means(head: str, expected: dict[str, int]) -> None:
    assert meanings(take_apart(head)) == expected
