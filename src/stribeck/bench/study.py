"""All that is written and printed of a campaign: its tables, its figures, its page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..report import FORMS, Cell, Table
from ..report.folder import held, write_files
from . import paper_tables
from .problems import problem
from .record import Failure, Job, Record
from .run import trial
from .spreadsheets import write_sheets
from .surfaces import Surface
from .tables import comparisons, overall, ranking, solutions, summary

if TYPE_CHECKING:
    from .campaign import Campaign
    from .campaign_figures import CampaignFigure
    from .store import Progress

#: Tables that fit on a terminal.
PRINTED = ("table_4", "table_5", "percentages", "summary", "ranking", "ranking_moved", "overall")
#: Rows beyond which a table is left to its file.
LONGEST = 100


def status(cells: Sequence[Progress]) -> Table:
    """What is done of each cell in a store, and what is left."""
    heads = ("problem", "method", "done", "of", "met", "failed", "seconds")
    rows = tuple(
        (
            Cell.label(p.problem), Cell.label(p.algorithm), Cell.number(p.done),
            Cell.number(p.jobs), Cell.number(p.reached), Cell.number(p.given_up),
            Cell.number(p.seconds, 3),
        )
        for p in cells
    )  # fmt: skip
    done, jobs = sum(p.done for p in cells), sum(p.jobs for p in cells)
    return Table(f"{done:,} of {jobs:,} runs are done", heads, rows, "Met: reached the target.")


@dataclass(frozen=True)
class Study:
    """A campaign and what came of it.

    Args:
        campaign: What was compared.
        jobs: Every job of it.
        records: Those that are done.
        failures: Those that could not be run.
    """

    campaign: Campaign
    jobs: Sequence[Job]
    records: Sequence[Record]
    failures: Sequence[Failure]

    @cached_property
    def tables(self) -> dict[str, Table]:
        """The tables, by the name of their file."""
        records, jobs, reference = self.records, self.jobs, self.campaign.reference
        tables: dict[str, Table] = {}
        if self.campaign.name == paper_tables.NAME:
            tables |= {
                "table_4": paper_tables.table_4(records),
                "table_5": paper_tables.table_5(records),
                "percentages": paper_tables.percentages(records),
            }
        targets = self.campaign.targets(jobs)
        moved = {t.label for t in self.campaign.tasks if "each" in t.spec.values()}
        if 0 < len(moved) < len(self.campaign.tasks):
            alone = [r for r in records if r.job.problem in moved]
            meant = [j for j in jobs if j.problem in moved]
            title = "Ranking on the problems that change from run to run alone"
            tables["ranking_moved"] = replace(ranking(alone, meant, targets=targets), title=title)
        return tables | {
            "summary": summary(records, jobs),
            "solutions": solutions(records, jobs),
            "ranking": ranking(records, jobs, targets=targets),
            "overall": overall(records, jobs, reference=reference),
            "comparisons": comparisons(records, jobs, reference=reference),
        }

    def figures(self) -> Iterator[CampaignFigure]:
        """The figures; for the tracks of bacteria a run is run again."""
        from .campaign_figures import figures  # noqa: PLC0415 - matplotlib comes late on purpose

        yield from figures(self.records, self.jobs, self.campaign.targets(self.jobs))
        yield from self._movements()

    def _movements(self) -> Iterator[CampaignFigure]:
        """The paper's figure 2: the reference's first run on each surface of two variables."""
        from .movements import movements  # noqa: PLC0415

        for record in self.records:
            job = record.job
            if job.repeat or job.algorithm != self.campaign.reference or len(record.x) != 2:  # noqa: PLR2004
                continue
            surface = problem(job.surface)
            if isinstance(surface, Surface) and "foraging" in record.rounds:
                title = f"{job.algorithm} on {job.problem}, {surface.title}"
                trace, optima = trial(job, surface).trace, surface.optima.tolist()
                drawn = movements(surface, trace, optima=optima, title=title)
                yield replace(drawn, name=f"movements_{job.problem}")

    def write(self, folder: Path) -> None:
        """Write the records, `tables/`, `figures/`, `campaign.toml` and `summary.html`.

        Raises:
            InputError: the disk refuses.
        """
        from .campaign_figures import draw  # noqa: PLC0415
        from .summary import command, write_summary  # noqa: PLC0415

        def write(place: Path) -> None:
            write_sheets(self.records, place)
            (place / "campaign.toml").write_text(self.campaign.text, encoding="utf-8")
            (place / "tables").mkdir()
            self._write_tables(place / "tables")
            drawn = list(self.figures())
            (place / "figures").mkdir()
            draw(drawn, place / "figures")
            write_summary(
                place,
                self.campaign,
                self.jobs,
                self.records,
                self.failures,
                tables=self.tables,
                figures=drawn,
                command=command(self.campaign),
            )

        with held(folder, wait=True):  # several processes may work on one store
            write_files(folder, write)

    def _write_tables(self, folder: Path) -> None:
        for name, table in self.tables.items():
            for ending, form in FORMS.items():
                (folder / f"{name}.{ending}").write_text(form(table), encoding="utf-8")

    def text(self) -> str:
        """The tables that a terminal can show."""
        shown = [self.tables[name] for name in PRINTED if name in self.tables]
        return "\n".join(t.text() for t in shown if len(t.rows) <= LONGEST)
