"""Print docs/data/twin_study.json as the table of docs/validation.md."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def main() -> None:
    """Print the study."""
    study = json.loads(Path("docs/data/twin_study.json").read_text())
    print(f"{study['seeds']} seeds; median (least to greatest)")
    for side in ("right", "left"):
        part = study[side]
        at_truth = f"J at the truth {part['J_at_truth']:.3f} mm"
        print(f"\n{side}ward, trained on {part['train']} mm; {at_truth}")
        endings = part["endings"]
        print(f"{'':22}" + "".join(f"{name:>36}" for name in endings))
        columns = [_column(ending) for ending in endings.values()]
        for label in columns[0]:
            print(f"{label:22}" + "".join(f"{column[label]:>36}" for column in columns))


def _column(ending: dict[str, Any]) -> dict[str, str]:
    off = ending["off_from_truth_percent"]
    return {
        "runs below 4.5 mm": str(ending["below_4.5"]),
        "J / mm": _spread(ending["J_mm"]),
        "evaluations": _spread(ending["evaluations"]),
        **{f"{name} off by / %": _spread(spread) for name, spread in off.items()},
    }


def _spread(part: dict[str, float]) -> str:
    return f"{part['median']:.4g} ({part['min']:.4g} to {part['max']:.4g})"


if __name__ == "__main__":
    main()
