"""Many small jobs whose answers are lines of a file: an interrupted run goes on from there."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numba

from stribeck.bench.engines import cores

#: The answer of a job; what `named` makes of it is the job's arguments.
Answer = dict[str, Any]
Job = tuple[Hashable, ...]


def completed(
    file: Path, jobs: Sequence[Job], work: Callable[..., Answer], named: Callable[[Answer], Job]
) -> list[Answer]:
    """The answers of jobs in their order; those that are not in the file yet are worked out.

    Args:
        file: Of answers, a line of JSON each.
        jobs: Arguments of `work`.
        work: A function of a module, which other processes can import.
        named: The job that an answer is of.
    """
    answers = {named(a): a for a in lines(file)}
    missing = [job for job in jobs if job not in answers]
    with file.open("a", encoding="utf-8") as stream:
        for answer in _worked(missing, work):
            answers[named(answer)] = answer
            stream.write(json.dumps(answer) + "\n")
            stream.flush()
    return [answers[job] for job in jobs]


def lines(file: Path) -> list[Answer]:
    """The lines of a file; one that was cut off while it was written is left out."""
    if not file.exists():
        return []
    texts = file.read_text(encoding="utf-8").split("\n")
    if texts[-1]:
        file.write_text("".join(f"{text}\n" for text in texts[:-1]), encoding="utf-8")
    return [json.loads(text) for text in texts[:-1]]


def _worked(missing: Sequence[Job], work: Callable[..., Answer]) -> Iterator[Answer]:
    if min(cores(), len(missing)) < 2:  # noqa: PLR2004 - one core needs no other process
        numba.set_num_threads(1)
        yield from (work(*job) for job in missing)
        return
    fresh = get_context("spawn")
    with ProcessPoolExecutor(
        min(cores(), len(missing)), fresh, numba.set_num_threads, (1,)
    ) as pool:
        for ended in as_completed([pool.submit(work, *job) for job in missing]):
            yield ended.result()
