"""A worker: one job of a studio's home, in a process of its own.

    python -m stribeck.studio.job_worker HOME JOB

It claims the job, does it, keeps its results in the home, and ends. Nothing that it finishes is
lost when the studio is killed; a job whose worker is killed is begun anew by the next studio.
"""

from __future__ import annotations

import _thread
import os
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench.lock import Owner
from ..errors import InputError
from ..report.search_progress import SearchProgress
from ..wording import on_command_line
from .home import Home, SessionJob
from .session_request import Request

if TYPE_CHECKING:
    from ..identify.problem import MotionProblem
    from ..identify.result import Fit
    from ..optimize import Search

#: Seconds between two words of progress, and between two looks whether the job is cancelled.
PACE = 0.25
#: Samples of a motion that is drawn while a search runs.
DRAWN = 600
#: Points of a trial batch, and seconds of batches after which an evaluation's cost is known.
TRIED, MEASURED = 24, 0.3


def main(arguments: Sequence[str]) -> int:
    """Do a job; the exit status is 0 if there is a result."""
    folder, number = Path(arguments[0]), int(arguments[1])
    os.environ["MPLBACKEND"] = "agg"
    with Home(folder) as home, Owner(home.file) as owner:
        if not home.claim(number, owner):
            return 0
        try:
            job = home.job(number)
            with _Cancelling(folder, number), on_command_line():
                _do(home, job)
        except KeyboardInterrupt:
            home.end(number, "failed", "cancelled before there was a result")
        except InputError as error:
            home.end(number, "failed", str(error))
        except MemoryError:
            home.end(number, "failed", "out of memory: take a shorter log, or a part of it")
        except Exception as error:
            line = f"this is an error in stribeck itself ({type(error).__name__}: {error!s:.200})"
            home.end(number, "failed", line)
            raise
        else:
            home.end(number, "done")
            return 0
    return 1


def _do(home: Home, job: SessionJob) -> None:
    request = Request(job.choices, {i: log.path for i, log in home.logs().items()})
    out = home.results(job.id)
    match job.kind:
        case "estimate":
            _estimate(home, job, request)
        case "identify":
            _identify(home, job, request, out)
        case "select":
            _select(home, job, request, out)
        case "plan":
            _plan(home, job, request, out)
        case "compensate":
            _compensate(home, job, out)


def _estimate(home: Home, job: SessionJob, request: Request) -> None:
    """How long the search of a fit takes at most, from what an evaluation takes here."""
    from ..identify.search_settings import BUDGET, REPEATS  # noqa: PLC0415 - compiled code

    home.report(job.id, {"stage": "reading"})
    recordings = request.recordings()
    trial = _problem(recordings, request.identification).thinned()
    rng = np.random.default_rng(0)
    trial(trial.space.decode(trial.space.sample(rng, TRIED)))  # compiles what is not compiled yet
    rows, seconds = 0, 0.0
    while seconds < MEASURED:
        x = trial.space.decode(trial.space.sample(rng, TRIED))
        began = time.perf_counter()
        trial(x)
        rows, seconds = rows + TRIED, seconds + time.perf_counter() - began
    most = (job.choices.budget or BUDGET) * (job.choices.repeats or REPEATS)
    cost = seconds / rows
    home.report(job.id, {"evaluations": most, "evaluation": cost, "seconds": most * cost})


def _identify(home: Home, job: SessionJob, request: Request, out: Path) -> None:
    from ..identify.fit import identify  # noqa: PLC0415 - compiled code, once the job is claimed
    from ..report.contents.gather import Contents  # noqa: PLC0415
    from ..report.contents.schema import OF_A_FIT  # noqa: PLC0415
    from ..report.folder import held, together, write_text  # noqa: PLC0415
    from ..report.page.html_page import write_report  # noqa: PLC0415

    home.report(job.id, {"stage": "reading"})
    recordings = request.recordings()
    arguments = request.identification
    home.report(job.id, {"stage": "searching"})
    with held(out, wait=True), together(out, OF_A_FIT) as place:
        with JobProgress(home, job.id, _Drawing(recordings, arguments)) as progress:
            fit: Fit = identify(recordings, progress=progress, **arguments)
        write_text(place / "card.json", fit.card().text())
        home.report(job.id, {**progress.last, "stage": "page"})
        with np.errstate(all="ignore"):
            write_report(Contents(fit).report(request.command()), place)


def _select(home: Home, job: SessionJob, request: Request, out: Path) -> None:
    from ..identify.selection.select import select  # noqa: PLC0415
    from ..report.folder import held, together  # noqa: PLC0415
    from ..report.selection_report import write_selection  # noqa: PLC0415

    home.report(job.id, {"stage": "reading"})
    recordings = request.recordings()
    with held(out, wait=True), together(out) as place:
        with JobProgress(home, job.id) as progress:
            selection = select(
                recordings, rig=request.rig, progress=progress.task, **request.comparison()
            )
        write_selection(selection, place)


