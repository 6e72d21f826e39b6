"""Output for people: tables, figures, pages, and the files they are written to.

`contents` has a fit as data, `figures` describes and draws its figures, `page` shows it in a
browser. What needs matplotlib, jinja2 or rich is imported from its own module, when it is needed.
"""

from .format import DASH, as_entered, duration, grouped, number
from .table import FORMS, Cell, Table

__all__ = ["DASH", "FORMS", "Cell", "Table", "as_entered", "duration", "grouped", "number"]
