"""The current model of an axis: a card and its logs before the next experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...friction import LOADS
from ...rig.balanced import BalancedRig, as_balanced
from ...rig.experiments.offer import Exposure
from ...rig.rig import in_si
from ...rig.simulated import SimulatedRig, as_simulated
from ...space import Array, Param
from ...units import unit
from ..balance.force_residuals import BalanceResiduals
from ..balance.regression import System
from ..balance.rows import filtered_logs
from ..balance.training_rows import counting
from ..data_split import range_list, ranges_or_all
from ..initial_state import FreeStartProblem, free_starts
from ..parameters import Parameters, partition
from ..problem import MotionProblem
from ..segment import Segment, segments
from ..uncertainty.covariance import quick_look
from ..uncertainty.residuals import physical as meaningful
from ..uncertainty.sensor_noise import rest_noise
from .experiment import Experiment, PriorBox, decades, slopes
from .identified_axis import IdentifiedAxis, counted, operating_range, speeds

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ...data.zero_phase import Samples
    from ...rig import Rig
    from ..balance.rows import Log
    from ..card import Card, ParameterCard

#: Beside the data, a parameter is known to so many half-widths of its interval.
WIDE = 3.0
#: The odd sample that a greatest acceleration leaves out.
_ODD = 0.99


@dataclass(frozen=True, eq=False)
class CurrentModel:
    """What is known now.

    Args:
        axis: The axis, as its logs show it.
        data: The data at hand as an experiment.
        half: Half-widths of the intervals on the card, in the parameters' scales, (dim,).
        labels: What people call the free parameters.
        cards: What the card says of them.
        explained: The misfit as a share of that of a smooth motion, or of the force itself.
        notes: What is odd about the logs, a sentence each.
    """

    axis: IdentifiedAxis
    data: Experiment
    half: Array
    labels: tuple[str, ...]
    cards: tuple[ParameterCard, ...]
    explained: float
    notes: tuple[str, ...]

    def ends(self, i: int, factor: float) -> tuple[float, float]:
        """The ends of the i-th interval, shrunk by a factor about the value, in its unit."""
        q, box, x = self.axis.parameters.free[i], self.axis.box, self.axis.x
        scaled = box.scaled(x)
        ends_of_interval = []
        for sign in (-1.0, 1.0):
            s = scaled.copy()
            s[i] += sign * self.half[i] / factor
            ends_of_interval.append(float(np.clip(box.plain(s)[i], q.lower, q.upper)))
        rig = self.axis.parameters.rig
        return _shown(rig, q, ends_of_interval[0]), _shown(rig, q, ends_of_interval[1])

    @property
    def simulated(self) -> bool:
        """Whether motions are simulated rather than forces balanced."""
        return self.axis.parameters.rig.approach == "output_error"


def current_model(card: Card, logs: Sequence[Recording]) -> CurrentModel:
    """A card with the logs that it was identified on.

    Raises:
        InputError: a card or logs that do not fit.
    """
    shipped, p = card.model()
    parameters = _freed(card, shipped)
    values = dict(zip((q.name for q in parameters.every), p, strict=True))
    x = np.array([values[q.name] for q in parameters.free])
    model_of = _balanced if parameters.rig.approach == "force_balance" else _moved
    axis, data = model_of(
        card, parameters, x, [parameters.rig.in_step(log, card.delay) for log in logs]
    )
    labels = tuple(parameters.rig.label(q.name) for q in parameters.free)
    cards = [card.parameters[n] for n in labels]
    by_log = axis.box.log.tolist()
    half = np.array(
        [_half(q, c, by_log=b) for q, c, b in zip(parameters.free, cards, by_log, strict=True)]
    )
    return CurrentModel(
        axis,
        data,
        half,
        labels,
        tuple(cards),
        _explained(card),
        _unknown_logs(card, logs),
    )


def _freed(card: Card, shipped: Parameters) -> Parameters:
    """The parameters of a card, those free again that were found."""
    rig, law = shipped.rig, shipped.law
    free = {n: c for n, c in card.parameters.items() if c.verdict != "fixed"}
    if not free:
        raise InputError("every parameter of the card is fixed: there is nothing to plan for")
    fixed = {n: c.value for n, c in card.parameters.items() if c.verdict == "fixed"}
    bounds = {}
    params = {rig.label(q.name): q for q in rig.parameters(law)}
    for name, c in free.items():
        q = params[name]
        ends = [in_si(rig, q, v) for v in (c.value, c.low, c.high) if v is not None]
        if q.fixed is not None or min(ends) < q.lower or max(ends) > q.upper:
            lower, upper = (q.lower, q.upper) if q.fixed is None else (min(ends), max(ends))
            widened = (min(lower, *ends), max(upper, *ends))
            bounds[name] = (_shown(rig, q, widened[0]), _shown(rig, q, widened[1]))
    tied = _ties(free)
    fixed = {n: _to_shown(rig, params[n], card.parameters[n]) for n in fixed}
    bounds = {n: b for n, b in bounds.items() if n not in tied}
    return partition(rig, law, fixed=fixed, bounds=bounds, tied=tied)


def _ties(free: Mapping[str, ParameterCard]) -> dict[str, str]:
    """Parameters of the two directions that are the same number: one was tied to the other."""
    return {
        name: f"{name[:-1]}+"
        for name, c in free.items()
        if name.endswith("-")
        and (partner := free.get(f"{name[:-1]}+")) is not None
        and (c.value, c.low, c.high) == (partner.value, partner.low, partner.high)
    }


def _shown(rig: Rig, q: Param, value: float) -> float:
    return float(unit(rig.unit_of(q)).from_si(value))


def _to_shown(rig: Rig, q: Param, c: ParameterCard) -> float:
    return _shown(rig, q, float(unit(c.unit).to_si(c.value)))


def _half(q: Param, c: ParameterCard, *, by_log: bool) -> float:
    """Half of an interval in the parameter's scale; of the search range where an end is open."""
    ends = (q.lower, q.upper)
    if c.low is not None and c.high is not None:
        interval = [float(unit(c.unit).to_si(v)) for v in (c.low, c.high)]
        if interval[0] < interval[1] and (interval[0] > 0 or not by_log):
            ends = (interval[0], interval[1])
    return 0.5 * float(np.log(ends[1] / ends[0])) if by_log else 0.5 * (ends[1] - ends[0])


