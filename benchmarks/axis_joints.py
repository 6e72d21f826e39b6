"""Three joints of a robot arm in stick-slip: one half of a log predicted from the other.

Recordings: YIZHIXIAOCANGSHU/Friction-Identification-for-Manipulators. Their controller computes a
torque once a row of the log and holds it until the next; see `hold` of the rig.

A model may be held against a half in two ways: in one simulation from its first rest, and from
each rest to the next (`restart`). And its staircase may be compared: how often it slips, how far,
for how much of the time it rests. What the slips of the measured axis scatter by is seen at their
onsets, and what such a scatter does to a prediction is tried on an axis that is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from stribeck import RIGS, Fit, identify, read
from stribeck.data.ranges import Range
from stribeck.data.recording import Recording
from stribeck.data.segmentation import segment
from stribeck.friction import law_named
from stribeck.identify.loss import SQUARES, Objective
from stribeck.identify.parameters import Parameters, partition
from stribeck.identify.score import scores
from stribeck.identify.segment import segments
from stribeck.identify.stick_slip_statistics import StickSlipStatistics
from stribeck.rig.simulated import SimulatedRig
from stribeck.space import Array
from table_head import table_head

DATA = Path(__file__).parents[2] / "shared" / "data" / "openarm"
GAINS = {1: (115.0, 5.0), 3: (35.0, 2.2), 4: (40.0, 2.0)}
#: Share of the feedback that acts, and the longest step: the held torque has no stiffness.
GAIN, STEP = 0.2, 20.0
#: Over a few tenths of a radian cos q cannot be told from a constant.
FIXED = {"g_cos": 0.0}
BOUNDS = {
    "J": (0.01, 1.0), "g_sin": (-12.0, 12.0), "g_0": (-2.0, 2.0), "F_S": (0.0, 2.0),
    "F_C": (0.0, 2.0), "F_V": (0.0, 4.0), "v_SS": (1e-3, 0.5),
}  # fmt: skip


class Model(NamedTuple):
    """A law, how it is trained, and whether F_S is the mean breakaway of the training half."""

    law: str
    roads: tuple[str, ...] = ("whole", "rest to rest")
    onsets: bool = False


PLAIN_NAME, GAUSS, ONSETS = "Coulomb-viscous", "Stribeck, exponent 2", "the same, F_S at the onsets"
MODELS = {
    PLAIN_NAME: Model("coulomb-viscous"),
    GAUSS: Model("stribeck-gauss"),
    ONSETS: Model("stribeck-gauss", ("rest to rest",), onsets=True),
    "Stribeck, exponent 1": Model("stribeck"),
    "Stribeck, exponent 2, directional": Model("stribeck-gauss-directional"),
}
ROADS = {"whole": False, "rest to rest": True}
#: Their names in the tables.
WORDS = {"whole": "whole", "rest to rest": "legs"}
#: Slips shorter than this are creep, rad.
SHORTEST = 4e-3
#: Seeds of the known axes.
SEEDS = (1, 2)
#: Whether their breakaway scatters, by their name in the file.
KINDS = {"scattered": 1.0, "steady": 0.0}

Keep = Callable[[str, Callable[[], Any]], Any]


class Half(NamedTuple):
    """Half a log, cut at a rest."""

    log: Recording
    range: str


def measure(keep: Keep, *, quick: bool = False) -> dict[str, Any]:
    """All results of the joints; those on file are not measured again."""
    if not DATA.exists():
        return {}
    return {str(joint): _joint(joint, keep, quick=quick) for joint in ((3,) if quick else GAINS)}


def _joint(joint: int, keep: Keep, *, quick: bool) -> dict[str, Any]:
    log = recording(joint)
    parts = halves(log)
    results: dict[str, Any] = {
        "onsets": keep(f"joints/{joint}/onsets", partial(onsets, log)),
        "halves": {},
        "by slip": {},
        "known": {},
    }
    whole = Half(log, f"{log.t[0]:.2f}s:{log.t[-1]:.2f}s")
    for part, (train, test) in {"all": (whole, None), "1": parts, "2": parts[::-1]}.items():
        task = partial(slip_by_slip, joint, train, test)
        results["by slip"][part] = keep(f"joints/{joint}/by slip/{part}", task)
    for name in (PLAIN_NAME, ONSETS) if quick else MODELS:
        for k in (0,) if quick else (0, 1):
            for road in ("rest to rest",) if quick else MODELS[name].roads:
                key = f"{k + 1}/{name}/{road}"
                task = partial(
                    predicted, joint, parts[k], parts[1 - k], MODELS[name], restart=ROADS[road]
                )
                results["halves"][key] = keep(f"joints/{joint}/{key}", task)
    for kind in () if quick else KINDS:
        for seed in SEEDS if KINDS[kind] else SEEDS[:1]:
            key = f"{kind}/{seed}"
            task = partial(known_axis, joint, results, seed, KINDS[kind])
            results["known"][key] = keep(f"joints/{joint}/known/{key}", task)
    return results


def recording(joint: int) -> Recording:
    """The log of a joint."""
    return read(DATA / f"collect_joint_{joint}.csv")


def rig(joint: int) -> SimulatedRig:
    """The rig of a joint: its authors' gains, a torque held from row to row."""
    kp, kd = GAINS[joint]
    servo = RIGS["joint"].set(kp=kp, kd=kd, gain=GAIN, hold=1.0, step=STEP)
    assert isinstance(servo, SimulatedRig)  # noqa: S101 - it is
    return servo