def _plan(home: Home, job: SessionJob, request: Request, out: Path) -> None:
    from ..identify.design.plan import plan  # noqa: PLC0415
    from ..report.folder import held, together, write_text  # noqa: PLC0415
    from ..report.plan_report import plan_text  # noqa: PLC0415

    home.report(job.id, {"stage": "reading"})
    recordings = request.recordings()
    home.report(job.id, {"stage": "planning"})
    with held(out, wait=True), together(out) as place:
        result = plan(home.results(job.parent or 0) / "card.json", recordings)
        write_text(place / "plan.json", plan_text(result))


def _compensate(home: Home, job: SessionJob, out: Path) -> None:
    from ..compensate.compensation import compensate  # noqa: PLC0415
    from ..report.compensation_report import write_compensation  # noqa: PLC0415
    from ..report.folder import held, together  # noqa: PLC0415

    home.report(job.id, {"stage": "trying"})
    with held(out, wait=True), together(out) as place:
        result = compensate(
            home.results(job.parent or 0) / "card.json",
            progress=lambda doing: home.report(job.id, {"stage": "trying", "task": doing}),
        )
        write_compensation(result, place)


class _Cancelling:
    """Looks, while entered, whether the job is cancelled, and then interrupts it as Ctrl-C does."""

    def __init__(self, folder: Path, number: int) -> None:
        self._folder, self._number = folder, number
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *raised: object) -> None:
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        with Home(self._folder) as home:
            while not self._over.wait(PACE):
                if home.job(self._number).cancelled:
                    _thread.interrupt_main()
                    return


class JobProgress(SearchProgress):
    """How far a search is, kept in the home; a cancelled search ends between two steps.

    Args:
        home: The home.
        number: The job.
        drawing: What draws the best motion so far; None where there is none.

    Attributes:
        last: What was said last.
    """

    def __init__(self, home: Home, number: int, drawing: _Drawing | None = None) -> None:
        super().__init__("", quiet=True)
        self._home, self._number, self._drawing = home, number, drawing
        self._told = -PACE
        self.last: dict[str, Any] = {}

    def __call__(self, searches: Sequence[Search]) -> None:
        """Say how far the searches are."""
        super().__call__(searches)
        self._tell(searches, "")

    def task(self, task: str, searches: Sequence[Search]) -> None:
        """Say the same of a comparison, and of which fit."""
        if searches:
            super().__call__(searches)
        self._tell(searches, task)

    def _tell(self, searches: Sequence[Search], task: str) -> None:
        now = time.monotonic()
        if now - self._told < PACE:
            return
        self._told = now
        self.last = {"stage": "searching", "task": task, "repeats": [_state(s) for s in searches]}
        if self._drawing is not None and searches:
            self.last["motion"] = self._drawing.motion(searches)
        self._home.report(self._number, self.last)


def _state(search: Search) -> dict[str, Any]:
    """How far one repeat is."""
    best = search.shown
    return {
        "evaluations": len(search.trace),
        "budget": search.budget,
        "best": best if np.isfinite(best) else None,
        "ended": search.ended or "",
    }


def _problem(recordings: Sequence[Any], arguments: Mapping[str, Any]) -> MotionProblem:
    """What a search minimises, of the arguments of `identify`."""
    from ..identify.problem import problem  # noqa: PLC0415 - compiled code

    known = ("rig", "law", "train", "fixed", "bounds", "loss")
    return problem(recordings, **{n: v for n, v in arguments.items() if n in known})


class _Drawing:
    """The motion of the best parameters so far beside the measured one, of the first log.

    Args:
        recordings: The logs.
        arguments: Those of `identify`.
    """

    def __init__(self, recordings: Sequence[Any], arguments: Mapping[str, Any]) -> None:
        self._recordings, self._arguments = recordings, arguments
        self._problem: MotionProblem | None = None
        self._best = np.inf
        self._motion: dict[str, Any] | None = None

    def motion(self, searches: Sequence[Search]) -> dict[str, Any] | None:
        """Times, measured and simulated position as shown; None where nothing can be drawn."""
        best = min(searches, key=lambda s: s.trace.cost)
        if best.trace.best < 0 or not best.trace.cost < self._best:
            return self._motion
        self._best = best.trace.cost
        try:
            self._motion = self._drawn(best)
        except InputError:  # what the search itself allows, and a whole log does not
            self._motion = None
        return self._motion

    def _drawn(self, best: Search) -> dict[str, Any] | None:
        if self._problem is None:
            self._problem = _problem(self._recordings[:1], self._arguments)
        parameters = self._problem.parameters
        x = best.run().x
        if len(x) != self._problem.space.dim:
            return None
        log = self._recordings[0]
        simulated = parameters.rig.simulate(parameters.law, parameters.full(x[None]), log)
        rows = np.unique(np.linspace(0, len(log) - 1, DRAWN).astype(int))
        position = np.interp(log.t[rows], simulated.t, simulated.position[0])
        scale = self._problem.scale
        return {
            "t": [float(f"{v:.6g}") for v in log.t[rows]],
            "measured": [float(f"{v / scale:.5g}") for v in log.position[rows]],
            "model": [float(f"{v / scale:.5g}") if np.isfinite(v) else None for v in position],
            "unit": self._problem.unit,
        }


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