def _explained(card: Card) -> float:
    """The misfit of a card, as a share of doing without a model."""
    if card.objective.unit == "%":
        return card.objective.value / 100
    without = card.objective.baselines.get("smooth", np.inf)
    return card.objective.value / without if without > 0 else np.inf


def _unknown_logs(card: Card, logs: Sequence[Recording]) -> tuple[str, ...]:
    """A sentence for each log that the card does not know."""
    hashes = {d.sha256 for d in card.data}
    return tuple(
        f"{log.label} is not a log that the card was identified on: what is known now is taken "
        "from it all the same"
        for log in logs
        if log.source.sha256 and log.source.sha256 not in hashes
    )


_Seen = tuple[IdentifiedAxis, Experiment]


def _moved(card: Card, parameters: Parameters, x: Array, logs: Sequence[Recording]) -> _Seen:
    """Axis and data of a rig that is simulated."""
    rig = as_simulated(parameters.rig)
    train = [s for r in ranges_or_all(card.train or None, rig) for s in segments(logs, rig, r)]
    problem_of_motion = MotionProblem(parameters, train)
    started = free_starts(problem_of_motion)
    problem = FreeStartProblem(problem_of_motion) if started else problem_of_motion
    at = np.concatenate([x, problem.nominal]) if isinstance(problem, FreeStartProblem) else x
    scale, box = problem_of_motion.scale, _box(card, parameters)

    def predict(rows: Array) -> Array:
        outputs: Array = -scale * problem.residuals(rows)
        return outputs

    residuals = scale * problem.residuals(at[None])[0]
    if not np.isfinite(residuals).all():
        raise InputError("the model of the card cannot be simulated on these logs: check the card")
    data = _data(predict, len(x), len(at) - len(x))
    at_starts = _around(data, at, len(x))
    J = slopes(at_starts, x, box)
    quick = quick_look(J, residuals, problem.logs)
    trained = [counted(log, _rows_of(train, log)) for log in logs]
    seconds, n = (float(sum(part)) for part in zip(*trained, strict=True))
    noise = float(np.sqrt(quick.variance))
    inflation = quick.ratio[: len(x)]
    lead = [log.position if log.command is None else log.command for log in logs]
    speed_pairs = [speeds(log.t, u) for log, u in zip(logs, lead, strict=True)]
    travel = np.concatenate([np.array([u.min(), u.max()]) for u in lead])
    directions = tuple(sorted({s.direction for s in train}, reverse=True))
    shown = operating_range(
        parameters, x, logs, (1, -1) if parameters.law.directional else directions,
        interval=seconds / n, low=float(travel.min()), high=float(travel.max()),
        pace=float(np.mean([v for v, _ in speed_pairs])), fastest=max(v for _, v in speed_pairs),
        lag=max(_lag(log) for log in logs), force=max(_greatest_force(rig, log) for log in logs),
    )  # fmt: skip
    axis = IdentifiedAxis(parameters, x, box, noise, rest_noise(logs), inflation, seconds, shown)
    return axis, replace(at_starts, noise=noise, inflation=inflation, seconds=seconds)


