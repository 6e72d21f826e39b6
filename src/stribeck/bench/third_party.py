"""Third-party optimizers under the rules of a campaign: counter, budget, target and seed.

Every peer works on the unit cube, as our own methods do, so that it meets the same problem at the
same scale. A point outside is clipped into the cube before it is evaluated (differences for a
gradient step over the edge), a coordinate that is not a number to 0. A cost that is not finite is
handed on as inf. Batches are cut to the budget before they are evaluated; a target is looked for
after each batch, as `Search` does.

A peer that ends by itself with budget left begins anew with a fresh stream of random numbers, as
its user would; where that would bring the same points again, the run is "exhausted".

Hyper-parameters are the library's defaults. What a peer may be told is the keyword arguments of
its function below.
"""

from __future__ import annotations

import importlib.util
import inspect
import itertools
import logging
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import SeedSequence

from ..errors import InputError
from ..optimize import METHODS, Problem, Trace
from ..space import Array, Rng
from .counter import Counter, Over
from .library import library
from .residual_peers import dfo_ls, least_squares

#: Above this, scipy's `shgo` builds its first cells for minutes before it evaluates anything.
SHGO_DIMENSIONS = 10


def _scipy_de(
    count: Counter,
    rng: Rng,
    *,
    strategy: str = "best1bin",
    popsize: int = 15,
    tol: float = 0.01,
    mutation: float | tuple[float, float] = (0.5, 1.0),
    recombination: float = 0.7,
    polish: bool = True,
    init: str = "latinhypercube",
) -> None:
    """`scipy.optimize.differential_evolution`, one point at a time (`updating="immediate"`).

    Its own end is the spread of its population; the polish that follows (L-BFGS-B) is counted,
    as a round of its own. scipy speaks after each generation, so the first is not told apart
    from the start.
    """
    optimize = library("scipy.optimize")
    optimize.differential_evolution(
        count.one,
        [(0.0, 1.0)] * count.dim,
        strategy=strategy,
        popsize=popsize,
        tol=tol,
        mutation=mutation,
        recombination=recombination,
        polish=polish,
        init=init,
        maxiter=count.budget_left,
        callback=lambda *_, **__: count.round(),
        rng=rng,
    )


def _dual_annealing(
    count: Counter,
    rng: Rng,
    *,
    initial_temp: float = 5230.0,
    restart_temp_ratio: float = 2e-5,
    visit: float = 2.62,
    accept: float = -5.0,
    no_local_search: bool = False,
) -> None:
    """`scipy.optimize.dual_annealing`; its iterations are not told apart.

    Where a thousand points in a row have no finite cost it gives up with an error: an end.
    """
    optimize = library("scipy.optimize")
    before = len(count.trace)
    try:
        optimize.dual_annealing(
            count.one,
            [(0.0, 1.0)] * count.dim,
            maxiter=count.budget_left,
            maxfun=count.budget_left + 1,
            initial_temp=initial_temp,
            restart_temp_ratio=restart_temp_ratio,
            visit=visit,
            accept=accept,
            no_local_search=no_local_search,
            rng=rng,
        )
    except ValueError:
        if np.isfinite(count.trace.f[before:]).any() or len(count.trace) == before:
            raise


def _shgo(count: Counter, rng: Rng, *, sampling_method: str = "simplicial", n: int = 100) -> None:
    """`scipy.optimize.shgo`, refined until the budget is spent; nothing in it is random.

    Its own time grows faster than the budget: two thousand evaluations take it seconds, three
    thousand in two dimensions a minute. Before the first it cuts the cube at its 2**dim corners.

    `n` is sampling points an iteration; scipy reads 100 with "simplicial" as 2**dim + 1.
    """
    del rng
    if count.dim > SHGO_DIMENSIONS:
        raise InputError(f"shgo takes at most {SHGO_DIMENSIONS} dimensions, this has {count.dim}")
    optimize = library("scipy.optimize")
    optimize.shgo(
        count.one,
        [(0.0, 1.0)] * count.dim,
        n=n,
        sampling_method=sampling_method,
        options={"maxfev": count.budget_left + 1},
    )