def halves(log: Recording) -> tuple[Half, Half]:
    """Both halves of a log, cut in the rest that is nearest to its middle."""
    middle = 0.5 * (log.t[0] + log.t[-1])
    inside = [0.5 * (log.t[r.start] + log.t[r.stop - 1]) for r in segment(log).rests]
    cut = min(inside, key=lambda t: abs(t - middle))
    return Half(log, f"{log.t[0]:.2f}s:{cut:.2f}s"), Half(log, f"{cut:.2f}s:{log.t[-1]:.2f}s")


# --- one half from the other ----------------------------------------------------------------------


def predicted(
    joint: int, train: Half, test: Half, model: Model, *, restart: bool
) -> dict[str, Any]:
    """A model identified on one half, compared with the other in both ways."""
    fit = _fitted(joint, train, model, restart=restart)
    return {
        "train": fit.score.value,
        "evaluations": fit.search.evaluations,
        "seconds": fit.search.seconds,
        "estimates": {e.name: [e.value, e.low, e.high, e.verdict] for e in fit.estimates},
        **test_errors(fit.parameters, fit.p, test),
    }


def slip_by_slip(joint: int, train: Half, test: Half | None) -> dict[str, Any]:
    """A fit in which each slip has a breakaway of its own, beside the onsets of the same part.

    The legs of the other half are predicted with their mean: it is not known where a slip to come
    breaks away.
    """
    law = law_named(MODELS[GAUSS].law)
    names = [q.name for q in rig(joint).parameters(law) if q.name not in FIXED]
    fit = identify(
        train.log,
        rig=rig(joint),
        law=law,
        train=train.range,
        fixed=FIXED,
        bounds={n: BOUNDS[n] for n in names if n in BOUNDS},
        breakaway="scattered",
    )
    (spread,) = fit.breakaway
    return {
        "onsets": onsets(train.log, train.range),
        "train": fit.score.value,
        "evaluations": fit.search.evaluations,
        "seconds": fit.search.seconds,
        "estimates": {e.name: [e.value, e.low, e.high, e.verdict] for e in fit.estimates},
        "spread": [spread.sd, spread.low, spread.high, spread.slips],
        **({} if test is None else test_errors(fit.parameters, fit.p, test)),
    }


def _fitted(joint: int, half: Half, model: Model, *, restart: bool) -> Fit:
    fixed = dict(FIXED)
    if model.onsets:
        fixed["F_S"] = onsets(half.log, half.range)["F_S"]
    names = [q.name for q in rig(joint).parameters(law_named(model.law)) if q.name not in fixed]
    return identify(
        half.log,
        rig=rig(joint),
        law=model.law,
        train=half.range,
        fixed=fixed,
        bounds={n: BOUNDS[n.rstrip("+-")] for n in names if n.rstrip("+-") in BOUNDS},
        restart=restart,
        breakaway="common",
    )


