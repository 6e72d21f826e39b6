"""A model whose parameters are stated, for `validate`, which otherwise takes fits and cards."""

from __future__ import annotations

from dataclasses import dataclass

from stribeck.identify.parameters import Parameters
from stribeck.space import Array


@dataclass(frozen=True)
class StatedModel:
    """Parameters with the loss that logs are held against, and their values.

    Args:
        parameters: All of a rig and a law.
        p: Their values, SI, (k,).
        delay: Of the motion after its command, s.
    """

    parameters: Parameters
    p: Array
    delay: float = 0.0

    def model(self) -> tuple[Parameters, Array]:
        """Parameters and their values."""
        return self.parameters, self.p
