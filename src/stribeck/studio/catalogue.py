"""What there is to choose from: rigs with their constants, laws, methods and drives."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from ..drive import CONVENTIONS
from ..report.registry_documents import laws_text, methods_text, rigs_text


@cache
def catalogue() -> dict[str, Any]:
    """All of it as one document."""
    return {
        "rigs": json.loads(rigs_text(None)),
        "laws": json.loads(laws_text(None)),
        "methods": json.loads(methods_text(None)),
        "drives": [
            {"name": c.name, "drives": c.drives, "needs": list(c.needs), "meaning": c.meaning}
            for c in CONVENTIONS.values()
        ],
    }