def test_errors(parameters: Parameters, p: Array, test: Half) -> dict[str, Any]:
    """RMSE of the whole half and from rest to rest, mrad, and both staircases."""
    tested = Range.parse(test.range, "mrad")
    assert isinstance(parameters.rig, SimulatedRig)  # noqa: S101 - it is
    whole = scores(
        replace(parameters, objective=SQUARES), p, segments([test.log], parameters.rig, tested)
    )
    legs = segments([test.log], parameters.rig, tested, Objective(restart=True))
    rested = scores(replace(parameters, objective=Objective(restart=True)), p, legs)
    return {
        "whole": whole.value,
        "rest to rest": rested.value,
        "still": rested.still,
        "measured": _stairs(whole.measured),
        "modelled": _stairs(whole.modelled),
    }


def _stairs(statistics: StickSlipStatistics | None) -> list[float] | None:
    if statistics is None:
        return None
    return [statistics.slips, 1e3 * statistics.jump, statistics.stuck]


# --- breakaway at the onsets of slips -------------------------------------------------------------


def onsets(log: Recording, part: str | None = None) -> dict[str, Any]:
    """The breakaway torque over all slips: its mean, scatter and interval.

    The last row before slip i computed a torque that the axis did not bear; the one before that
    it did. Half-way between them, friction is at its breakaway level: the torque there is
    s_i F_S + g_sin sin q_i + g_0 with the slip's direction s_i. Least squares over all slips gives
    the mean F_S and gravity, and what is left is the scatter.
    """
    slips = [s for s in segment(log).slips if abs(s.jump) > SHORTEST]
    if part is not None:
        span = Range.parse(part, "mrad")
        slips = [s for s in slips if span.start <= log.t[s.start] <= span.stop]
    at = np.array([s.start for s in slips])
    s = np.sign([x.jump for x in slips])
    commanded = log.extra["tau_cmd_Nm"]
    torque = 0.5 * (commanded[at] + commanded[np.maximum(at - 1, 0)])
    A = np.column_stack([s, np.sin(log.position[at]), np.ones(len(at))])
    weights, *_ = np.linalg.lstsq(A, torque, rcond=None)
    residuals = torque - A @ weights
    dof = len(at) - A.shape[1]
    sd = float(np.sqrt(residuals @ residuals / dof))
    error = sd * float(np.sqrt(np.linalg.inv(A.T @ A)[0, 0])) * float(stats.t.ppf(0.975, dof))
    return {
        "slips": len(at),
        "F_S": float(weights[0]),
        "interval": [float(weights[0]) - error, float(weights[0]) + error],
        "scatter": sd,
        "g_sin": float(weights[1]),
        "g_0": float(weights[2]),
    }


# --- an axis that is known ------------------------------------------------------------------------


def known_axis(joint: int, part: Mapping[str, Any], seed: int, scatter: float) -> dict[str, Any]:
    """The twin of a Stribeck axis, whose breakaway scatters as the measured one's or not at all.

    Its first half trains a Coulomb-viscous model; the second is predicted by that, and by the very
    law and parameters that made the log (the mean F_S, where it scatters).
    """
    values = {
        n: row[0] for n, row in part["halves"][f"1/{ONSETS}/rest to rest"]["estimates"].items()
    }
    share = scatter * part["onsets"]["scatter"] / part["onsets"]["F_S"]
    first, second = halves(made_log(recording(joint), joint, values, share, seed))
    parameters = partition(rig(joint), law_named(MODELS[ONSETS].law))
    p = np.array([values[q.name] for q in parameters.every])
    plain = {
        road: predicted(joint, first, second, MODELS[PLAIN_NAME], restart=restart)
        for road, restart in ROADS.items()
    }
    return {
        "truth": values,
        "share": share,
        "true": test_errors(parameters, p, second),
        "plain": {
            road: {key: row[key] for key in (*ROADS, "modelled")} for road, row in plain.items()
        },
    }


