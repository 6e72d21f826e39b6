"""Columns of a log before and after its filter, of which only what changes is filtered."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...space import Array
from .rows import Log


class FilteredColumns(NamedTuple):
    """Columns of a log at its samples and at its rows.

    Args:
        raw: At the samples, (samples, k).
        thin: Filtered, at the rows that count, (rows, k).
    """

    raw: Array = np.empty((0, 0))
    thin: Array = np.empty((0, 0))

    def renewed(self, log: Log, raw: Array) -> FilteredColumns:
        """Other columns of the same log, (samples, k): those that are equal are not filtered again.

        Each column goes through the filter by itself, so that both ways give the same bits.
        """
        if raw.shape != self.raw.shape:
            return FilteredColumns(raw, log.thin(lambda at: raw[at]))
        pairs = zip(raw.T, self.raw.T, strict=True)
        changed = [j for j, (x, before) in enumerate(pairs) if not np.array_equal(x, before)]
        thin = self.thin
        if changed:
            some = raw[:, changed]
            thin = thin.copy()
            thin[:, changed] = log.thin(lambda at: some[at])
        return FilteredColumns(raw, thin)
