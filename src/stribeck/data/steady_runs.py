"""Constant-speed runs as a table has them: a row a run, its mean speed and its mean force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..space import Array

#: A table with more rows is a log whose times are missing: nobody runs an axis at so many speeds.
MOST = 300


@dataclass(frozen=True, eq=False)
class SteadyRuns:
    """What is known of the runs beside mean speed and mean force.

    Args:
        errors: Standard errors of the mean forces, N (N m), (N,); None where nothing is stated.
    """

    errors: Array | None = None

    def cut(self, rows: slice) -> SteadyRuns:
        """Those of a slice."""
        return SteadyRuns(None if self.errors is None else self.errors[rows])

    def weights(self, n: int) -> Array:
        """By what n rows are multiplied so that each counts as it is known, (n,); 1 on average."""
        if self.errors is None:
            return np.ones(n)
        weights = 1.0 / self.errors
        return np.asarray(weights / np.sqrt(np.mean(weights**2)))
