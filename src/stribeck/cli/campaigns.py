"""The command that compares search methods."""

from __future__ import annotations

from pathlib import Path
from tomllib import loads
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from ..errors import InputError
from .exits import fail
from .inputs import Json
from .interruption import interruption

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..bench.campaign import Campaign
    from ..bench.engines import Engine
    from ..bench.record import Job
    from ..bench.study import Study


def bench(
    campaign: Annotated[str, typer.Argument(metavar="paper|twins|bbob|FILE.toml", help="A shipped campaign (paper, twins, bbob) or a file.")],
    trials: Annotated[int | None, typer.Option(metavar="N", help="Runs of every cell, in place of the file's.")] = None,
    engine: Annotated[str, typer.Option(metavar="E", help="here, processes[:N] or dask://HOST:PORT.")] = "processes",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Where the store and the results go; bench-NAME by default.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Insist on a store that is there; without it one is begun or gone on with.")] = False,
    coco: Annotated[bool, typer.Option("--coco", help="Write BBOB runs as COCO's own data too, and its report.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Print the campaign's file and stop.")] = False,
    status: Annotated[bool, typer.Option("--status", help="Say what is done and what is left, and stop.")] = False,
    json: Json = False,
) -> None:  # fmt: skip
    """Compare search methods: the paper's study, or any campaign."""
    from ..bench.campaign import campaign as campaign_named
    from ..bench.engines import engine as engine_named

    plan = campaign_named(campaign)
    if show:
        typer.echo(_document({"campaign": loads(plan.text)}) if json else plan.text, nl=False)
        return
    if coco and not any("bbob" in task.spec for task in plan.tasks):
        raise InputError(f"--coco: campaign {plan.name} has no problem of BBOB")
    if status:
        from ..bench.store import Store
        from ..bench.study import status as study_status

        with Store.read((out or Path(f"bench-{plan.name}")) / "store.sqlite") as store:
            cells = store.progress()
        entries = {"campaign": plan.name, "cells": [cell._asdict() for cell in cells]}
        typer.echo(_document(entries) if json else study_status(cells).text(), nl=False)
        return
    plan = plan if trials is None else plan.trials(trials)
    folder = out or Path(f"bench-{plan.name}")
    study = _studied(plan, engine_named(engine), folder, resume)
    _show(study, folder, coco=coco, json=json)


def _document(entries: Mapping[str, Any]) -> str:
    from ..report.format import json_text

    return json_text({"schema": "stribeck-bench/1", **entries})


def _studied(plan: Campaign, at: Engine, folder: Path, resume: bool) -> Study:
    """The campaign run, and what came of it written."""
    from ..bench.progress import Live
    from ..bench.record import Failure, Record
    from ..bench.runner import conduct
    from ..bench.store import Store
    from ..bench.study import Study
    from ..bench.third_party import check_installed
    from ..report.folder import check_folder

    check_folder(folder)
    check_installed(entry.method for entry in plan.entries)
    file = folder / "store.sqlite"
    with Store.open(
        file, campaign=plan.name, seed=plan.seed, text=plan.text, must_exist=resume
    ) as store:
        jobs = list(plan.jobs())
        store.add(jobs)
        try:
            with Live(plan.name, jobs, store.records(), workers=at.workers) as live:
                for outcome in conduct(store, at):
                    if isinstance(outcome, Record):
                        live.finished(outcome)
                    elif isinstance(outcome, Failure):
                        live.failed(outcome)
                    else:
                        live.waiting(outcome)
            records, failures = list(store.records()), store.failures()
        except KeyboardInterrupt:
            fail(
                f"interrupted: {store.left()} runs are left, the others are safe in {file}; "
                "the same command goes on",
                interruption.status,
            )
    try:
        study = Study(plan, jobs, records, failures)
        study.write(folder)
    except KeyboardInterrupt:
        _interrupted(file)
    return study


def _interrupted(file: Path) -> NoReturn:
    fail(f"interrupted: the runs are safe in {file}; the same command goes on", interruption.status)


def _show(study: Study, folder: Path, *, coco: bool, json: bool) -> None:
    """Print the tables, and where the rest is.

    Raises:
        Exit: runs have failed.
    """
    if not json:
        typer.echo(study.text(), nl=False)
    report = ""
    try:
        if coco:
            report = _coco(
                [r.job for r in study.records if "bbob" in r.job.surface], folder / "coco"
            )
    except KeyboardInterrupt:
        _interrupted(folder / "store.sqlite")
    if json:
        tables = {name: table.document() for name, table in study.tables.items()}
        entries = {
            "campaign": study.campaign.name, "folder": str(folder), "runs": len(study.records),
            "failed": len(study.failures), "coco": report or None, "tables": tables,
        }  # fmt: skip
        typer.echo(_document(entries), nl=False)
    else:
        typer.echo(f"COCO's report: {report}\n" * bool(report), nl=False)
        typer.echo(f"\nstore, tables, figures and summary.html in {folder}")
    if study.failures:
        typer.echo(f"stribeck: {len(study.failures)} runs failed: see the summary", err=True)
        raise typer.Exit(1)


def _coco(jobs: list[Job], folder: Path) -> str:
    """Where COCO's report of these runs is."""
    from shutil import rmtree

    from ..bench.coco import observe, postprocess

    rmtree(folder / "exdata", ignore_errors=True)  # the same again, or what a kill cut short
    for done, _ in enumerate(observe(jobs, folder), 1):
        if done % 100 == 0 or done == len(jobs):
            typer.echo(f"{done:,}/{len(jobs):,} runs in COCO's own form", err=True)
    return str(postprocess(folder))