def _direct(count: Counter, rng: Rng, *, eps: float = 1e-4, locally_biased: bool = True) -> None:
    """`scipy.optimize.direct`, its tolerances at 0; nothing in it is random."""
    del rng
    optimize = library("scipy.optimize")
    optimize.direct(
        count.one,
        [(0.0, 1.0)] * count.dim,
        eps=eps,
        locally_biased=locally_biased,
        maxfun=count.budget_left + 1,
        maxiter=count.budget_left + 1,
        vol_tol=0.0,
        len_tol=0.0,
    )


def _cma_ipop(
    count: Counter,
    rng: Rng,
    *,
    sigma0: float = 0.25,
    popsize: int | None = None,
    restarts: int = 9,
) -> None:
    """`cma.fmin2`, restarted with twice the population each time (Auger and Hansen, CEC 2005).

    Each start is uniform in the cube, with a step of `sigma0`.
    """
    _cma(count, rng, sigma0, popsize, restarts, bipop=False)


def _cma_bipop(
    count: Counter,
    rng: Rng,
    *,
    sigma0: float = 0.25,
    popsize: int | None = None,
    restarts: int = 9,
) -> None:
    """`cma.fmin2(bipop=True)`: large and small populations in turn (Hansen, GECCO 2009)."""
    _cma(count, rng, sigma0, popsize, restarts, bipop=True)


def _cma_lq(
    count: Counter,
    rng: Rng,
    *,
    sigma0: float = 0.25,
    popsize: int | None = None,
    restarts: int = 9,
) -> None:
    """`cma.fmin_lq_surr2`: CMA-ES beside a linear or quadratic model (Hansen, GECCO 2019).

    Its model takes finite costs alone: what cannot be run costs as much as the worst so far. It
    thinks for half a millisecond or more between evaluations.
    """
    cma, options = _cma_options(count, rng, sigma0, popsize)
    starts = itertools.count()

    def cost(u: Any) -> float:
        answer = count.one(u)
        if np.isfinite(answer):
            return answer
        known = count.trace.f[np.isfinite(count.trace.f)]
        return float(known.max()) if len(known) else 0.0

    def start() -> Array:
        if next(starts):
            count.restarted()
        return rng.random(count.dim)

    cma.fmin_lq_surr2(
        cost, start, sigma0, options, restarts=restarts, callback=lambda _: count.round()
    )


def _cma(
    count: Counter, rng: Rng, sigma0: float, popsize: int | None, restarts: int, *, bipop: bool
) -> None:
    cma, options = _cma_options(count, rng, sigma0, popsize)
    starts = itertools.count()
    cma.fmin2(
        count.one,  # the mean that a start ends with
        lambda: rng.random(count.dim),
        sigma0,
        options,
        restarts=restarts,
        bipop=bipop,
        parallel_objective=lambda points: count.generation(points).tolist(),
        init_callback=lambda _: count.restarted() if next(starts) else None,
    )


def _cma_options(
    count: Counter, rng: Rng, sigma0: float, popsize: int | None
) -> tuple[Any, dict[str, Any]]:
    """pycma, and what it is told besides its first deviation."""
    if count.dim < 2:  # noqa: PLR2004 - pycma's own rule, which it finds out too late
        raise InputError("CMA-ES takes two dimensions or more, this has 1")
    if not sigma0 > 0:  # pycma goes on with it
        raise InputError(f"sigma0 is a length of the unit cube above 0, got {sigma0!r}")
    cma = library("cma")
    options = {
        "bounds": [0.0, 1.0],
        "randn": lambda *shape: rng.standard_normal(shape),
        "seed": float("nan"),  # of the global generator, which `randn` replaces
        "verbose": -9,
        "verb_log": 0,
        "verb_disp": 0,
        "signals_filename": None,
    }
    return cma, options | ({"popsize": popsize} if popsize else {})


def _pymoo_ga(count: Counter, rng: Rng, *, pop_size: int = 100) -> None:
    """The `GA` of pymoo. It goes on until the budget is spent: its default end is before 1e-6."""
    ga = library("pymoo.algorithms.soo.nonconvex.ga")
    # Its default operators are shared between all instances: here are others like them.
    crossover = library("pymoo.operators.crossover.sbx").SBX()
    mutation = library("pymoo.operators.mutation.pm").PM()
    _pymoo(count, rng, ga.GA(pop_size=pop_size, crossover=crossover, mutation=mutation))


