"""Presenters: what shows a result, by name: its card, its page, its figures, its tables.

A result shows itself by methods (`fit.report`, `fit.plot`, `_repr_html_`), and what does the work
stands on a higher floor than the result. So a result asks here for it by name, and the package's
`__init__`, which stands above all floors, says where it is: no class imports from above.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_FINDERS: list[Callable[[str], Callable[..., Any]]] = []


def provide(find: Callable[[str], Callable[..., Any]]) -> None:
    """State what finds a presenter by its name."""
    _FINDERS[:] = [find]


def presenter(name: str) -> Callable[..., Any]:
    """The presenter of that name, imported when it is asked for."""
    (find,) = _FINDERS
    return find(name)
