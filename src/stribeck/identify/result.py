"""The result of an identification, by output error or by force balance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..friction import Law
from ..optimize import Run
from ..presenters import presenter
from ..rig import Rig
from ..space import Array
from .conditions import Violation
from .data_split import log_notes
from .estimate_table import estimate_table
from .log_spread import LogSpreads
from .parameters import Parameters
from .polish import Polished
from .score import HeldOut, Score
from .segment import Segment
from .uncertainty.assessment import Uncertainty
from .uncertainty.estimates import Estimate

if TYPE_CHECKING:
    from pathlib import Path

    import polars as pl
    from matplotlib.figure import Figure

    from ..data.ranges import Range
    from ..data.recording import Recording
    from .adequacy.effects import Effects
    from .balance.balance import Balance
    from .breakaway_scatter import Spread
    from .card import Card
    from .combinations import Combination
    from .ratios import Ratio
    from .uncertainty.posterior import Posterior
    from .uncertainty.residuals import Residuals


@dataclass(frozen=True, eq=False)
class SearchRecord:
    """How the parameters were searched for.

    Args:
        method: Name of the search method.
        seed: Seed of the searches; None where nothing is drawn.
        runs: The searches, the best first.
        polished: Where least squares ended from each run.
        evaluations: Of the cost, in all.
        seconds: Wall-clock time of searching and polishing.
        ended: Why the best search ended; "interrupted" if Ctrl-C ended it.
    """

    method: str
    seed: int | None
    runs: tuple[Run, ...]
    polished: tuple[Polished, ...]
    evaluations: int
    seconds: float
    ended: str


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """An identified model, with what it rests on.

    Args:
        parameters: Which parameters were free, fixed and tied.
        p: The complete parameter set, SI, (k,).
        estimates: The parameters one by one.
        correlation: Of the free parameters' estimates, (dim, dim).
        score: Misfit on the training data beside its baselines.
        holdout: The same for each range held out.
        search: How the parameters were searched for.
        train: The segments trained on; none for a force balance.
        train_ranges: The ranges trained on; none means everything.
        recordings: The logs.
        warnings: What a reader must know, a sentence each.
        uncertainty: Profiles, sensitivities and blind directions of the free parameters.
        residuals: The problem whose residuals these come from: `posterior(fit.residuals,
            fit.uncertainty.x)` draws from it.
        balance: The force balance; None for output error.
        posterior: Samples of the posterior, if they were asked for.
        violations: Conditions of the estimates that do not hold.
        effects: What the residual forces show of what the model leaves out; None where the rig
            cannot say.
        delay: By how much the drive was behind the motion and has been moved back, s.
        combinations: Sums of a parameter and a constant that are known better than the parameter.
        ratios: Of parameters that a common uncertainty of all forces leaves as they are.
        breakaway: How breakaway varies from slip to slip, where each slip has one of its own.
        differing: What the logs give one by one, and how that differs; empty for a single log.
    """

    parameters: Parameters
    p: Array
    estimates: tuple[Estimate, ...]
    correlation: Array
    score: Score
    holdout: tuple[HeldOut, ...]
    search: SearchRecord
    train: tuple[Segment, ...]
    train_ranges: tuple[Range, ...]
    recordings: tuple[Recording, ...]
    warnings: tuple[str, ...]
    uncertainty: Uncertainty = field(repr=False)
    residuals: Residuals = field(repr=False)
    balance: Balance | None = field(default=None, repr=False)
    posterior: Posterior | None = field(default=None, repr=False)
    violations: tuple[Violation, ...] = ()
    effects: Effects | None = field(default=None, repr=False)
    delay: float = 0.0
    combinations: tuple[Combination, ...] = ()
    ratios: tuple[Ratio, ...] = ()
    breakaway: tuple[Spread, ...] = ()
    differing: LogSpreads = field(default_factory=LogSpreads, repr=False)

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.parameters.rig

    @property
    def law(self) -> Law:
        """The friction law."""
        return self.parameters.law

    @property
    def notes(self) -> tuple[str, ...]:
        """What was mended in the logs and which default ranges were widened: no warnings."""
        return (*log_notes(self.recordings), *self.parameters.widenings())

    def used(self, recording: Recording) -> int:
        """How many samples of a recording the fit was trained on."""
        if self.balance is not None:
            return len(self.balance.signals[self.recordings.index(recording)].t)
        return sum(int(s.track.sums[0, -1]) for s in self.train if s.recording is recording)

    def model(self) -> tuple[Parameters, Array]:
        """Rig and law, and the complete parameter set, SI: what `validate` takes."""
        return self.parameters, self.p

    def __repr__(self) -> str:
        values = ", ".join(f"{n} = {v:.5g}" for n, v in self.values.items())
        score = f"{self.score.name} = {self.score.value:.4g} {self.score.unit}"
        return f"<Fit of {self.law.name} on {self.rig.name}: {values} (SI); {score}>"

    def _repr_html_(self) -> str:
        return str(presenter("fit_html")(self))

    @property
    def values(self) -> dict[str, float]:
        """The complete parameter set by name, SI."""
        return self.parameters.values(self.p)

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """The 95 % interval (low, high) of each parameter that is not fixed, by name, SI."""
        return {
            q.name: (float(e.low), float(e.high))
            for q, e in zip(self.parameters.every, self.estimates, strict=True)
            if e.verdict != "fixed"
        }

    def table(self) -> pl.DataFrame:
        """Its parameters, a row each: value, interval, unit as the rig shows it, verdict, reason.

        `low_ended` and `high_ended` are why an interval ends: by the data at a `threshold`.

        A frame of polars; `fit.table().to_pandas()` is one of pandas.
        """
        return estimate_table(self.parameters, self.estimates)

    def card(self) -> Card:
        """Its card: everything that was identified, and what that rests on, to be kept.

        Raises:
            InputError: a misfit is not a finite number, so that there is nothing to believe.
        """
        written: Card = presenter("card")(self)
        return written

    def plot(self, kind: str = "stribeck_curve") -> Figure:
        """One of its figures.

        Args:
            kind: Its name, as of the files that `identify --out` writes: `stribeck_curve`,
                `friction`, `training`, `convergence` ...

        Raises:
            InputError: this fit has no such figure; the line names those that it has.
        """
        figure: Figure = presenter("figure")(self, kind)
        return figure

    def report(self, path: str | Path) -> Path:
        """Write its page, a file of HTML that needs no other, and return the path.

        Raises:
            InputError: it cannot be written there, or the fit has no card.
        """
        written: Path = presenter("report")(self, path)
        return written
