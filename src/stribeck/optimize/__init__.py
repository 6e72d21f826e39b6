"""How to search: metaheuristics behind one ask-and-tell search. It knows nothing of friction."""

from .bts import ForagingTabuSearch
from .foraging import AdaptiveForaging, BacterialForaging
from .genetic import GeneticAlgorithm
from .mbts import MemeticTabuSearch
from .methods import METHODS, configure, minimize
from .random_search import RandomSearch
from .search import (
    Algorithm,
    Answer,
    Detailed,
    LeastSquares,
    Moves,
    Note,
    Problem,
    Run,
    Search,
    SearchError,
    Stop,
    lockstep,
    rms,
    steps,
)
from .stops import Target
from .tabu import AdaptiveTabuSearch, TabuSearch
from .trace import Trace
from .trust_region import least_squares

__all__ = [
    "METHODS",
    "AdaptiveForaging",
    "AdaptiveTabuSearch",
    "Algorithm",
    "Answer",
    "BacterialForaging",
    "Detailed",
    "ForagingTabuSearch",
    "GeneticAlgorithm",
    "LeastSquares",
    "MemeticTabuSearch",
    "Moves",
    "Note",
    "Problem",
    "RandomSearch",
    "Run",
    "Search",
    "SearchError",
    "Stop",
    "TabuSearch",
    "Target",
    "Trace",
    "configure",
    "least_squares",
    "lockstep",
    "minimize",
    "rms",
    "steps",
]
