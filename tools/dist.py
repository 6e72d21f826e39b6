"""Build the wheel and the sdist, check them, and try the wheel where no repository is.

    python tools/dist.py [PYTHON ...]

The Pythons are those found of 3.11 to 3.14 by default. Each gets an environment of its own, and
goes the first two minutes of a user.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
TOOLS = ("build>=1.2,<2", "twine>=6,<7", "check-wheel-contents>=0.6,<0.7")
PYTHONS = ("python3.11", "python3.12", "python3.13", "python3.14")
#: What a user does first; the last needs what the others left.
FIRST_MINUTES = (
    "data slide --out slide.csv",
    "check slide.csv",
    "identify slide.csv --rig slide-bed --exact --train 325:127 --holdout 127:68 --out result",
    "export result/card.json --to st --out friction.st",
)


def run(*command: str | Path, folder: Path = ROOT) -> None:
    """Run a command without what this process has of the repository on its path."""
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run([str(word) for word in command], check=True, cwd=folder, env=clean)  # noqa: S603 - its own commands


def environment(folder: Path, python: str) -> Path:
    """A new environment; where its programs lie."""
    run(python, "-m", "venv", folder)
    return folder / ("Scripts" if os.name == "nt" else "bin")


def usable(python: str) -> bool:
    """Whether a Python is there, and runs: a version manager has names of absent ones, too."""
    if shutil.which(python) is None:
        return False
    tried = subprocess.run([python, "-c", ""], check=False, capture_output=True)  # noqa: S603 - a name of PYTHONS
    return tried.returncode == 0


def main() -> None:
    """Build, check, try."""
    with tempfile.TemporaryDirectory() as scratch:
        programs = environment(Path(scratch) / "tools", sys.executable)
        run(programs / "pip", "install", "--quiet", *TOOLS)
        shutil.rmtree(DIST, ignore_errors=True)
        run(programs / "python", "-m", "build", "--outdir", DIST)
        (wheel,) = DIST.glob("*.whl")
        (sdist,) = DIST.glob("*.tar.gz")
        run(programs / "twine", "check", "--strict", wheel, sdist)
        run(programs / "check-wheel-contents", wheel)
        for python in sys.argv[1:] or [name for name in PYTHONS if usable(name)]:
            place = Path(scratch) / Path(python).name
            stribeck = environment(place, python) / "stribeck"
            run(stribeck.parent / "pip", "install", "--quiet", wheel)
            away = place / "away"
            away.mkdir()
            for words in FIRST_MINUTES:
                run(stribeck, *words.split(), folder=away)
            for name in ("result/card.json", "result/report.html", "friction.st"):
                if not (away / name).is_file():
                    raise SystemExit(f"{python}: {name} is not there")
            print(f"{python}: installed, identified, exported")


if __name__ == "__main__":
    main()
