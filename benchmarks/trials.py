"""The runs of a campaign, kept in memory: the machinery of `stribeck bench` without its folder."""

from __future__ import annotations

import json
from collections.abc import Sequence

from stribeck.bench.campaign import parsed
from stribeck.bench.engines import Processes, cores
from stribeck.bench.record import Failure, Record


def methods(settings: dict[str, str]) -> str:
    """`[[method]]` tables of a campaign, from labels and their settings in TOML."""
    return "\n".join(
        f"[[method]]\nname = {json.dumps(label)}\n{table}\n" for label, table in settings.items()
    )


def records(campaign: str) -> list[Record]:
    """Run a campaign's TOML on all cores.

    Raises:
        RuntimeError: a run failed.
    """
    jobs = list(parsed(campaign).jobs())
    outcomes: list[Record] = []
    for outcome in Processes(min(cores(), len(jobs))).run(iter(jobs)):
        match outcome:
            case Record():
                outcomes.append(outcome)
            case Failure(job, message):
                raise RuntimeError(f"{job.problem}, {job.algorithm}: {message}")
    return outcomes


def named(texts: Sequence[str]) -> str:
    """Words as a list in TOML."""
    return json.dumps(list(texts))
