"""The scale of a compensation of identified friction, tried on every axis that a card allows.

The compensator believes the card. The axes that it is tried on are the card's and those at the
ends of its intervals, so what comes out holds for more than a perfect model, though not for every
combination of parameters within their intervals. Each is driven over several reference motions at
a range of scales (the share of the model's friction that is compensated), beside the same axis
without compensation, with the law asked at

- `reference`: the reference's velocity;
- `crossover`: the measured one up to the speed up to which friction falls, and the reference's
  where that is faster: what falls is undone, what damps is left;
- `feedback`: the measured one at any speed.

The recommended scale is the one with the least worst RMS ratio (with over without, over all axes
and motions) among those that show no sign of too much (`limit_cycle`) anywhere, lie at least MARGIN
below the first scale that does, and are not above WHOLE: what more than the whole friction gains
is the loop's own lag, which is not friction's to mend. The simpler mode is taken where it is as
good.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..data.log_list import Columns, Logs, log_list
from ..data.recording import Recording
from ..errors import InputError
from ..identify.card import Card, Carded, axis_table, card_of, constant_cards, kind_of
from ..identify.pace import Pace, paced
from ..presenters import presenter
from ..rig.balanced import BalancedRig
from ..rig.lookup import rig_and_law
from ..rig.two_masses import MOTOR_POSITION, OF_MOTOR, SIDES, TwoMassRig
from ..units import unit
from ..wording import either, option
from .closed_loop import IDEAL, controlled
from .compensator import TINY, Compensator, sensor_dead_band
from .corners import plants
from .reference_motions import LONG, references
from .scale_curve import MARGIN, ScaleCurve, scale_curve
from .stability import Sliding, sliding
from .trial import Mode, TrackingTrace, Trial

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from ..friction import Law
    from ..rig import Rig
    from ..rig.controller import LinearLoop
    from ..rig.position_loop import PositionLoop
    from ..space import Array
    from .closed_loop import Reference, Sensor

#: Modes, the simpler before.
MODES: tuple[Mode, ...] = ("reference", "crossover", "feedback")

#: The simpler mode is recommended if its worst ratio is at most so many times the other's.
AS_GOOD = 1.1
#: Dead band of a sensor without steps, as a share of the slowest reference's speed.
_STILL = 1e-3
#: Friction that falls by less than this share of its greatest from rest on has no falling part that
#: feedback had to undo.
_FALLS = 0.02
#: A law that gives less than this share of its greatest friction beside rest has no level there.
_LEVEL = 0.5


@dataclass(frozen=True, eq=False)
class Compensation:
    """What was tried, and what is recommended.

    Args:
        law: The law's name.
        rig: The rig; its units are those that people are shown.
        period: Sample time of the controller, s.
        sensor: How the compensator sees.
        motions: Names of the reference motions, (M,).
        plants: Names of the axes, (P,); the first is the identified one.
        curves: One for each mode that was tried.
        frictionless: RMS tracking error of the identified axis had it no friction, m or rad, (M,).
        slides: Steady sliding of the identified axis at the greatest speeds of the motions, by
            the eigenvalues of the loop.
        mode: The recommended mode; None where no scale is safe and better.
        compensator: Its settings.
        margin: Between the recommended scale and the first sign.
        traces: What the recommended compensator does to the identified axis.
        notes: What else a reader must know.
    """

    law: str
    rig: Rig
    period: float
    sensor: Sensor
    motions: tuple[str, ...]
    plants: tuple[str, ...]
    curves: tuple[ScaleCurve, ...]
    frictionless: Array
    slides: tuple[Sliding, ...]
    mode: Mode | None
    compensator: Compensator | None
    margin: float
    traces: tuple[TrackingTrace, ...]
    notes: tuple[str, ...]

    @property
    def curve(self) -> ScaleCurve | None:
        """Of the recommended mode."""
        return next((c for c in self.curves if c.mode == self.mode), None)

    def __repr__(self) -> str:
        axis = f"{self.law} on {self.rig.name}"
        if self.compensator is None:
            return f"<Compensation of {axis}: no scale is safe and better>"
        return f"<Compensation of {axis}: {self.mode}, scale {self.compensator.scale:.4g}>"

    def _repr_html_(self) -> str:
        return str(presenter("compensation_html")(self))


def compensate(
    model: Card | Carded | str | Path,
    rig: str | Rig | None = None,
    *,
    loop: PositionLoop | None = None,
    logs: Logs | None = None,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
    speed: float | None = None,
    period: float = 1e-3,
    mode: Mode | None = None,
    scale: float | None = None,
    reference: Reference | None = None,
    sensor: Sensor = IDEAL,
    beside: Mapping[str, Array] | None = None,
    progress: Callable[[str], object] | None = None,
) -> Compensation:
    """Try compensations of an identified friction, and recommend one.

    Args:
        model: What was identified: a fit, its card, or the file of one.
        rig: The axis that is to be compensated; the card's own by default. It must have the
            parameters of the card.
        loop: The controller around it, where the rig has none of its own.
        logs: Logs, as `identify` takes them, whose command sets speed and travel of the reference
            motions; by default those that the card remembers.
        units: Unit by column, as for `identify`.
        columns: Column by channel, as for `identify`.
        subtract: As for `identify`; by default what the card says.
        speed: Of the slowest, m/s or rad/s, in place of the logs'.
        period: Sample time of the controller, s.
        mode: Try this one only.
        scale: Try this scale only.
        reference: Follow this in place of the usual motions.
        sensor: How the compensator sees the position.
        beside: Further axes to try, parameter sets by name, SI.
        progress: Called with what is being tried.

    Raises:
        InputError: a rig without a controller, a card that is not of this rig, or no speed.
    """
    if not 0 < period < np.inf:
        raise InputError(f"{option('period')}: give a time above 0 s, got {period:g}")
    if scale is not None and not 0 < scale < np.inf:
        raise InputError(f"{option('scale')}: give a number above 0, got {scale:g}")
    card = card_of(model)
    rig = None if rig is None else rig_and_law(rig, None)[0]
    if rig is not None and loop is None:
        controlled(rig)
    parameters, p = _card_on(card, rig).model()
    recordings = (
        []
        if logs is None
        else log_list(
            logs, units=units, columns=columns, usual=parameters.rig.columns, subtract=subtract
        )
    )
    axis_rig = around(parameters.rig, loop)
    axes, notes = plants(card, parameters, p)
    if card.speeds is not None and card.speeds.one_way:
        notes.append(f"{card.speeds.one_way}: what is tried and recommended holds one way only")
    axes |= beside or {}
    linear = _linear(axis_rig, parameters.law, p, period)
    motions = (
        (reference,)
        if reference is not None
        else _motions(axis_rig, _pace(card, recordings), speed, period, linear.period)
    )
    shape = _shape(axis_rig, parameters.law, p, motions, sensor, notes)
    trial = Trial(axis_rig, parameters.law, p, axes, motions, shape, sensor)
    baseline = trial.tried(0.0, "reference", None)
    curves = []
    for each_mode in _modes(shape, mode):
        if progress is not None:
            progress(f"{each_mode}: {len(axes)} axes, {len(motions)} motions")
        curves.append(scale_curve(trial, each_mode, baseline, scale))
    chosen = _chosen(curves)
    settings = None
    if chosen is not None and chosen.scale is not None:
        settings = trial.settings(chosen.scale, chosen.mode)
    friction = p[: len(parameters.law.params)]
    return Compensation(
        parameters.law.name, axis_rig, period, sensor, tuple(m.name for m in motions),
        tuple(axes), tuple(curves), trial.frictionless(),
        tuple(
            sliding(linear, parameters.law, friction, float(m.v[np.argmax(np.abs(m.v))]), period)
            for m in motions
        ),
        None if chosen is None else chosen.mode, settings, MARGIN, trial.traces(settings),
        tuple(notes),
    )  # fmt: skip


def around(rig: Rig, loop: PositionLoop | None) -> Rig:
    """A rig with a controller: its own, or the one stated.

    Raises:
        InputError: it has one of its own, or none and none is stated; or its friction is in A, or
            it has two masses.
    """
    rig.check_newtons("a controller's output")
    if isinstance(rig, TwoMassRig):
        raise InputError(
            f"rig {rig.name} has two masses, and a compensation is tried on an axis of one: in "
            f"its file {_as_one_mass(rig)}, and identify again"
        )
    if loop is not None:
        if rig.controller() is not None and not isinstance(rig, BalancedRig):
            raise InputError(
                f"rig {rig.name} has a controller with gains of its own: set those by "
                f"{either('--rig FILE', 'rig.set(...)')}, and leave kp and kd out of the loop"
            )
        rig = replace(rig, loop=loop)
    controlled(rig)
    return rig


def _as_one_mass(rig: TwoMassRig) -> str:
    """What makes an axis of one mass of the file of one of two, in words."""
    table = rig.table or {}
    ratio = next((c.value for c in rig.constants if c.name == "gear_ratio"), 1.0)
    rigid = "[transmission.rigid]"
    if ratio != 1.0:
        rigid = f"[transmission.gear] with gear_ratio = {ratio:.10g}"
        if not rig.rotary:
            rigid = f"[transmission.screw] with lead = {2.0 * np.pi / ratio:.10g}"
    left = [f"[sensor.{side}]" for side in SIDES if side in table.get("sensor", {})]
    left += ["[friction]"] if table.get("friction") else []
    left += [f"[inputs] {MOTOR_POSITION}"] if MOTOR_POSITION in table.get("inputs", {}) else []
    coupling = {c.name for p in rig.parts if p.role == "transmission" for c in p.coefficients}
    odd = [n for n in table.get("ranges", {}) if n in coupling or n.endswith(OF_MOTOR)]
    left += [f"the ranges of {', '.join(odd)}"] if odd else []
    leave = f" and leave out {', '.join(left)}" if left else ""
    return f"write {rigid} for [transmission.compliant]{leave}"


def _modes(shape: Compensator, mode: Mode | None) -> tuple[Mode, ...]:
    """Those to try: feedback up to a crossover needs a friction that falls up to one."""
    if mode == "crossover" and not shape.crossover:
        raise InputError(
            "mode crossover: the identified friction does not fall up to a speed between those "
            "of the slowest and the fastest motion"
        )
    if mode is not None:
        return (mode,)
    return tuple(m for m in MODES if m != "crossover" or shape.crossover)


def _card_on(card: Card, rig: Rig | None) -> Card:
    """The card as if it had been identified on another rig of the same parameters."""
    if rig is None:
        return card
    kind = kind_of(rig)
    if odd := [c.name for c in rig.constants if not np.isfinite(c.value)]:
        raise InputError(f"rig {rig.name}: {odd[0]} is not a finite number: a card cannot say that")
    return card.model_copy(
        update={
            "rig": rig.name,
            "kind": kind,
            "axis": axis_table(rig),
            "constants": constant_cards(rig),
            "columns": {},
        }
    )


def _pace(card: Card, recordings: Sequence[Recording]) -> Pace | None:
    """How the logs move, as they say or as the card remembers."""
    if recordings:
        return paced(recordings)
    if card.pace is not None:
        return Pace(card.pace.speed, card.pace.travel, card.pace.start)
    return None


def _motions(
    rig: Rig, pace: Pace | None, speed: float | None, period: float, swing: float
) -> tuple[Reference, ...]:
    if speed is not None and not 0 < speed < np.inf:
        raise InputError(f"speed: give a number above 0, got {speed:g}")
    if pace is None and speed is None:
        raise InputError(
            f"rig {rig.name}: no log says how fast the axis is driven: give speed, that of the "
            "slowest motion, or reference, a log to follow"
        )
    slow = speed if speed is not None else pace.speed if pace is not None else 0.0
    travel, start = (np.inf, 0.0) if pace is None else (pace.travel, pace.start)
    return references(slow, min(travel, LONG * slow), start, period, swing)


def _linear(rig: Rig, law: Law, p: Array, period: float) -> LinearLoop:
    """The loop of the identified axis without friction."""
    controller, t = controlled(rig), period * np.arange(3.0)
    track = controller.track(Recording(t=t, position=t, command=t, rotary=rig.rotary))
    return controller.linear(law, p, track)


def _shape(
    rig: Rig, law: Law, p: Array, motions: Sequence[Reference], sensor: Sensor, notes: list[str]
) -> Compensator:
    """The settings beside scale and mode: what the drive eats, what counts as rest.

    The sensor's dead band is one for the measured speed. A reference is known as it is: its own
    dead band is that of a sensor without steps.
    """
    h = motions[0].h
    moving = [np.abs(m.v)[np.abs(m.v) > 1e-3 * np.abs(m.v).max()] for m in motions]
    if not all(len(v) for v in moving):
        raise InputError(f"reference {motions[0].name}: it does not move: nothing to compensate")
    slowest = min(float(np.median(v)) for v in moving)
    blind = sensor_dead_band(sensor.resolution, h) + 3.0 * np.sqrt(2.0) * sensor.noise / h
    still = _readable(_STILL * slowest)
    if blind > 0.5 * slowest:
        cause = " and ".join(
            word for word, value in (("steps", sensor.resolution), ("noise", sensor.noise)) if value
        )
        name = rig.unit_shown("velocity")
        seen, slow = (f"{unit(name).from_si(v):.3g}" for v in (blind, slowest))
        notes.append(
            f"the sensor's {cause} hide speeds up to {seen} {name} at a period of {h * 1e3:g} ms, "
            f"and the slowest motion has {slow}: feedback does not tell it from rest; a finer "
            "sensor or a longer period would"
        )
    return Compensator(
        dead_band=max(_readable(blind), still),
        drive=rig.drive_friction(),
        rest=_rest(law, p, slowest),
        reference_band=still,
        crossover=_crossover(law, p, slowest, max(float(v.max()) for v in moving)),
    )


def _readable(value: float) -> float:
    """A setting as people read it."""
    return float(f"{value:.4g}")


def _crossover(law: Law, p: Array, slowest: float, fastest: float) -> float:
    """The speed up to which friction falls, the greater of both directions, m/s or rad/s.

    0 where it falls nowhere, not as far as the slowest motion (there it is the reference's mode),
    or as far as the fastest (there it is feedback).
    """
    speeds = np.geomspace(1e-4 * fastest, fastest, 400)
    ends = [0.0]
    for sign in (1.0, -1.0):
        level = np.abs(law.friction(sign * speeds, p[: len(law.params)]))
        least = int(np.argmin(level))
        if level[: least + 1].max() - level[least] > _FALLS * level.max():
            ends.append(float(speeds[least]) if least < len(speeds) - 1 else 0.0)
    return _readable(max(ends)) if max(ends) > slowest else 0.0


def _rest(law: Law, p: Array, slowest: float) -> float:
    """The speed at which a resting axis asks a law: beside rest, or where a smooth one peaks."""
    speeds = np.geomspace(TINY, slowest, 200)
    friction = law.friction(speeds, p[: len(law.params)])
    if friction[0] >= _LEVEL * friction.max():
        return TINY
    return float(speeds[int(np.argmax(friction))])


def _chosen(curves: Sequence[ScaleCurve]) -> ScaleCurve | None:
    """The mode that is recommended: the simpler one if it is as good."""
    usable = [c for c in curves if c.best is not None]
    if not usable:
        return None
    least = min(c.worst[c.best] for c in usable)
    return next(c for c in usable if c.worst[c.best] <= AS_GOOD * least)  # the simpler comes first