def made_log(
    log: Recording, joint: int, p: Mapping[str, float], share: float, seed: int
) -> Recording:
    """A twin of the log with the same command; a plain loop, F_S drawn at each stick."""
    rng = np.random.default_rng(seed)
    kp, kd = GAINS[joint]
    t, command, q_step = log.t, _command(log), segment(log).step
    rate, ahead = log.extra["qd_cmd_rad_s"], log.extra["tau_ff_Nm"]
    q, v, level = float(log.position[0]), 0.0, p["F_S"]
    x, torque = np.empty(len(t)), np.empty(len(t))
    for k in range(len(t)):
        x[k] = q
        torque[k] = ahead[k] + GAIN * (kp * (command[k] - q) + kd * (rate[k] - v))
        if k == len(t) - 1:
            break
        n = max(int(np.ceil((t[k + 1] - t[k]) / 5e-4)), 1)
        h = (t[k + 1] - t[k]) / n
        for _ in range(n):
            force = torque[k] - p["g_sin"] * np.sin(q) - p["g_0"]
            if v == 0.0 and abs(force) <= level:
                break
            s = np.sign(v) if v != 0.0 else np.sign(force)
            fall = (level - p["F_C"]) * np.exp(-((v / p["v_SS"]) ** 2))
            w = v + h * (force - s * (p["F_C"] + fall + p["F_V"] * abs(v))) / p["J"]
            if v * w < 0.0:
                w, level = 0.0, p["F_S"] * max(1 + share * rng.standard_normal(), 0.0)
                level = max(level, p["F_C"])
            v = w
            q += h * v
    measured = q_step * np.rint(x / q_step)
    extra = dict(log.extra) | {"tau_cmd_Nm": torque}
    return Recording(t=t, position=measured, command=command, rotary=True, extra=extra)


def _command(log: Recording) -> Array:
    assert log.command is not None  # noqa: S101 - these logs have one
    return log.command


# --- tables ---------------------------------------------------------------------------------------


def tables(results: Mapping[str, Any]) -> Iterator[str]:
    """Markdown: predictions, staircases, levels with intervals, the known axes."""
    if not results:
        return
    for section in (_predictions, _staircases, _levels, _known_axes, _slip_by_slip):
        lines = list(section(results))
        if len(lines) > _HEAD:
            yield "\n".join(lines)


#: Lines of a table without rows.
_HEAD = 3


def _rows(part: Mapping[str, Any]) -> Iterator[tuple[str, str, Mapping[str, Mapping[str, Any]]]]:
    """Half, law, and the result of each method."""
    for half in ("1", "2"):
        for name in MODELS:
            by = {road: part["halves"].get(f"{half}/{name}/{road}") for road in ROADS}
            if by["rest to rest"]:
                yield half, name, {road: row for road, row in by.items() if row}


def _predictions(results: Mapping[str, Any]) -> Iterator[str]:
    yield from table_head(
        "Arm joints: one half predicted from the other, RMSE of position / mrad",
        "joint | trained on | model | whole by whole: | ratio: | whole by legs: | ratio: | "
        "legs by legs: | ratio:",
    )
    for joint, part in results.items():
        plain: dict[str, list[float]] = {}
        for half, name, by in _rows(part):
            values = [
                by["whole"]["whole"] if "whole" in by else None,
                by["rest to rest"]["whole"],
                by["rest to rest"]["rest to rest"],
            ]
            base = plain.setdefault(half, [v for v in values if v is not None])
            cells = " | ".join(
                f"{v:.1f} | {v / b:.2f}" if v is not None else " | "
                for v, b in zip(values, _against(base), strict=True)
            )
            yield f"| {joint} | half {half} | {name} | {cells} |"


def _against(plain: Sequence[float]) -> tuple[float, float, float]:
    """The best of Coulomb-viscous friction: on whole motions, of both its trainings."""
    whole = min(plain[:-1])
    return whole, whole, plain[-1]


