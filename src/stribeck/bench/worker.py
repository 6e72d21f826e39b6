"""The worker program: it reads a job a line and writes an outcome a line.

    python -m stribeck.bench.worker

Its first line says what it runs with, see `software`. It ends, whatever it is at, when its input
ends: no worker outlives the program that started it.
"""

from __future__ import annotations

import json
import os
import re
import signal
from functools import cache
from importlib import import_module
from importlib.metadata import version
from queue import SimpleQueue
from threading import Lock, Thread
from typing import IO, TypeVar

from .._version import __version__
from ..errors import InputError
from .work_item import WorkItem

Outcome = TypeVar("Outcome")
#: The module that runs a job whose text names none, and the names that a text may have.
_RUNNER, _NAMES = "stribeck.bench.run", re.compile(r"stribeck(\.[a-z_]+)+")

#: Libraries of others keep state for the whole process: in one process jobs run one by one.
_ALONE = Lock()


def answer(text: str) -> str:
    """Run a job.

    Args:
        text: The job's text.

    Returns:
        One line: its record's text, or that of a failure.
    """
    with _ALONE:
        try:
            return _run(text)
        except InputError as error:
            return refusal(str(error))
        except Exception as error:  # noqa: BLE001 - one bad job does not end a campaign
            return refusal(f"{type(error).__name__}: {error}")


def _run(text: str) -> str:
    """The text of a job's record.

    What runs jobs is not imported above: a Dask scheduler imports this file and runs nothing.
    """
    runner = json.loads(text).get("runner", _RUNNER)
    if not _NAMES.fullmatch(runner):
        raise InputError(f"no runner {runner!r}")
    record_text: str = import_module(runner).record_text(text)
    return record_text


def refusal(message: str) -> str:
    """The line that says why a job has no record."""
    return json.dumps({"failure": one_line(message)})


def outcome(job: WorkItem[Outcome], line: str) -> Outcome:
    """What a job's line says.

    Raises:
        ValueError: it is not the outcome of this job.
    """
    try:
        message = json.loads(line)
        if set(message) == {"failure"}:
            return job.failed(str(message["failure"]))
        return job.done(line)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not an outcome: {line[:60]!r}") from error


def one_line(text: str) -> str:
    """A message on one line that a table can hold."""
    return " ".join(text.split())[:500]


def run_remote(text: str, needs: str) -> str:
    """Run a job that another machine has sent.

    Args:
        text: The job's text.
        needs: The `software` that its record must be made with.

    Returns:
        Its `answer`.

    Raises:
        InputError: the software here is another.
    """
    if (have := software()) != needs:
        raise InputError(f"a worker runs {have}: the campaign runs {needs}")
    return answer(text)


@cache
def software() -> str:
    """What the numbers of a record hang on: where it is equal, so are the records.

    Looked up once: what a process has loaded stays what it is.
    """
    libraries = (f"{name} {version(name)}" for name in ("numpy", "scipy", "numba"))
    return ", ".join([f"stribeck {__version__}", *libraries])


def main() -> None:
    """Answer jobs until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it reaches us too: the driver decides
    requests, answers = _own(0, "r"), _own(1, "w")
    jobs = SimpleQueue[str]()
    Thread(target=_listen, args=(requests, jobs), daemon=True).start()
    _say(answers, software())
    while True:
        _say(answers, answer(jobs.get()))


def _own(fd: int, mode: str) -> IO[str]:
    """A pipe that is ours alone: what a library reads is empty, what it prints goes to stderr."""
    pipe = os.fdopen(os.dup(fd), mode, encoding="utf-8", newline="\n")
    if fd == 0:
        with open(os.devnull, encoding="utf-8") as nothing:  # noqa: PTH123 - not a file
            os.dup2(nothing.fileno(), 0)
    else:
        os.dup2(2, fd)
    return pipe


def _say(pipe: IO[str], line: str) -> None:
    try:
        pipe.write(f"{line}\n")
        pipe.flush()
    except OSError:
        os._exit(1)  # nobody listens any more


def _listen(pipe: IO[str], jobs: SimpleQueue[str]) -> None:
    for line in pipe:
        jobs.put(line)
    os._exit(0)  # not sys.exit: the job in progress is of no use to anyone


if __name__ == "__main__":
    main()
