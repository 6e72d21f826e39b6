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
KEPT = {"twins": {"ecdf", "success"}, "bbob": {"ecdf", "profile"}}
#: Libraries that the numbers hang on.
LIBRARIES = ("stribeck", "numpy", "scipy", "numba", "cma", "pymoo", "niapy", "coco-experiment")


def main() -> None:
    """Run it and copy what is kept."""
    name, *engine = sys.argv[1:]
    out = Path("study") / name
    out.parent.mkdir(exist_ok=True)
    command = ["stribeck", "bench", name, "--out", str(out)]
    command += ["--engine", engine[0]] if engine else []
    whole = not (out / "store.sqlite").exists()
    began = time.monotonic()
    subprocess.run([sys.executable, "-m", *command], check=True)  # noqa: S603
    minutes = (time.monotonic() - began) / 60
    data, figures = Path("docs/data/study") / name, Path("docs/figures/study") / name
    for folder in (data, figures):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    for file in [*(out / "tables").iterdir(), out / "records.parquet"]:
        if file.suffix in {".txt", ".csv", ".parquet"} and file.stem != "comparisons":
            shutil.copy(file, data)
    shutil.copy(out / "tables" / "comparisons.csv", data)
    for file in (out / "figures").glob("*.png"):
        if file.stem in KEPT.get(name, {file.stem}):
            keep(file, figures)
    made = {
        "command": " ".join(command),
        **({"minutes": round(minutes, 1)} if whole else {}),
        "minutes_of_runs": round(pl.read_parquet(out / "records.parquet")["seconds"].sum() / 60, 1),
        "machine": f"{os.cpu_count()} cores, {platform.machine()}, {platform.system()}",
        "software": {
            "python": platform.python_version(),
            **{library: version(library) for library in LIBRARIES},
        },
    }
    if name == "paper":
        surfaces(figures.parent)
    (data / "made.json").write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


def surfaces(folder: Path) -> None:
    """The pictures of the problems: Table 1, and a twin of each."""
    with TemporaryDirectory() as place:
        for file in [*draw_surfaces(Path(place)), *draw_twins(7, Path(place))]:
            if file.suffix == ".png":
                keep(file, folder)


def keep(file: Path, folder: Path) -> None:
    """A picture in 128 colours, which is a third of its size; maps keep their shades."""
    if file.stem.startswith("movements"):
        shutil.copy(file, folder)
        return
    with Image.open(file) as picture:
        few = picture.convert("RGB").quantize(128, Image.Quantize.MAXCOVERAGE)
        few.save(folder / file.name, optimize=True)


if __name__ == "__main__":
    main()
