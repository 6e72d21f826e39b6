"""Patterns of weakness in the source, and known weaknesses of what is locked: `make audit`.

    python tools/audit.py requirements.lock src tools benchmarks

bandit reads the source; pip-audit asks a public database about each locked version. Without a
network, or where a mirror has no such database, a line tells about how many it could not be asked.
Exit status 1 where either has something, 0 else. Runs where both are installed, and needs nothing
of stribeck.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any


def patterns(folders: Sequence[str]) -> list[str]:
    """What bandit has against the source, a line each; prints how much it has read.

    Raises:
        SystemExit: it did not read it.
    """
    options = ("--configfile", "pyproject.toml", "--severity-level", "medium", "--format", "json")
    done = _run("bandit", "--quiet", *options, "--recursive", *folders)
    try:
        whole = json.loads(done.stdout)
    except ValueError:
        sys.exit(f"bandit: {_last(done)}")
    lines = [f"{e['filename']}: {e['reason']}" for e in whole["errors"]]
    lines += [
        f"{r['filename']}:{r['line_number']}: {r['test_id']} {r['issue_text']}"
        for r in whole["results"]
    ]
    loc = whole["metrics"]["_totals"]["loc"]
    print(f"bandit: {len(lines)} findings of medium severity or above in {loc:,} lines")
    return lines


def known(lock: str) -> list[str]:
    """Known weaknesses of what is locked, a line each; prints how many could be asked about."""
    options = ("--progress-spinner", "off", "--format", "json")
    done = _run("pip_audit", "--disable-pip", "--require-hashes", *options, "--requirement", lock)
    try:
        packages = json.loads(done.stdout)["dependencies"]
    except ValueError:
        print(f"pip-audit: could not ask about what is locked: {_last(done)}")
        return []
    lines = weaknesses(packages)
    skipped = sum("skip_reason" in p for p in packages)
    asked = len(packages) - skipped
    text = f"pip-audit: {len(lines)} known weaknesses in {asked} packages"
    print(f"{text}; its database could not be asked about {skipped} others" if skipped else text)
    return lines


def weaknesses(packages: Sequence[dict[str, Any]]) -> list[str]:
    """A line for each weakness of pip-audit's packages."""
    return [
        f"{p['name']} {p['version']}: {v['id']}, mended in {', '.join(v['fix_versions']) or 'none'}"
        for p in packages
        for v in p.get("vulns", [])
    ]


def _run(module: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(  # noqa: S603 - a program of ours
        [sys.executable, "-m", module, *words], capture_output=True, text=True, check=False
    )


def _last(done: subprocess.CompletedProcess[str]) -> str:
    """The last line that a program has printed about an error."""
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    return lines[-1] if lines else f"exit status {done.returncode}"


def main() -> None:
    """Look for both, and print what there is."""
    lock, *folders = sys.argv[1:]
    lines = [*patterns(folders), *known(str(Path(lock)))]
    print("\n".join(lines), end="\n" if lines else "")
    sys.exit(bool(lines))


if __name__ == "__main__":
    main()
