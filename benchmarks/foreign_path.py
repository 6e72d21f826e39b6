"""Puts the tests' folder on the path, where the foreign simulators are."""

from __future__ import annotations

import sys
from pathlib import Path

TESTS = str(Path(__file__).parents[1] / "tests")
if TESTS not in sys.path:
    sys.path.append(TESTS)
