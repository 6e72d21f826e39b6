"""The identification as a problem for a search: parameters in, misfit of the motion out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..data.ranges import Range
from ..errors import InputError
from ..friction import Law, law_named
from ..optimize import rms
from ..rig import RIGS, Rig
from ..rig.custom import rig_file
from ..rig.rig import in_si
from ..rig.simulated import as_simulated
from ..space import Array, Param, Space
from ..units import unit
from .loss import FINER, KNEE, PLAIN, Loss, Measure, bent
from .segment import Stretch, stretches

if TYPE_CHECKING:
    from ..data.recording import Recording


@dataclass(frozen=True, eq=False)
class Parameters:
    """Which parameters are to be found, and how the others follow.

    Args:
        rig: The rig.
        law: The friction law.
        every: All parameters, the law's and then the rig's, in the order in which they are
            simulated.
        free: Those to be found, in the same order.
        fixed: Values of the others, SI, by name.
        tied: Name of the parameter that another one equals, by name.
        measure: How the model is held against the data.
    """

    rig: Rig
    law: Law
    every: tuple[Param, ...]
    free: tuple[Param, ...]
    fixed: Mapping[str, float]
    tied: Mapping[str, str]
    measure: Measure = PLAIN

    def full(self, x: Array) -> Array:
        """(n, dim) free values to (n, k) complete parameter sets, SI."""
        x = np.asarray(x, dtype=float)
        at = {p.name: i for i, p in enumerate(self.free)}
        p = np.empty((len(x), len(self.every)))
        for k, param in enumerate(self.every):
            name = self.tied.get(param.name, param.name)
            p[:, k] = x[:, at[name]] if name in at else self.fixed[name]
        return p

    def values(self, p: Array) -> dict[str, float]:
        """One complete parameter set by name."""
        return {q.name: float(v) for q, v in zip(self.every, p, strict=True)}


def partition(
    rig: Rig,
    law: Law,
    *,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tied: Mapping[str, str] | None = None,
    measure: Measure | None = None,
) -> Parameters:
    """Sort a rig's parameters under a law into free, fixed and tied ones.

    Args:
        rig: The rig.
        law: The law.
        fixed: Values by name, in the unit the rig shows; these are not searched.
        bounds: Search ranges by name, in the unit the rig shows; frees a parameter that the
            law holds fixed, such as an exponent.
        tied: `{"F_V-": "F_V+"}` makes the first equal the second.
        measure: How the model is held against the data; squares of whole motions by default.

    Raises:
        InputError: an unknown name, a parameter that is two of these at once, a value or a
            range outside the law's meaning, or nothing left to find.
    """
    _check_loads(rig, law)
    fixed, bounds, tied = dict(fixed or {}), dict(bounds or {}), dict(tied or {})
    every = {p.name: p for p in rig.parameters(law)}
    labels = {rig.label(name): name for name in every}
    fixed = {_named(labels, every, n, rig, law): v for n, v in fixed.items()}
    bounds = {_named(labels, every, n, rig, law): v for n, v in bounds.items()}
    tied = {
        _named(labels, every, a, rig, law): _named(labels, every, b, rig, law)
        for a, b in tied.items()
    }
    for name in every:
        if sum(name in part for part in (fixed, bounds, tied)) > 1:
            raise InputError(f"{name} can be set, bounded or tied, not two of these at once")
    values = {n: p.fixed for n, p in every.items() if p.fixed is not None and n not in bounds}
    values |= {n: in_si(rig, every[n], v) for n, v in fixed.items()}
    for a, b in tied.items():
        if b in tied or a == b or every[a].unit != every[b].unit:
            raise InputError(f"{a} cannot be tied to {b}")
        values.pop(a, None)
    for name, (low, high) in bounds.items():
        p, ends = every[name], (in_si(rig, every[name], low), in_si(rig, every[name], high))
        every[name] = replace(p, lower=ends[0], upper=ends[1], log=p.log and ends[0] > 0)
    free = tuple(p for n, p in every.items() if n not in values and n not in tied)
    if not free:
        raise InputError(f"law {law.name} on rig {rig.name}: no parameter is left to be found")
    for name, value in values.items():
        if not np.isfinite(value):
            raise InputError(f"{name} is set to {value}: it must be a finite number")
        if value < 0 <= every[name].lower:
            raise InputError(f"{name} is set to {value}: it must not be below 0")
    parameters = Parameters(rig, law, tuple(every.values()), free, values, tied, measure or PLAIN)
    _check_meaning(parameters)
    return parameters


def _check_loads(rig: Rig, law: Law) -> None:
    if unknown := [load for load in law.loads if load not in rig.loads]:
        raise InputError(
            f"law {law.name} depends on the {unknown[0]} load, which rig {rig.name} does not know"
        )


def _named(
    labels: Mapping[str, str], every: Mapping[str, Param], name: str, rig: Rig, law: Law
) -> str:
    """A parameter's own name, given that or what its rig calls it."""
    if name in every:
        return name
    if name not in labels:
        raise InputError(
            f"law {law.name} on rig {rig.name} has no parameter {name!r}: "
            f"it has {', '.join(labels)}"
        )
    return labels[name]