def _greatest_force(rig: SimulatedRig, log: Recording) -> float:
    """The greatest force of the drive that a log shows; inf where nothing limits it."""
    force = None if rig.applied_force else rig.drive_force(log)
    return np.inf if force is None else float(np.abs(force).max())


def _lag(log: Recording) -> float:
    return 0.0 if log.command is None else float(np.abs(log.command - log.position).max())


def _rows_of(train: Sequence[Segment], log: Recording) -> list[slice]:
    return [s.rows for s in train if s.recording is log]


def _box(card: Card, parameters: Parameters) -> PriorBox:
    """Ranges, and that little is known beside the data: the range, or thrice the interval."""
    lower, upper = (
        np.array([getattr(q, end) for q in parameters.free]) for end in ("lower", "upper")
    )
    log = decades(lower, upper)
    ranges_of = np.where(log, np.log(np.where(log, upper / np.where(log, lower, 1.0), 1.0)),
                         upper - lower)  # fmt: skip
    half_widths = np.array([
        WIDE * _half(q, card.parameters[parameters.rig.label(q.name)], by_log=bool(by_log))
        for q, by_log in zip(parameters.free, log, strict=True)
    ])  # fmt: skip

    def allowed(x: Array) -> NDArray[np.bool_]:
        return np.asarray(
            parameters.law.physical(parameters.full(x)[:, : len(parameters.law.params)]), dtype=bool
        )

    return PriorBox(lower, upper, np.minimum(ranges_of / np.sqrt(12), half_widths), allowed)


def _data(predict: object, dim: int, starts: int) -> Experiment:
    return Experiment("the data", "what was recorded", 0.0, predict, 1.0, np.ones(dim), starts)  # type: ignore[arg-type]


def _around(data: Experiment, at: Array, dim: int) -> Experiment:
    """Data whose starts are differences from where they were seen."""
    whole, starts = data.predict, at[dim:]

    def predict(rows: Array) -> Array:
        moved = rows.copy()
        if rows.shape[1] > dim:
            moved[:, dim:] += starts
        else:
            moved = np.hstack([rows, np.tile(starts, (len(rows), 1))])
        return whole(moved)

    return replace(data, predict=predict)


def _balanced(card: Card, parameters: Parameters, x: Array, logs: Sequence[Recording]) -> _Seen:
    """Axis and data of a rig whose forces are balanced."""
    rig = as_balanced(parameters.rig)
    chosen, rows = counting(logs, range_list(card.train or None, parameters.rig))
    filtered = filtered_logs(chosen, parameters, None, rows)
    problem = BalanceResiduals(System(parameters, filtered))
    box = _box(card, parameters)

    thin = np.concatenate([log.thin(partial(_columns, log)) for log in filtered])
    v, a, loads = (np.ascontiguousarray(part) for part in (thin[:, 0], thin[:, 1], thin[:, 2:]))

    def predict(at: Array) -> Array:
        return np.array([rig.force(parameters.law, p, v, a, loads) for p in parameters.full(at)])

    data = _data(predict, len(x), 0)
    residuals = problem.residuals(x[None])[0]
    if not (np.isfinite(residuals).all() and meaningful(problem, x[None])[0]):
        raise InputError("the model of the card cannot be run on these logs: check the card")
    quick = quick_look(slopes(data, x, box), residuals, problem.logs)
    noise = float(np.sqrt(quick.variance))
    n = sum(len(log.t) for log in filtered)
    interval = float(np.median(np.concatenate([np.diff(log.t) for log in filtered])))
    q = loads[:, LOADS.index("position")]
    force = max(float(np.abs(log.force).max()) for log in filtered)
    top = float(np.abs(v).max())
    directions = tuple(s for s in (1, -1) if bool((s * v > 0.1 * top).any()))
    shown = operating_range(
        parameters, x, chosen, directions, _exposure(a, loads, rig), interval=interval,
        low=float(q.min()), high=float(q.max()), pace=float(np.abs(v).mean()), fastest=top,
        lag=0.0, force=force,
    )  # fmt: skip
    axis = IdentifiedAxis(parameters, x, box, noise, float("nan"), quick.ratio, n * interval, shown)
    return axis, replace(data, noise=noise, inflation=quick.ratio, seconds=n * interval)


def _columns(log: Log, at: Samples) -> Array:
    """Velocity, acceleration and loads side by side, (n, 7)."""
    return np.column_stack(log.motion(at))


def _exposure(a: Array, loads: Array, rig: BalancedRig) -> Exposure:
    normal = loads[:, LOADS.index("normal")]
    warm = loads[:, LOADS.index("temperature")]
    return Exposure(
        float(np.quantile(np.abs(a), _ODD)),
        (float(normal.min()), float(normal.max())) if "normal" in rig.loads else None,
        float(warm.mean()),
    )