def _pymoo_de(
    count: Counter, rng: Rng, *, pop_size: int = 100, variant: str = "DE/best/1/bin"
) -> None:
    """The `DE` of pymoo. It goes on until the budget is spent: its default end is before 1e-6."""
    de = library("pymoo.algorithms.soo.nonconvex.de")
    _pymoo(count, rng, de.DE(pop_size=pop_size, variant=variant))


def _pymoo(count: Counter, rng: Rng, algorithm: Any) -> None:
    problem = library("pymoo.core.problem").Problem(n_var=count.dim, n_obj=1, xl=0.0, xu=1.0)
    endless = library("pymoo.core.termination").NoTermination()
    algorithm.termination = endless
    algorithm.setup(problem, seed=_whole(rng))
    static = library("pymoo.problems.static").StaticProblem
    while (infill := algorithm.ask()) is not None and len(infill):
        costs = count.batch(infill.get("X"))
        algorithm.evaluator.eval(static(problem, F=costs[:, None]), infill)
        algorithm.tell(infills=infill)
        count.round()


def _niapy_bfo(
    count: Counter,
    rng: Rng,
    *,
    population_size: int = 50,
    n_chemotactic: int = 100,
    n_swim: int = 4,
    n_reproduction: int = 4,
    prob_elimination: float = 0.25,
    step_size: float = 0.1,
    swarming: bool = True,
    d_attract: float = 0.1,
    w_attract: float = 0.2,
    h_repel: float = 0.1,
    w_repel: float = 10.0,
) -> None:
    """NiaPy's `BacterialForagingOptimization`; its step and signals are lengths of the cube.

    It has no end of its own (`n_elimination` is never read there), and its task answers inf
    once a budget of its own is spent: it is given none.
    """
    with _logging_kept():
        bfo = library("niapy.algorithms.basic.bfo")
        core, task = library("niapy.problems"), library("niapy.task")
        callbacks = library("niapy.callbacks")
    counted = type("Counted", (core.Problem,), {"_evaluate": lambda _, x: count.one(x)})
    rounds = callbacks.Callback()
    rounds.before_iteration = lambda *_, **__: count.round()
    swarm = bfo.BacterialForagingOptimization(
        population_size=population_size,
        n_chemotactic=n_chemotactic,
        n_swim=n_swim,
        n_reproduction=n_reproduction,
        prob_elimination=prob_elimination,
        step_size=step_size,
        swarming=swarming,
        d_attract=d_attract,
        w_attract=w_attract,
        h_repel=h_repel,
        w_repel=w_repel,
        seed=_whole(rng),
        callbacks=[rounds],
    )
    swarm.run(task.Task(counted(dimension=count.dim, lower=0.0, upper=1.0)))
    if swarm.bad_run():  # what it swallows off the main thread
        raise swarm.exception


@dataclass(frozen=True)
class _Peer:
    """How a peer is run, whether another run brings other points, whether it wants residuals.

    And the library of the extra `bench` that it needs, by the name of its module.
    """

    run: Callable[..., None]
    random: bool = True
    residuals: bool = False
    library: str = ""

    @property
    def settings(self) -> Mapping[str, inspect.Parameter]:
        """What it may be told: the keyword arguments of its function."""
        accepted = inspect.signature(self.run).parameters
        return {n: p for n, p in accepted.items() if p.kind is p.KEYWORD_ONLY}


#: The peers by the name that a campaign gives them.
PEERS: dict[str, _Peer] = {
    "scipy-de": _Peer(_scipy_de),
    "dual-annealing": _Peer(_dual_annealing),
    "shgo": _Peer(_shgo, random=False),
    "direct": _Peer(_direct, random=False),
    "cma-ipop": _Peer(_cma_ipop, library="cma"),
    "cma-bipop": _Peer(_cma_bipop, library="cma"),
    "cma-lq": _Peer(_cma_lq, library="cma"),
    "pymoo-ga": _Peer(_pymoo_ga, library="pymoo"),
    "pymoo-de": _Peer(_pymoo_de, library="pymoo"),
    "niapy-bfo": _Peer(_niapy_bfo, library="niapy"),
    "dfo-ls": _Peer(dfo_ls, residuals=True, library="dfols"),
    "least-squares": _Peer(least_squares, residuals=True),
}