def _check_meaning(parameters: Parameters) -> None:
    """Some point of the search box must be a law that means something."""
    k = len(parameters.law.params)
    corners = Space(parameters.free).sample(np.random.default_rng(0), 256)
    sample = parameters.full(np.vstack([Space(parameters.free).decode(corners)]))
    if not parameters.law.physical(sample[:, :k]).any():
        values = ", ".join(f"{n} = {v:g}" for n, v in parameters.fixed.items())
        raise InputError(
            f"law {parameters.law.name}: no parameter set in these ranges is physical ({values})"
        )


class MotionProblem:
    """Output error: J (4.5), the RMS of measured minus simulated position, pooled over stretches.

    A problem for any search: `problem(x)` with (n, dim) rows of free parameters, SI, in the
    order of `problem.space`, returns (n,) costs in the unit in which the rig shows positions
    (mm for the slide bed, as in the paper). A point that is not physical, or that cannot be
    simulated, costs nan. Rows are independent bit for bit, however many are asked at once.

    Where absolute errors are asked for, residuals are bent (`measure.bent`) so that the sum of
    their squares grows as that of the errors' sizes, and J is the RMS of what they are bent to.
    Where the rig knows positions only up to a constant, each stretch's residuals have mean zero.

    `scale` is `unit` in SI, `logs` how many samples count in each stretch, in order.
    """

    def __init__(self, parameters: Parameters, train: Sequence[Stretch]) -> None:
        self._rig = as_simulated(parameters.rig)
        self.name = f"{parameters.rig.name}/{parameters.law.name}"
        self.parameters, self.train = parameters, tuple(train)
        for stretch in train:
            if "temperature" in parameters.law.terms and stretch.recording.temperature is None:
                raise InputError(
                    f"{stretch.recording.label}: law {parameters.law.name} needs a temperature: "
                    "map a column to temperature"
                )
        self.space = Space(parameters.free)
        self.logs = tuple(int(s.track.sums[0, -1]) for s in train)
        self.samples = sum(self.logs)
        self.unit = parameters.rig.shows.get("position", "m")
        self.scale = unit(self.unit).factor
        widest = max(float(np.ptp(s.recording.position)) for s in train)
        self._knee = KNEE * widest / self.scale if parameters.measure.loss == "absolute" else np.inf

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) free parameter sets to (n,) values of J."""
        x = np.atleast_2d(x)
        if self._rig.floating or np.isfinite(self._knee):
            return rms(self.residuals(x))
        p, good = self._physical(x)
        law = self.parameters.law
        sse = np.full(len(p), np.nan)
        if good.any():
            sse[good] = sum(self._rig.misfits(law, p[good], s.track) for s in self.train)
        cost: Array = np.sqrt(sse / self.samples) / self.scale
        return cost

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) free parameter sets to (n, samples) residuals, in `unit`; J is their RMS."""
        x = np.atleast_2d(x)
        return np.concatenate([self.apart(x, s) for s in self.train], axis=1)

    def apart(self, x: Array, stretch: Stretch) -> Array:
        """The residuals of one stretch, (n, its samples that count); nan where not physical."""
        p, good = self._physical(x)
        counts = stretch.track.score > 0
        found = np.full((len(p), int(counts.sum())), np.nan)
        if good.any():
            motion = self._rig.move(self.parameters.law, p[good], stretch.track)
            found[good] = (stretch.track.measured - motion.position)[:, counts] / self.scale
        if self._rig.floating:
            found -= found.mean(axis=1, keepdims=True)
        return bent(found, self._knee) if np.isfinite(self._knee) else found

    def finer(self) -> MotionProblem:
        """The same with a knee that lies lower: absolute errors nearly to the letter."""
        finer = copy(self)
        finer._knee = self._knee * FINER  # noqa: SLF001 - its own
        return finer

    def _physical(self, x: Array) -> tuple[Array, NDArray[np.bool_]]:
        p, law = self.parameters.full(x), self.parameters.law
        return p, np.asarray(law.physical(p[:, : len(law.params)]), dtype=bool)


