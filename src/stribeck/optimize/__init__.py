"""Search: metaheuristics behind one ask-and-tell interface; independent of friction."""

from .bts import ForagingTabuSearch
from .foraging import AdaptiveForaging, BacterialForaging
from .genetic import GeneticAlgorithm
from .lockstep import (
    AskTell,
    Counted,
    LeastSquares,
    Problem,
    SearchError,
    lockstep,
    rms,
    steps,
)
from .mbts import MemeticTabuSearch
from .methods import METHODS, configure, minimize
from .moves import Answer, Detailed, Moves, Note
from .random_search import RandomSearch
from .search import Algorithm, Run, Search, Stop
from .stops import Target
from .tabu import AdaptiveTabuSearch, TabuSearch
from .trace import Trace

__all__ = [
    "METHODS",
    "AdaptiveForaging",
    "AdaptiveTabuSearch",
    "Algorithm",
    "Answer",
    "AskTell",
    "BacterialForaging",
    "Counted",
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
    "lockstep",
    "minimize",
    "rms",
    "steps",
]
