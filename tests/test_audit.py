"""`make audit`: what its two programs say is counted, and a database out of reach is told."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import pytest

import audit

BANDIT = {"errors": [], "metrics": {"_totals": {"loc": 1234}}}
FINDING = {
    "filename": "src/a.py", "line_number": 3, "test_id": "B301", "issue_text": "pickle is unsafe.",
}  # fmt: skip
CLEAN = {"name": "numpy", "version": "2.4.0", "vulns": []}
WEAK = {
    "name": "old", "version": "1.0", "vulns": [{"id": "PYSEC-1", "fix_versions": ["1.1", "2.0"]}],
}  # fmt: skip
SKIPPED = {"name": "other", "skip_reason": "Dependency not found on PyPI"}


@pytest.mark.parametrize(
    ("results", "packages", "error", "lines", "status"),
    [
        ([], [CLEAN], "", ["0 findings", "0 known weaknesses in 1 packages"], 0),
        ([], [CLEAN, SKIPPED], "", ["0 findings", "1 packages; its database could not"], 0),
        ([], None, "ERROR: no route to host", ["0 findings", "ERROR: no route to host"], 0),
        (
            [FINDING], [WEAK], "",
            ["1 findings", "1 known weaknesses", "src/a.py:3: B301", "PYSEC-1, mended in 1.1, 2.0"],
            1,
        ),
    ],
)  # fmt: skip
def test_findings_end_with_status_1_and_no_database_is_a_line(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    results: list[Any],
    packages: list[Any] | None,
    error: str,
    lines: list[str],
    status: int,
) -> None:
    answers = {
        "bandit": json.dumps(BANDIT | {"results": results}),
        "pip_audit": "" if packages is None else json.dumps({"dependencies": packages}),
    }

    def run(module: str, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(words, 1, answers[module], f"first\n{error}\n")

    monkeypatch.setattr(audit, "_run", run)
    monkeypatch.setattr("sys.argv", ["audit.py", "requirements.lock", "src"])
    with pytest.raises(SystemExit) as end:
        audit.main()
    assert int(end.value.code or 0) == status
    shown = capsys.readouterr().out.splitlines()
    assert len(shown) == len(lines)
    assert all(part in line for part, line in zip(lines, shown, strict=True))
