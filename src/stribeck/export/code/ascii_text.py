"""Text for tools that know no more than ASCII: controllers, drives, old compilers."""

from __future__ import annotations

import re
import unicodedata

_GREEK = {
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "ε": "epsilon", "ζ": "zeta",
    "η": "eta", "θ": "theta", "κ": "kappa", "λ": "lambda", "μ": "mu", "µ": "mu", "ν": "nu",
    "ξ": "xi", "π": "pi", "ρ": "rho", "σ": "sigma", "τ": "tau", "φ": "phi", "χ": "chi",
    "ψ": "psi", "ω": "omega", "Γ": "Gamma", "Δ": "Delta", "Θ": "Theta", "Λ": "Lambda",
    "Π": "Pi", "Σ": "sum", "Φ": "Phi", "Ψ": "Psi", "Ω": "Omega",
}  # fmt: skip
_SIGNS = {
    "−": "-", "–": "-", "—": "-", "·": "*", "×": "x", "÷": "/", "…": "...", "≤": "<=",
    "≥": ">=", "≠": "!=", "≈": "~", "±": "+/-", "∞": "inf", "√": "sqrt", "°": " deg", "→": "->",
    "²": "^2", "³": "^3", "⁻": "^-", "¹": "^1", "‘": "'", "’": "'", "“": '"', "”": '"',
    "∑": "sum", "ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "Ae", "ł": "l", "Ł": "L",
}  # fmt: skip
_LETTERS = "".join(_GREEK)
_TABLE = str.maketrans(_GREEK | _SIGNS)


def ascii_text(text: str) -> str:
    """A text in ASCII: Greek letters by their names, accents dropped, what is left as `?`."""
    # A letter's name stands apart from what is written beside the letter: 2πx is 2 pi x.
    apart = re.sub(f"(?<=[A-Za-z0-9{_LETTERS}])(?=[{_LETTERS}])", " ", text)
    apart = re.sub(f"(?<=[{_LETTERS}])(?=[A-Za-z0-9])", " ", apart)
    plain = unicodedata.normalize("NFKD", apart.translate(_TABLE))
    letters = "".join(c for c in plain if not unicodedata.combining(c))
    printed = (c if c.isprintable() or c in "\n\t" else " " for c in letters)
    return "".join(printed).encode("ascii", "replace").decode()
