"""Selection of laws for two real axes: a ball screw by force balance, a servo by simulated motion.

    python benchmarks/run.py --only selection

The logs are not part of the repository: `../shared/data` beside it, see docs/validation.md. Without
them nothing is measured.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stribeck import RIGS, read, select
from stribeck.data.recording import Recording
from stribeck.identify.selection.select import Selection
from stribeck.report.selection_report import against, selection_text

DATA = Path(__file__).parents[2] / "shared" / "data"
#: The servo's laws, and the gain that is held out.
SERVO = ("coulomb-viscous", "stribeck-free", "bam-m3", "bam-m4", "bam-m5", "bam-m6")
TESTED = 800.0


def measure(*, quick: bool = False) -> dict[str, Any]:
    """Compare the laws; a short pass leaves out the servo's richer ones."""
    results: dict[str, Any] = {}
    if (DATA / "emps").exists():
        results["emps"] = _compared(
            "EMPS, trained on the smooth run, held out: the run with pulses of force",
            [_log(DATA / "emps" / "DATA_EMPS.mat", "emps")],
            [_log(DATA / "emps" / "DATA_EMPS_PULSES.mat", "emps")],
            "emps",
            None,
        )
    if (DATA / "bam_xl330").exists():
        files = sorted((DATA / "bam_xl330" / "logs").glob("*.json"))
        logs = [_log(file, "servo-pendulum") for file in files]
        high = [float(log.extra["kp"][0]) == TESTED for log in logs]
        results["servo"] = _compared(
            "Dynamixel XL330, trained at gains of 100, 200 and 400, held out: 800",
            [log for log, out in zip(logs, high, strict=True) if not out],
            [log for log, out in zip(logs, high, strict=True) if out],
            "servo-pendulum",
            SERVO[:3] if quick else SERVO,
        )
    return results


def _log(file: Path, rig: str) -> Recording:
    return read(file, columns=dict(RIGS[rig].columns))


def _compared(
    title: str,
    train: Sequence[Recording],
    test: Sequence[Recording],
    rig: str,
    laws: Sequence[str] | None,
) -> dict[str, Any]:
    start_time = time.perf_counter()
    selection = select(train, rig=rig, laws=laws, test=test)
    document: dict[str, Any] = json.loads(selection_text(selection))
    return {
        "title": title,
        "seconds": time.perf_counter() - start_time,
        "change": _changes(selection),
        "selection": {n: v for n, v in document.items() if n != "data"},
    }


def _changes(selection: Selection) -> dict[str, str]:
    return {c.name: against(c.against) for c in selection.candidates}


def tables(results: Mapping[str, Any]) -> list[str]:
    """The comparisons, as Markdown."""
    if not results:
        return ["The logs are not beside the repository: nothing was compared.", ""]
    lines: list[str] = []
    for part in results.values():
        s = part["selection"]
        heads = (
            f"| law | free | training / {s['unit']} | held out / {s['unit']} | against the best | "
            "lag 1 | not identifiable | evaluations | fit / s |"
        )
        lines += [
            f"**{part['title']}**",
            "",
            heads,
            "|---|---:|---:|---:|---|---:|---|---:|---:|",
            *(
                f"| {_marked(law, s)} | {law['free']} | {law['training_error']:.4g} | "
                f"{law['held_out_error']:.4g} | {part['change'][law['law']]} | "
                f"{law['residuals']['lag_1']:.3f} | {', '.join(law['not_identifiable'])} | "
                f"{law['evaluations']:,} | {law['seconds']:.1f} |"
                for law in s["laws"]
            ),
            "",
            *(f"- {sentence}" for sentence in s["sentences"]),
            "",
        ]
    return lines


def _marked(law: Mapping[str, Any], s: Mapping[str, Any]) -> str:
    return f"**{law['law']}**" if law["law"] == s["recommended"] else str(law["law"])


if __name__ == "__main__":
    print("\n".join(tables(measure(quick=True))))
