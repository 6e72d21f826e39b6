"""The command that compares search methods."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import InputError
from .exits import fail
from .interruption import interruption

if TYPE_CHECKING:
    from ..bench.campaign import Campaign
    from ..bench.engines import Engine
    from ..bench.record import Job


def bench(
    campaign: Annotated[str, typer.Argument(metavar="paper|twins|bbob|FILE.toml", help="A shipped campaign (paper, twins, bbob) or a file.")],
    trials: Annotated[int | None, typer.Option(metavar="N", help="Runs of every cell, in place of the file's.")] = None,
    engine: Annotated[str, typer.Option(metavar="E", help="here, processes[:N] or dask://HOST:PORT.")] = "processes",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Where the store and the results go; bench-NAME by default.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Insist on a store that is there; without it one is begun or gone on with.")] = False,
    coco: Annotated[bool, typer.Option("--coco", help="Write BBOB runs as COCO's own data too, and its report.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Print the campaign's file and stop.")] = False,
    status: Annotated[bool, typer.Option("--status", help="Say what is done and what is left, and stop.")] = False,
) -> None:  # fmt: skip
    """Compare search methods: the paper's study, or any campaign."""
    from ..bench.campaign import campaign as campaign_named
    from ..bench.engines import engine as engine_named

    plan = campaign_named(campaign)
    if show:
        typer.echo(plan.text, nl=False)
        return
    if coco and not any("bbob" in task.spec for task in plan.tasks):
        raise InputError(f"--coco: campaign {plan.name} has no problem of BBOB")
    if status:
        from ..bench.store import Store
        from ..bench.study import status as study_status

        with Store.read((out or Path(f"bench-{plan.name}")) / "store.sqlite") as store:
            typer.echo(study_status(store.progress()).text(), nl=False)
        return
    plan = plan if trials is None else plan.trials(trials)
    _bench(plan, engine_named(engine), out or Path(f"bench-{plan.name}"), resume, coco)


def _bench(plan: Campaign, at: Engine, folder: Path, resume: bool, coco: bool) -> None:
    from ..bench.progress import Live
    from ..bench.record import Failure, Record
    from ..bench.runner import conduct
    from ..bench.store import Store
    from ..bench.study import Study
    from ..report.folder import check_folder

    check_folder(folder)
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
        typer.echo(study.text(), nl=False)
        if coco:
            _coco([r.job for r in records if "bbob" in r.job.surface], folder / "coco")
    except KeyboardInterrupt:
        fail(
            f"interrupted: the runs are safe in {file}; the same command goes on",
            interruption.status,
        )
    typer.echo(f"\nstore, tables, figures and summary.html in {folder}")
    if failures:
        typer.echo(f"stribeck: {len(failures)} runs failed: see the summary", err=True)
        raise typer.Exit(1)


def _coco(jobs: list[Job], folder: Path) -> None:
    from shutil import rmtree

    from ..bench.coco import observe, postprocess

    rmtree(folder / "exdata", ignore_errors=True)  # the same again, or what a kill cut short
    for done, _ in enumerate(observe(jobs, folder), 1):
        if done % 100 == 0 or done == len(jobs):
            typer.echo(f"{done:,}/{len(jobs):,} runs in COCO's own form", err=True)
    typer.echo(f"COCO's report: {postprocess(folder)}")