def search(
    name: str,
    problem: Problem,
    *,
    budget: int,
    target: float | None,
    seed: SeedSequence,
    **settings: Any,
) -> tuple[Trace, str]:
    """Search with a peer.

    Args:
        name: A name in PEERS.
        problem: What is searched.
        budget: Rows of cost that may be evaluated; kept exactly, the last batch is cut.
        target: End with the batch that brings a cost at or below it; None to go on.
        seed: The source of everything random; not changed.
        settings: Hyper-parameters of the peer.

    Returns:
        The trace, and why it ended: "target", "budget", or "exhausted" where the peer ended
        by itself and would only do the same again.

    Raises:
        InputError: there is no such peer or setting, its library is missing, or it refuses
            the settings.
    """
    peer = chosen(name, settings)
    if peer.residuals and not hasattr(problem, "residuals"):
        raise InputError(f"{name} minimises residuals, and {problem.name} shows none")
    if budget < 1:
        raise InputError(f"budget must be a whole number of evaluations >= 1, got {budget!r}")
    count = Counter(problem, budget, target)
    for stream in _streams(seed):
        before = len(count.trace)
        _once(name, peer, count, stream, settings)
        if count.ended:
            return count.trace, count.ended
        if not len(count.trace):
            raise InputError(f"{name} with these settings evaluates nothing")
        if not peer.random or len(count.trace) == before:
            return count.trace, "exhausted"
        count.restarted()
    raise AssertionError("streams never end")


def check_installed(names: Iterable[str]) -> None:
    """Refuse, before any run, methods whose library is not there.

    Raises:
        InputError: some are not installed.
    """
    needed = dict.fromkeys(PEERS[n].library for n in names if n in PEERS and PEERS[n].library)
    if absent := [module for module in needed if importlib.util.find_spec(module) is None]:
        raise InputError(
            f"other people's methods need {', '.join(absent)}, not installed here: pip install "
            "'stribeck[bench]', or take these methods out of the campaign (--show prints it)"
        )


def chosen(name: str, settings: Mapping[str, Any]) -> _Peer:
    """A peer that can be told these settings.

    Raises:
        InputError: there is no such peer or setting.
    """
    if name not in PEERS:
        ours, theirs = ", ".join(METHODS), ", ".join(PEERS)
        raise InputError(f"no method {name!r}: there are {ours}, and other people's {theirs}")
    available = PEERS[name].settings
    for setting in settings:
        if setting not in available:
            raise InputError(f"{name} has no setting {setting!r}: it has {', '.join(available)}")
    return PEERS[name]


def _once(
    name: str, peer: _Peer, count: Counter, stream: SeedSequence, settings: Mapping[str, Any]
) -> None:
    """One run of a peer, to its end or ours."""
    try:
        with _contained(stream):
            peer.run(count, np.random.default_rng(stream), **settings)
    except Over:
        pass
    except InputError:
        raise
    except Exception as error:
        if count.failure is None and not len(count.trace):
            message = " ".join(str(error).split())
            raise InputError(f"{name} cannot run with these settings: {message}") from error
        raise count.failure or error from None
    if count.failure is not None:
        raise count.failure


def _streams(seed: SeedSequence) -> Iterator[SeedSequence]:
    """A stream a start, without counting in the seed itself."""
    start = 0
    while True:
        yield SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, start))
        start += 1


@contextmanager
def _contained(stream: SeedSequence) -> Iterator[None]:
    """Keep a library to itself: no warnings out, and numpy's global generator as it was.

    Whatever a library draws from that generator (pycma's BIPOP its sizes, SLSQP nothing) comes
    from the run's own seed. The generator belongs to the process: threads must not share it.
    """
    state = np.random.get_state()  # noqa: NPY002 - theirs, not ours
    np.random.seed(stream.generate_state(4))  # noqa: NPY002
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        np.random.set_state(state)  # noqa: NPY002


def _whole(rng: Rng) -> int:
    """A seed for a library that takes a whole number."""
    return int(rng.integers(2**31))


@contextmanager
def _logging_kept() -> Iterator[None]:
    """NiaPy configures the process's logging as it is imported: put it back."""
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    try:
        yield
    finally:
        root.handlers[:] = handlers
        root.setLevel(level)
