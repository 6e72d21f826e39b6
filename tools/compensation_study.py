"""The effect of an identified compensation on a known axis, the slide bed's twin.

Identifies both directions of demo/twin.csv at once, takes the recommended compensator, and tries
it on the true axis beside those that the card allows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stribeck import RIGS, card, identify, read
from stribeck.compensate.compensation import compensation
from stribeck.report.format import number
from stribeck.report.table import Table
from stribeck.report.terminal import console, show_table
from stribeck.rig.slide_bed import SLIDE_BED, published_both


def main() -> None:
    """Run the study from the repository's root, after `make demo`."""
    log = read(Path("demo/twin.csv"), columns=dict(RIGS["slide-bed"].columns) or None)
    fit = identify(log, rig=SLIDE_BED.exact(), law="stribeck-directional")
    result = compensation(card(fit), recordings=[log], beside={"truth": published_both()})
    truth = result.plants.index("truth")
    rows = []
    for curve in result.curves:
        if curve.best is None:
            continue
        for m, motion in enumerate(result.motions):
            ratio = curve.ratio[curve.best]
            allowed = np.delete(ratio[:, m], truth)
            rows.append([
                curve.mode, f"{curve.scale:.4g}", motion,
                number(1e3 * curve.rms[0, truth, m], 3),
                number(1e3 * curve.rms[curve.best, truth, m], 3),
                f"{1 / ratio[truth, m]:.3g}×", f"{1 / allowed.max():.3g}×",
            ])  # fmt: skip
    heads = ["mode", "scale", "motion", "truth without/mm", "with/mm", "less", "worst axis"]
    show_table(Table.of_texts("", heads, rows))
    for curve in result.curves:
        o = curve.onset
        console().print(
            f"{curve.mode}: "
            + ("no sign of too much" if o is None else f"{o.sign} from {o.scale:.4g} ({o.plant})")
        )


if __name__ == "__main__":
    main()