def problem(
    recordings: Recording | Sequence[Recording],
    *,
    rig: str | Rig = "slide-bed",
    law: str | Law | None = None,
    train: Sequence[Range | str] | Range | str | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tied: Mapping[str, str] | None = None,
    loss: Loss = "squares",
    restart: bool = False,
) -> MotionProblem:
    """What `identify` searches on a rig whose law is found by simulation.

    Args:
        recordings: One or several logs of the axis.
        rig: A rig or its name in RIGS.
        law: A law or its name in LAWS; by default the rig's first.
        train: Ranges to use, as `112:295`; by default everything.
        fixed: See `partition`.
        bounds: See `partition`.
        tied: See `partition`.
        loss: See `Measure`.
        restart: See `Measure`.
    """
    rig, law = chosen(rig, law)
    rig = as_simulated(rig)
    measure = Measure(loss, restart)
    parameters = partition(rig, law, fixed=fixed, bounds=bounds, tied=tied, measure=measure)
    logs = listed(recordings)
    every = [s for r in parts(train, rig) for s in stretches(logs, rig, r, restart=restart)]
    return MotionProblem(parameters, every)


def chosen(rig: str | Rig, law: str | Law | None) -> tuple[Rig, Law]:
    """A rig and a law, looked up where they are names; a rig may be a .toml file, too.

    Raises:
        InputError: there is none of that name.
    """
    if isinstance(rig, str) and rig.endswith(".toml"):
        rig = rig_file(Path(rig))
    elif isinstance(rig, str):
        if rig not in RIGS:
            raise InputError(f"no rig {rig!r}: there are {', '.join(RIGS)}, or give a .toml file")
        rig = RIGS[rig]
    law = law or rig.laws[0]
    if isinstance(law, str):
        law = law_named(law)
    return rig, law


def listed(recordings: Recording | Sequence[Recording]) -> list[Recording]:
    """One or several recordings as a list."""
    logs = list(recordings) if isinstance(recordings, Sequence) else [recordings]
    if not logs:
        raise InputError("no recording was given")
    return logs


def ranges(given: Sequence[Range | str] | Range | str | None, rig: Rig) -> list[Range]:
    """Ranges as written or ready, as a list."""
    if given is None:
        return []
    if isinstance(given, Range | str):
        given = [given]
    shown = rig.shows.get("position", "m")
    if not all(isinstance(g, Range | str) for g in given):
        raise InputError(f"range {given!r}: write it as '112:295' ({shown}) or '10s:40s'")
    return [g if isinstance(g, Range) else Range.parse(g, shown) for g in given]


def parts(given: Sequence[Range | str] | Range | str | None, rig: Rig) -> list[Range | None]:
    """The same, with None, which is everything, where no range was given."""
    return [*ranges(given, rig)] or [None]
