"""The problem that the small table of a job names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

from ..errors import InputError
from ..space import Array, Space
from .bbob import bbob
from .surfaces import surface

if TYPE_CHECKING:
    from ..identify.problem import MotionProblem

#: Stopping rule of the paper (section 4.4): J < 4.5 mm or 1000 rounds.
PAPER_TARGET = 4.5
#: Section 4.5 of the paper: the stretch of the ramp each direction is identified from, mm.
TRAINING = {"right": "112:295", "left": "325:127"}
SLIDE_BED = "slide-bed"


class BenchProblem(Protocol):
    """A problem that may know its answer. Rows are independent: cost(x)[i] hangs on x[i] alone."""

    @property
    def name(self) -> str:
        """The name it is listed under."""

    @property
    def space(self) -> Space:
        """Where it is searched."""

    @property
    def minimum(self) -> float | None:
        """The least cost there is, where that is known."""

    @property
    def J_min(self) -> float | None:
        """The cost at or below which a run has found it, unless the campaign says otherwise."""

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) physical values to (n,) costs."""


@dataclass(frozen=True, eq=False)
class Identification:
    """The friction of the slide bed, from a recording of its twin: section 4 as a surface.

    Args:
        name: As a campaign lists it.
        misfit: J (4.5) in mm over the five parameters of one direction.
    """

    name: str
    misfit: MotionProblem = field(repr=False)
    minimum: None = None
    J_min: float = PAPER_TARGET

    @property
    def space(self) -> Space:
        """The paper's search ranges (section 4.4)."""
        return self.misfit.space

    def __call__(self, x: Array, /) -> Array:
        """(n, 5) parameters, SI, to (n,) J in mm."""
        return self.misfit(x)

    def residuals(self, x: Array, /) -> Array:
        """(n, 5) parameters, SI, to (n, samples) residuals in mm, whose RMS is J."""
        return self.misfit.residuals(x)


def problem(spec: Mapping[str, Any]) -> BenchProblem:
    """The problem of a table.

    Args:
        spec: One of
            `{"surface": NAME, "dim": D, "twin": SEED}`, a surface of Table 1, or, with a twin's
            seed, the same shifted and rotated;
            `{"surface": "slide-bed", "direction": "right" or "left", "twin": SEED}`, the
            identification of the slide bed from a twin recording with that noise seed;
            `{"bbob": F, "dim": D, "instance": I}`, function F of the COCO suite.

    Raises:
        InputError: there is no such problem, or the extra it needs is not installed.
    """
    return _made(tuple(sorted(spec.items())))


def answer(spec: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """The least cost of a table's problem and its J_min; no recording is made for it."""
    if spec.get("surface") == SLIDE_BED:
        return Identification.minimum, Identification.J_min
    instance = problem(spec)
    return instance.minimum, instance.J_min


@lru_cache(maxsize=64)
def _made(items: tuple[tuple[str, Any], ...]) -> BenchProblem:
    spec = dict(items)
    if "bbob" in spec:
        return bbob(spec["bbob"], spec["dim"], spec["instance"])
    if spec["surface"] == SLIDE_BED:
        return slide_bed(spec["direction"], spec["twin"] or 0)
    return surface(spec["surface"], spec["dim"], spec["twin"])


def slide_bed(direction: str, seed: int) -> Identification:
    """The identification of one direction from the twin recording of a noise seed."""
    if direction not in TRAINING:
        raise InputError(f"no direction {direction!r}: there are {', '.join(TRAINING)}")
    from ..identify.problem import problem as identification  # noqa: PLC0415 - slow to import
    from ..rig.twin import TestBed  # noqa: PLC0415 - the same

    log = TestBed().run("both", seed=seed).recording
    misfit = identification(log, rig=SLIDE_BED, law="stribeck", train=TRAINING[direction])
    return Identification(f"{SLIDE_BED}-{direction}", misfit)
