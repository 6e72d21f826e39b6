"""What parameters and patterns leave of a residual."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...data.zero_phase import BLOCK
from ...space import Array
from .residual_rows import ResidualRows


class Remainder:
    """What parameters and patterns leave of a residual, and what they come to.

    Args:
        rows: The rows.
        columns: Of the patterns, (rows, k).

    Attributes:
        source: The rows as they were given.
        columns: See there.
        rows: The rows with the residual that is left.
        x: What parameters and patterns come to.
    """

    def __init__(self, rows: ResidualRows, columns: Array) -> None:
        self.source, self.columns = rows, columns
        A = np.column_stack([rows.jacobian, columns])
        lengths = np.sqrt(np.einsum("ij,ij->j", A, A))
        lengths[lengths == 0] = 1.0
        A /= lengths
        values, vectors = np.linalg.eigh(np.einsum("ij,ik->jk", A, A))
        seen = values > 1e-9 * values[-1]
        root = vectors[:, seen] / np.sqrt(values[seen])
        for k in range(0, len(A), BLOCK):  # in place: of a long log a copy is as large as it
            A[k : k + BLOCK, : root.shape[1]] = np.einsum("ij,jk->ik", A[k : k + BLOCK], root)
        self._basis = A[:, : root.shape[1]]
        inner = np.einsum("ij,i->j", self._basis, rows.residual)
        self.x: Array = root @ inner / lengths
        self.rows = replace(rows, residual=self.without(rows.residual))

    def without(self, columns: Array) -> Array:
        """Columns (rows, ...) less what parameters and patterns make of them."""
        inner = np.einsum("ij,i...->j...", self._basis, columns)
        left: Array = columns - np.einsum("ij,j...->i...", self._basis, inner)
        return left