def _staircases(results: Mapping[str, Any]) -> Iterator[str]:
    yield from table_head(
        "Arm joints: the staircase of the half that was not seen",
        "joint | trained on | model | slips: | median jump / mrad: | stuck:",
    )
    for joint, part in results.items():
        for half, name, by in _rows(part):
            start = f"| {joint} | half {half} |"
            if name == PLAIN_NAME:
                yield f"{start} **measured** | {_steps(by['rest to rest']['measured'])} |"
            for road, row in by.items():
                yield f"{start} {name}, by {WORDS[road]} | {_steps(row['modelled'])} |"


def _steps(staircase: Sequence[float] | None) -> str:
    if not staircase:
        return "| | "
    slips, jump, stuck = staircase
    return f"{slips:.0f} | {jump:.0f} | {100 * stuck:.0f} %"


def _levels(results: Mapping[str, Any]) -> Iterator[str]:
    yield from table_head(
        "Arm joints: breakaway and sliding level / N m, 95 % intervals",
        "joint | slips: | F_S at the onsets | scatter: | trained on | F_S by legs | F_C by "
        "legs | F_C by legs, F_S at the onsets",
    )
    for joint, part in results.items():
        slips = part["onsets"]
        for half, name, by in _rows(part):
            if name != GAUSS:
                continue
            e = by["rest to rest"]["estimates"]
            rested = part["halves"].get(f"{half}/{ONSETS}/rest to rest", by["rest to rest"])
            low, high = slips["interval"]
            yield (
                f"| {joint} | {slips['slips']} | {slips['F_S']:.2f} ({low:.2f} to {high:.2f}) | "
                f"± {slips['scatter']:.2f} | half {half} | {_level(e['F_S'])} | "
                f"{_level(e['F_C'])} | {_level(rested['estimates']['F_C'])} |"
            )


def _level(row: Sequence[Any]) -> str:
    value, low, high, verdict = row
    return f"{value:.2f} ({low:.2f} to {high:.2f}), {verdict}"


def _known_axes(results: Mapping[str, Any]) -> Iterator[str]:
    yield from table_head(
        "A known axis on the same command: second half, RMSE of position / mrad",
        "joint | breakaway | seed: | whole: Coulomb-viscous: | truth: | ratio: | legs: "
        "Coulomb-viscous: | truth: | ratio:",
    )
    for joint, part in results.items():
        for key, row in part["known"].items():
            kind, seed = key.split("/")
            static_friction = (
                f"scatters by {100 * row['share']:.0f} %" if KINDS[kind] else "always the same"
            )
            whole = min(row["plain"][road]["whole"] for road in ROADS)
            legs = row["plain"]["rest to rest"]["rest to rest"]
            a, b = row["true"]["whole"], row["true"]["rest to rest"]
            yield (
                f"| {joint} | {static_friction} | {seed} | {whole:.1f} | {a:.1f} "
                f"| {a / whole:.2f} | {legs:.1f} | {b:.1f} | {b / legs:.2f} |"
            )


def _slip_by_slip(results: Mapping[str, Any]) -> Iterator[str]:
    yield from table_head(
        "Arm joints slip by slip: breakaway / N m, and legs not seen, RMSE / mrad",
        "joint | trained on | slips: | F_S at the onsets | F_S | their scatter: | scatter | "
        "legs: Coulomb-viscous: | slip by slip: | ratio:",
    )
    for joint, part in results.items():
        for name, row in part.get("by slip", {}).items():
            seen, (sd, low, high, slips) = row["onsets"], row["spread"]
            plain = part["halves"].get(f"{name}/{PLAIN_NAME}/rest to rest")
            legs = " | | "
            if plain is not None and "rest to rest" in row:
                a, b = plain["rest to rest"], row["rest to rest"]
                legs = f"{a:.1f} | {b:.1f} | {b / a:.2f}"
            first, last = seen["interval"]
            rows = name if name == "all" else f"half {name}"
            yield (
                f"| {joint} | {rows} | {slips} | {seen['F_S']:.2f} ({first:.2f} to {last:.2f}) | "
                f"{_level(row['estimates']['F_S'])} | "
                f"{seen['scatter']:.2f} | {sd:.2f} ({low:.2f} to {high:.2f}) | {legs} |"
            )
