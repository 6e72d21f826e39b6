"""Run a shipped campaign and keep its results as data.

    python tools/study.py paper|twins|bbob [ENGINE]

The store goes to study/NAME (not kept), where the same command goes on after an interruption; the
tables and the records to docs/data/study/NAME, the figures to docs/figures/study/NAME.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import polars as pl
from PIL import Image

from surface_figures import draw_surfaces, draw_twins

#: Figures that are kept, where it is not all of them.
FIGURE_NAMES = {"twins": {"ecdf", "success"}, "bbob": {"ecdf", "profile"}}
#: Libraries on which the numbers depend.
LIBRARIES = ("stribeck", "numpy", "scipy", "numba", "cma", "pymoo", "niapy", "coco-experiment")


def main() -> None:
    """Run the campaign and copy its tables, records and figures."""
    name, *engine = sys.argv[1:]
    campaign_folder = Path("study") / name
    campaign_folder.parent.mkdir(exist_ok=True)
    command = ["stribeck", "bench", name, "--out", str(campaign_folder)]
    command += ["--engine", engine[0]] if engine else []
    whole = not (campaign_folder / "store.sqlite").exists()
    start_time = time.monotonic()
    subprocess.run([sys.executable, "-m", *command], check=True)  # noqa: S603
    minutes = (time.monotonic() - start_time) / 60
    data, figures = Path("docs/data/study") / name, Path("docs/figures/study") / name
    for folder in (data, figures):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    for file in [*(campaign_folder / "tables").iterdir(), campaign_folder / "records.parquet"]:
        if file.suffix in {".txt", ".csv", ".parquet"} and file.stem != "comparisons":
            shutil.copy(file, data)
    shutil.copy(campaign_folder / "tables" / "comparisons.csv", data)
    for file in (campaign_folder / "figures").glob("*.png"):
        if file.stem in FIGURE_NAMES.get(name, {file.stem}):
            keep(file, figures)
    document = {
        "command": " ".join(command),
        **({"minutes": round(minutes, 1)} if whole else {}),
        "minutes_of_runs": round(
            pl.read_parquet(campaign_folder / "records.parquet")["seconds"].sum() / 60, 1
        ),
        "machine": f"{os.cpu_count()} cores, {platform.machine()}, {platform.system()}",
        "software": {
            "python": platform.python_version(),
            **{library: version(library) for library in LIBRARIES},
        },
    }
    if name == "paper":
        surfaces(figures.parent)
    (data / "made.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def surfaces(folder: Path) -> None:
    """The pictures of the problems: Table 1, and a twin of each."""
    with TemporaryDirectory() as place:
        for file in [*draw_surfaces(Path(place)), *draw_twins(7, Path(place))]:
            if file.suffix == ".png":
                keep(file, folder)


def keep(file: Path, folder: Path) -> None:
    """Copy a picture in 128 colours, a third of its size; maps keep their shades."""
    if file.stem.startswith("movements"):
        shutil.copy(file, folder)
        return
    with Image.open(file) as picture:
        reduced = picture.convert("RGB").quantize(128, Image.Quantize.MAXCOVERAGE)
        reduced.save(folder / file.name, optimize=True)


if __name__ == "__main__":
    main()
