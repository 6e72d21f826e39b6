"""Results on real axes, beside published ones.

    python benchmarks/run.py --only axes

Each result goes to axes.json at once: an interrupted run continues there, and a part is measured
again after its keys have been taken out of that file. `python benchmarks/axes.py --errors` computes
the errors of the servo's parameters on file anew, with the simulation as it is now. The recordings
are not part of the repository: `../shared/data` beside it, see docs/axes.md.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import axis_joints
import axis_servo

FILE = Path(__file__).with_name("axes.json")


def measure(*, quick: bool = False) -> dict[str, Any]:
    """The servo with load-dependent friction, and three joints in stick-slip."""
    keep = _stored(FILE.with_name("axes_quick.json") if quick else FILE)
    return {
        "servo": axis_servo.measure(keep, quick=quick),
        "joints": axis_joints.measure(keep, quick=quick),
    }


def _stored(file: Path) -> Callable[[str, Callable[[], Any]], Any]:
    """Results by key, read from a file or measured."""

    def keep(key: str, measurement: Callable[[], Any]) -> Any:
        results = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        if key not in results:
            print(f"  {key}", flush=True)
            results[key] = measurement()
            draft = file.with_name(f".{file.name}.new")
            draft.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
            draft.replace(file)
        return results[key]

    return keep


def tables(results: Mapping[str, Any]) -> list[str]:
    """Markdown, the servo's tables first."""
    texts = [*axis_servo.tables(results["servo"]), *axis_joints.tables(results["joints"])]
    return texts or ["The logs are not beside the repository: nothing was measured.\n"]


def errors_anew() -> None:
    """The errors of the servo's parameters on file, with the simulation as it is now."""
    results = json.loads(FILE.read_text(encoding="utf-8"))
    axis_servo.errors_anew(results)
    FILE.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if "--errors" in sys.argv:
        errors_anew()
    else:
        print("\n\n".join(tables(measure(quick=True))))
