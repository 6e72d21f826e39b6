"""What an identification found, whichever road it took."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..friction import Law
from ..optimize import Run
from ..rig import Rig
from ..space import Array
from .parameters import Parameters
from .polish import Polished
from .score import HeldOut, Score, simulated
from .segment import Segment
from .uncertainty.estimates import Estimate
from .uncertainty.uncertainty import Uncertainty

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..data.recording import Recording
    from .balance.balance import Balance
    from .uncertainty.residuals import Residuals


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """What an identification found, and what it rests on.

    Args:
        parameters: Which parameters were free, fixed and tied.
        p: The complete parameter set found, SI.
        estimates: The parameters one by one.
        correlation: Of the free parameters' estimates, (dim, dim).
        score: Misfit on the training data beside its baselines.
        holdout: The same for each range held out.
        runs: The searches, the best first.
        polished: What polishing made of each run.
        method: Name of the search method.
        seed: Seed of the searches.
        evaluations: Of the cost, in all.
        seconds: Wall-clock time of searching and polishing.
        ended: Why the best search ended; "interrupted" if somebody stopped it.
        train: The segments it was trained on; none on the inverse road.
        train_ranges: The ranges that were asked for; none means everything.
        recordings: The logs.
        warnings: What a reader must know, a sentence each.
        balance: The force balance of a rig on the inverse road, else None.
        known: How well the parameters are known: profiles, weights, blind directions.
        residuals: What was asked for that: `posterior(fit.residuals, fit.known.x)` asks more.
    """

    parameters: Parameters
    p: Array
    estimates: tuple[Estimate, ...]
    correlation: Array
    score: Score
    holdout: tuple[HeldOut, ...]
    runs: tuple[Run, ...]
    polished: tuple[Polished, ...]
    method: str
    seed: int | None
    evaluations: int
    seconds: float
    ended: str
    train: tuple[Segment, ...]
    train_ranges: tuple[Range, ...]
    recordings: tuple[Recording, ...]
    warnings: tuple[str, ...]
    balance: Balance | None = field(default=None, repr=False)
    known: Uncertainty | None = field(default=None, repr=False)
    residuals: Residuals | None = field(default=None, repr=False)

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.parameters.rig

    @property
    def law(self) -> Law:
        """The friction law."""
        return self.parameters.law

    def used(self, recording: Recording) -> int:
        """How many samples of a recording the fit was trained on."""
        if self.balance is not None:
            return len(self.balance.signals[self.recordings.index(recording)].t)
        return sum(int(s.track.sums[0, -1]) for s in self.train if s.recording is recording)

    def speeds(self) -> tuple[float, float]:
        """Least and greatest velocity of the training data, m/s or rad/s.

        Of the model's own motion where the law was found by simulation: a velocity that is taken
        from noisy positions reaches farther than the axis ever did.
        """
        if self.balance is not None:
            seen = [b.velocity for b in self.balance.signals]
        else:
            seen = [m.velocity for m in simulated(self.parameters, self.p, self.train)]
        return min(float(v.min()) for v in seen), max(float(v.max()) for v in seen)

    def model(self) -> tuple[Parameters, Array]:
        """Rig and law, and the complete parameter set, SI: what `validate` takes."""
        return self.parameters, self.p

    def __repr__(self) -> str:
        found = ", ".join(f"{n} = {v:.5g}" for n, v in self.values.items())
        score = f"{self.score.name} = {self.score.value:.4g} {self.score.unit}"
        return f"<Fit of {self.law.name} on {self.rig.name}: {found} (SI); {score}>"

    @property
    def values(self) -> dict[str, float]:
        """The complete parameter set by name, SI."""
        return self.parameters.values(self.p)
