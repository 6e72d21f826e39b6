"""Run every command that the README and the docs show, and put its output below it.

    python tools/docs.py [PAGE.md ...]

A page marks a command with a comment, and the block that follows belongs to it:

    <!-- $ stribeck rigs -->
    ```text
    ...
    ```

Commands run in order from the repository's root with `demo/` present (`make demo` makes it) and
the recordings of others in `../shared/data`; a command whose data are absent keeps its block.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

PAGES = [Path("README.md"), *sorted(Path("docs").rglob("*.md"))]
BLOCK = re.compile(r"<!-- \$ (?P<command>.+?) -->\n```text\n(?P<said>.*?)```\n", re.DOTALL)
DATA = Path("../shared/data")


def run(match: re.Match[str]) -> str:
    """A marked block with the output of its command."""
    command = match["command"]
    if str(DATA) in command and not DATA.exists():
        print(f"  kept: {command} ({DATA} is not there)")
        return match[0]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    completed = subprocess.run(  # noqa: S602 - the commands are the pages' own
        command, shell=True, check=False, capture_output=True, text=True,
        env={**os.environ, "PATH": path, "COLUMNS": "100"},
    )  # fmt: skip
    output = "\n".join(
        line.rstrip() for line in (completed.stdout or completed.stderr).splitlines()
    )
    print(f"  {completed.returncode}: {command}")
    return f"<!-- $ {command} -->\n```text\n$ {command}\n{output}\n```\n"


def main() -> None:
    """Renew the pages named, or all."""
    for page in [Path(p) for p in sys.argv[1:]] or PAGES:
        print(page)
        text = page.read_text(encoding="utf-8")
        page.write_text(BLOCK.sub(run, text), encoding="utf-8")


if __name__ == "__main__":
    main()
