"""Simulated motions as files: the twin's log and its truth, and what a card predicts."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..data.readers.raw_table import printable
from ..errors import InputError
from ..rig.rig import shown_in
from ..units import unit
from ..wording import option
from .folder import check_file, write_all, write_text

#: Samples of a ramp, and of a run, that make a log.
FEWEST, MOST = 10, 5_000_000

if TYPE_CHECKING:
    from pathlib import Path

    from ..data.recording import Recording
    from ..rig import Rig
    from ..rig.twin import TestBed
    from ..space import Array


def write_twin(bed: TestBed, direction: Any, seed: int, out: Path) -> list[Path]:
    """Record a run of the test bed; write the log, and the truth beside it, never into it.

    Returns the two files: OUT.csv and OUT.truth.json.
    """
    beside = out.with_name(f"{out.stem}.truth.json")
    check_file(out, ".csv")
    check_file(beside)
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    _check_size(bed, direction)
    twin = bed.run(direction, seed=seed)
    log = twin.recording
    assert log.command is not None  # noqa: S101 - the test bed records all of these
    assert log.velocity is not None  # noqa: S101
    assert log.current is not None  # noqa: S101
    assert log.force is not None  # noqa: S101
    columns = {
        "t_s": (log.t, 6),
        "command_mm": (log.command * 1e3, 6),
        "position_mm": (log.position * 1e3, 4),
        "velocity_mm_s": (log.velocity * 1e3, 4),
        "current_A": (log.current, 6),
        "force_N": (log.force, 4),
    }
    every = bed.rig.parameters(twin.law)
    truth = {
        "schema": "stribeck-truth/1",
        "log": printable(out.name),
        "law": twin.law.name,
        "rig": bed.rig.name,
        "seed": seed,
        "direction": direction,
        "parameters": {
            q.name: {"value": float(shown_in(bed.rig, q, v)), "unit": bed.rig.unit_of(q)}
            for q, v in zip(every, twin.truth, strict=True)
        },
        "sensors": {
            "rate_hz": bed.rate,
            "echo_rate_hz": bed.echo_rate,
            "echo_noise_mm": bed.echo_noise * 1e3,
            "current_noise_A": bed.current_noise,
            "differentiator_corner_hz": bed.corner,
            "converter_bits": bed.bits,
        },
        "loop": _loop(bed),
        "constants": {c.name: {"value": c.shown, "unit": c.unit} for c in bed.rig.constants},
        "software": {"stribeck": __version__},
    }
    texts = {out.name: _csv(columns), beside.name: json.dumps(truth, indent=2, ensure_ascii=False)}
    write_all(out.parent, {name: f"{text.rstrip()}\n".encode() for name, text in texts.items()})
    return [out, beside]


def _loop(bed: TestBed) -> dict[str, Any]:
    """How the loop was closed."""
    if bed.loop == "ideal":
        return {"closed": "ideal"}
    return {
        "closed": "sensors",
        "mode": bed.mode,
        "rate_hz": bed.loop_rate,
        "held": bed.held,
        "supply_V": bed.supply,
        "resistance_ohm": bed.resistance,
        "current_limit_A": bed.current_limit,
    }


def _check_size(bed: TestBed, direction: Any) -> None:
    """A run is neither over before it is sampled nor larger than a file should be."""
    drive, _ = bed.drive(direction)
    ramp = (bed.high - bed.low) / bed.speed
    for name, rate in (("rate", bed.rate), ("echo_rate", bed.echo_rate)):
        if not rate >= FEWEST / ramp:
            raise InputError(
                f"a ramp of {ramp:.3g} s has fewer than {FEWEST} samples at "
                f"{option(name, rate)}: sample faster or move slower"
            )
        if not rate <= MOST / float(drive.t[-1]):
            raise InputError(
                f"a run of {drive.t[-1]:.3g} s has more than {MOST:,} samples at "
                f"{option(name, rate)}: sample slower or move faster"
            )


def check_motion(out: Path, log: Path) -> None:
    """Say before the work starts that a motion could not be written to a file.

    Raises:
        InputError: it cannot be written there, or it is the log itself.
    """
    check_file(out, ".csv")
    if out.exists() and log.exists() and out.samefile(log):
        raise InputError(f"{out}: is the log itself: take another name for the motion")


def write_motion(rig: Rig, motion: Recording, out: Path) -> None:
    """Write a simulated motion in the units that its rig shows."""
    assert motion.velocity is not None  # noqa: S101 - a simulated motion has both
    assert motion.force is not None  # noqa: S101
    length = rig.shows.get("position", "rad" if motion.rotary else "m")
    speed = rig.shows.get("velocity", "rad/s" if motion.rotary else "m/s")
    force = "Nm" if motion.rotary else "N"
    columns = {
        "t_s": (motion.t, 9),
        f"position_{length}": (unit(length).from_si(motion.position), 9),
        f"velocity_{speed.replace('/', '_')}": (unit(speed).from_si(motion.velocity), 9),
        f"force_{force}": (motion.force, 6),
    }
    write_text(out, _csv(columns))


def _csv(columns: dict[str, tuple[Array, int]]) -> str:
    rows = np.column_stack([values for values, _ in columns.values()])
    form = ",".join(f"%.{digits}f" for _, digits in columns.values())
    return "\n".join([",".join(columns), *(form % tuple(row) for row in rows.tolist()), ""])
