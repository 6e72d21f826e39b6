"""Units: everyday ones are read as by pint."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys

import pytest

from stribeck.errors import InputError
from stribeck.units import EVERYDAY, Unit, _asked, _everyday, convertible, percent, two_digits, unit

FORMS = [
    "{a}", "1/{a}", "{a}**2", "{a}/{b}", "{a} {b}", "{a}*{b}", "{a}/{b}**2", "{a}/{b}/{a}",
    "{b}*{a}**2/{b}/{a}**3", "{b} {a}/({b} {a})", "{b}/{a}/({b} {a})",
]  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_what_is_read_here_is_bit_for_bit_what_pint_says(form: str) -> None:
    read = 0
    for a, b in itertools.product([*EVERYDAY, "degC"], EVERYDAY):
        text = form.format(a=a, b=b)
        if (parsed := _everyday(text, text)) is not None:
            assert parsed == _asked(text, text), text
            read += 1
    assert read >= len(EVERYDAY)


@pytest.mark.parametrize(
    ("written", "factor", "dimension"),
    [
        ("N s/mm", 1e3, "kg/s"),
        ("N_s_mm", 1e3, "kg/s"),
        ("mm_s2", 1e-3, "m/s**2"),
        ("Nm", 1.0, "kg*m**2/s**2"),
        ("N m s/rad", 1.0, "kg*m**2/rad/s"),
        ("V s/m", 1.0, "kg*m/A/s**2"),
        ("", 1.0, ""),
        ("m/m", 1.0, ""),
        ("ms**2", 1e-6, "s**2"),
        ("N/s m", 1.0, "kg*m**2/s**3"),
        ("oz", 0.028349523125, "kg"),
        ("%", 0.01, ""),
        ("‰", 0.001, ""),
        ("rev", 2 * math.pi, "rad"),
        ("r/min", 2 * math.pi / 60, "rad/s"),
        ("tr/min", 2 * math.pi / 60, "rad/s"),
        ("U/min", 2 * math.pi / 60, "rad/s"),
        ("1/min", 2 * math.pi / 60, "rad/s"),
        ("min-1", 2 * math.pi / 60, "rad/s"),
        ("rev/s2", 2 * math.pi, "rad/s**2"),
        ("inc", 1.0, "count"),
        ("pulses", 1.0, "count"),
        ("inc/s", 1.0, "count/s"),
        ("counts/s", 1.0, "count/s"),
        ("N-m", 1.0, "kg*m**2/s**2"),
    ],
)
def test_units_that_logs_are_in(written: str, factor: float, dimension: str) -> None:
    parsed = unit(written)
    assert parsed.factor == pytest.approx(factor, rel=1e-15)
    assert parsed == Unit(written, parsed.factor, 0.0, dimension)


def test_a_rig_and_its_log_need_no_registry() -> None:
    code = "import sys, stribeck; list(stribeck.RIGS.values()); print('pint' in sys.modules)"
    completed = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert completed.stdout.strip() == "False"


def test_a_temperature_has_its_zero_elsewhere() -> None:
    assert unit("degC").to_si(20.0) == pytest.approx(293.15)
    assert convertible("degC", "K")


@pytest.mark.parametrize("written", ["mmm", "N/", "(N)", "1/", "N//s", "m***2", "2", "N/(s", "s)"])
def test_what_nobody_reads_is_refused_or_left_to_pint(written: str) -> None:
    try:
        pint_unit = _asked(written, written)
    except InputError:
        with pytest.raises(InputError, match="unknown unit"):
            unit(written)
    else:
        assert unit(written) == pint_unit


def test_numbers_for_people_have_two_digits_and_no_exponent() -> None:
    shown = [two_digits(x) for x in (0.0123, 1.26, 9.94, 12.6, 549.0, 5.5e4)]
    assert shown == ["0.012", "1.3", "9.9", "13", "549", "55000"]
    assert [percent(x) for x in (0.0126, 3.73)] == ["1.3 %", "373 %"]
