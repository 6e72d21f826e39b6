"""The recording that the package brings: the paper's test bed, simulated with its sensors.

    python tools/sample.py

It has the channels that the identification of a slide reads, as `stribeck twin` writes them.
"""

from __future__ import annotations

import gzip
import tempfile
from pathlib import Path

import polars as pl

from stribeck.report.motion_file import write_twin
from stribeck.rig.twin import TestBed

PLACE = Path(__file__).parents[1] / "src" / "stribeck" / "data" / "samples" / "slide.csv.gz"
COLUMNS = ("t_s", "command_mm", "position_mm", "force_N")


def text() -> bytes:
    """The log, as it is packed."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "slide.csv"
        write_twin(TestBed(rate=50.0, loop="ideal"), "both", 0, log)
        columns = pl.read_csv(log, columns=COLUMNS, infer_schema=False)
    return columns.select(COLUMNS).write_csv().encode()


if __name__ == "__main__":
    PLACE.write_bytes(gzip.compress(text(), 9, mtime=0))
    print(PLACE)
