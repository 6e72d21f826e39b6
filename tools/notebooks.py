"""Run the notebooks of the docs, and keep what they print and show.

    python tools/notebooks.py [--out DIR] [NOTEBOOK ...]

Each runs in a folder of its own, from a fresh kernel. With `--out` that folder is DIR, and the
notebook with its outputs is written there in place of the one in the docs.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = sorted(Path(__file__).parents[1].joinpath("docs", "notebooks").glob("*.ipynb"))
#: Seconds for one cell, on a slow machine that compiles for the first time.
PATIENCE = 600


def run(notebook: Path, folder: Path) -> Any:
    """A notebook with the outputs of its cells, and without what differs from run to run."""
    document: Any = nbformat.read(notebook, as_version=4)  # type: ignore[no-untyped-call]
    resources = {"metadata": {"path": str(folder)}}
    # A kernel sends what was printed whenever its timer says so: what belongs together is joined.
    NotebookClient(
        document, timeout=PATIENCE, kernel_name="python3", resources=resources,
        coalesce_streams=True,
    ).execute()  # fmt: skip
    document.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}
    }
    for cell in document.cells:
        cell.metadata = {}
        for output in cell.get("outputs", []):
            if output.output_type == "stream" and output.name == "stderr":
                raise SystemExit(f"{notebook}: {output.text}")
            if "metadata" in output:
                output.metadata = {}
    return document


def main() -> None:
    """Run the notebooks named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--out", type=Path)
    parser.add_argument("notebooks", nargs="*", type=Path, default=NOTEBOOKS)
    arguments = parser.parse_args()
    source = Path(__file__).parents[1] / "src"
    os.environ["PYTHONPATH"] = os.pathsep.join([str(source), os.environ.get("PYTHONPATH", "")])
    os.environ.pop("MPLBACKEND", None)  # figures are shown as a reader's kernel shows them
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for notebook in arguments.notebooks:
        with tempfile.TemporaryDirectory() as scratch:
            folder = arguments.out or Path(scratch)
            document = run(notebook, folder)
            target = notebook if arguments.out is None else folder / notebook.name
            nbformat.write(document, target)  # type: ignore[no-untyped-call]
            print(target)


if __name__ == "__main__":
    main()
