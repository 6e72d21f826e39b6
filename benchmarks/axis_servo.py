"""A servo with a pendulum, 16 logs at once: load-dependent friction, and gains held out.

Recordings and the published figures: Rhoban/bam, M. Duclusaud et al. (2025), arXiv 2410.08650.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from stated_model import StatedModel
from stribeck import RIGS, identify, read, validate
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.loss import Loss, Objective
from stribeck.identify.parameters import Parameters, partition
from stribeck.identify.polish import polish
from stribeck.identify.problem import MotionProblem
from stribeck.identify.selection.folds import LogRange
from stribeck.identify.selection.trained_law import BUDGET, TrainedLaw, TrainingSettings, train_law
from stribeck.space import Array
from table_head import table_head

LOGS = Path(__file__).parents[2] / "shared" / "data" / "bam_xl330" / "logs"
RIG = RIGS["servo-pendulum"]
#: The published models and their laws here; a richer one follows those it contains.
LAWS = {
    "m1": "coulomb-viscous", "m2": "stribeck-free", "m3": "bam-m3", "m4": "bam-m4",
    "m5": "bam-m5", "m6": "bam-m6",
}  # fmt: skip
GAINS = (100, 200, 400, 800)
#: The gain that takes no part in a choice.
UNSEEN = 800
LOSSES: tuple[Loss, ...] = get_args(Loss)
#: Mean absolute errors of the published parameter files on these logs, and of an independent
#: local simplex fit to them, mrad.
PUBLISHED = {"m1": 59.9, "m2": 66.8, "m6": 55.7}
SIMPLEX = {"m1": 57.2, "m2": 57.0, "m4": 43.4, "m5": 41.5}
#: Evaluations that the last refinement of absolute errors may take for each parameter.
_LAST = 25

Keep = Callable[[str, Callable[[], Any]], Any]


def measure(keep: Keep, *, quick: bool = False) -> dict[str, Any]:
    """All results of the servo; those on file are not measured again."""
    if not LOGS.exists():
        return {}
    logs = tuple(read(f, columns=dict(RIG.columns)) for f in sorted(LOGS.glob("*.json")))
    names = list(LAWS)[:3:2] if quick else list(LAWS)
    results: dict[str, Any] = {"identify": {}, "splits": {}}
    for name in names:
        task = partial(_identified, name, logs)
        results["identify"][name] = keep(f"servo/identify/{name}", task)
    for loss in LOSSES[1:] if quick else LOSSES:
        for excluded in _splits(quick=quick):
            key = f"{loss}/{'+'.join(map(str, excluded)) or 'none'}"
            task = partial(_climbed, names, logs, excluded, loss)
            results["splits"][key] = keep(f"servo/{key}", task)
    return results


def _splits(*, quick: bool) -> Iterator[tuple[int, ...]]:
    """The gains held out: none, one, and one more beside the unseen one."""
    if quick:
        yield (UNSEEN,)
        return
    yield ()
    yield from ((gain,) for gain in GAINS)
    yield from ((gain, UNSEEN) for gain in GAINS if gain != UNSEEN)


def _gain(log: Recording) -> int:
    return round(float(log.extra["kp"][0]))


# --- identify, as a user calls it -----------------------------------------------------------------


def _identified(name: str, logs: Sequence[Recording]) -> dict[str, Any]:
    start_time, used = time.perf_counter(), time.process_time()
    fit = identify(logs, rig=RIG, law=LAWS[name], loss="absolute")
    wall, cpu = time.perf_counter() - start_time, time.process_time() - used
    best = fit.search.runs[0].cost
    return {
        "mae": _mae(fit, logs),
        "repeats": [run.cost for run in fit.search.runs],
        "agreeing": sum(run.cost <= 1.01 * best for run in fit.search.runs),
        "evaluations": fit.search.evaluations,
        "search_seconds": fit.search.seconds,
        "seconds": wall,
        "processor_seconds": cpu,
        "estimates": {
            e.name: [e.value, e.low, e.high, e.verdict] for e in fit.estimates
        },
    }  # fmt: skip


# --- laws that climb on each other ----------------------------------------------------------------


def _by_absolute_errors(parameters: Parameters, p: Array) -> StatedModel:
    """A model that `validate` holds against logs by absolute errors."""
    return StatedModel(replace(parameters, objective=Objective("absolute")), p)


def _mae(model: Any, logs: Sequence[Recording]) -> float:
    """Mean over the logs of their mean absolute errors, mrad, as `validate` prints them."""
    return float(np.mean([score.value for _, _, score in validate(model, logs)]))


def _climbed(
    names: Sequence[str], logs: Sequence[Recording], excluded: tuple[int, ...], loss: Loss
) -> dict[str, Any]:
    """Each law fitted to the gains that are not held out, tested on the first that is."""
    train = [log for log in logs if _gain(log) not in excluded]
    test = [log for log in logs if excluded and _gain(log) == excluded[0]]
    simpler: list[TrainedLaw] = []
    results: dict[str, Any] = {}
    for name in names:
        parameters = partition(RIG, law_named(LAWS[name]), objective=Objective(loss))
        settings = TrainingSettings(0, BUDGET)
        law = train_law(parameters, [LogRange(log, None) for log in train], simpler, settings)
        simpler.append(law)
        p, polishing = _last(law)
        model = _by_absolute_errors(parameters, p)
        results[name] = {
            "train": _mae(model, train),
            "test": _mae(model, test) if test else None,
            "evaluations": law.evaluations + polishing,
            "p": parameters.values(p),
        }
    return results


def _last(law: TrainedLaw) -> tuple[Array, int]:
    """The last refinement of absolute errors, as `identify` makes it; complete parameters."""
    problem, parameters = law.problem, law.parameters
    assert isinstance(problem, MotionProblem)  # noqa: S101 - no start is free here
    if parameters.objective.loss != "absolute":
        return law.p, 0
    finer = problem.finer()
    minimum = polish(finer, law.x, float(finer(law.x[None])[0]), _LAST * len(law.x))
    return parameters.full(minimum.x[None])[0], minimum.evaluations + 1


# --- errors anew ----------------------------------------------------------------------------------


def errors_anew(results: dict[str, Any]) -> None:
    """Errors of the parameters on file, with the present simulation; the fits stay."""
    logs = tuple(read(f, columns=dict(RIG.columns)) for f in sorted(LOGS.glob("*.json")))
    for key, rows in results.items():
        kind, _, part = key.removeprefix("servo/").partition("/")
        if not key.startswith("servo/"):
            continue
        if kind == "identify":
            rows["mae"] = _mae(
                _on_file(part, {n: e[0] for n, e in rows["estimates"].items()}), logs
            )
            continue
        excluded = [int(gain) for gain in part.split("+") if gain != "none"]
        for name, row in rows.items():
            model = _on_file(name, row["p"])
            row["train"] = _mae(model, [log for log in logs if _gain(log) not in excluded])
            if excluded:
                row["test"] = _mae(model, [log for log in logs if _gain(log) == excluded[0]])


def _on_file(name: str, values: Mapping[str, float]) -> StatedModel:
    parameters = partition(RIG, law_named(LAWS[name]))
    return _by_absolute_errors(parameters, np.array([values[q.name] for q in parameters.every]))


# --- tables ---------------------------------------------------------------------------------------


def tables(results: Mapping[str, Any]) -> Iterator[str]:
    """Markdown: as identified, every split with both losses, and the choice of loss and law."""
    if not results:
        return
    yield "\n".join(_as_identified(results["identify"]))
    for section in (_all_splits, _choice) if results["splits"] else ():
        yield "\n".join(section(results["splits"]))


def _as_identified(results: Mapping[str, Any]) -> Iterator[str]:
    yield from table_head(
        "XL330, 16 logs: mean absolute error of full roll-outs / mrad",
        "law | published parameters: | local simplex: | `identify`: | repeats within 1 %: | "
        "evaluations: | processor / s:",
    )
    for name, row in results.items():
        yield (
            f"| {name} {LAWS[name]} | {_number(PUBLISHED.get(name))} | "
            f"{_number(SIMPLEX.get(name))} | {row['mae']:.1f} | {row['agreeing']} of "
            f"{len(row['repeats'])} | {row['evaluations']:,} | {row['processor_seconds']:.0f} |"
        )


def _all_splits(results: Mapping[str, Any]) -> Iterator[str]:
    names = list(next(iter(results.values())))
    yield from table_head(
        "XL330, a gain left out: mean absolute error on the gain that was not seen / mrad",
        f"fitted by | left out | {' | '.join(f'{name}:' for name in names)}",
    )
    for key, rows in results.items():
        loss, excluded = key.split("/")
        tested = "train" if excluded == "none" else "test"
        test_gains = "nothing (training error)" if excluded == "none" else _gains(excluded)
        yield f"| {loss} | {test_gains} | {' | '.join(f'{r[tested]:.1f}' for r in rows.values())} |"


def _gains(excluded: str) -> str:
    first, *further = excluded.split("+")
    return f"kp {first}" + "".join(f" (and {gain})" for gain in further)


def choice(results: Mapping[str, Any]) -> dict[str, Any]:
    """Loss and law chosen on kp 100, 200 and 400 alone, and then tested once on kp 800.

    `inner` are means over the three gains, each predicted from the other two.
    """
    training = [gain for gain in GAINS if gain != UNSEEN]
    inner: dict[str, dict[str, float]] = {}
    for loss in LOSSES:
        rows = [results.get(f"{loss}/{gain}+{UNSEEN}") for gain in training]
        if all(rows) and f"{loss}/{UNSEEN}" in results:
            inner[loss] = {
                name: float(np.mean([row[name]["test"] for row in rows if row])) for name in LAWS
            }
    if not inner:
        return {}
    by, law = min(((k, law) for k in inner for law in LAWS), key=lambda c: inner[c[0]][c[1]])
    tests = {k: {n: results[f"{k}/{UNSEEN}"][n]["test"] for n in LAWS} for k in inner}
    return {"inner": inner, "tests": tests, "loss": by, "law": law}


def _choice(results: Mapping[str, Any]) -> Iterator[str]:
    chosen = choice(results)
    if not chosen:
        return
    yield from table_head(
        "XL330, chosen without kp 800, and what that comes to on kp 800 / mrad",
        "fitted by | law | kp 100, 200, 400, each from the other two: | kp 800: | to m1 there:",
    )
    for by, errors in chosen["inner"].items():
        for name, error in errors.items():
            test, first = chosen["tests"][by][name], chosen["tests"][by]["m1"]
            mark = "**" if (by, name) == (chosen["loss"], chosen["law"]) else ""
            yield (
                f"| {by} | {mark}{name}{mark} | {error:.1f} | {test:.1f} | "
                f"{100 * (test / first - 1):+.0f} % |"
            )
    yield ""
    yield f"Chosen: **{chosen['law']}**, fitted by {chosen['loss']}."


def _number(value: float | None, digits: Literal[1, 2] = 1) -> str:
    return "" if value is None else f"{value:.{digits}f}"
