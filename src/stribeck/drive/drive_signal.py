"""What a drive records of its force: a unit, what 100 % of it is, and which size of a current."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from ..errors import InputError
from ..units import unit

#: Which size of an alternating current an ampere is; empty where it is a direct current, or the
#: size is the same all along the chain.
Amplitude = Literal["", "rms", "peak"]

_TORQUE, _FORCE, _CURRENT = (unit(u).dimension for u in ("N m", "N", "A"))
_SHARES = {"%": "%", "‰": "‰", "percent": "%", "per mille": "‰", "permille": "‰", "1/1000": "‰"}
_KINDS = ("rated", "standstill", "peak")
_QUANTITIES = {"torque": "N m", "force": "N", "current": "A"}
#: What 100 % may be: the name of the number of a chain that says how much that is, with its unit.
BASES = {f"{k}_{q}": written for k in _KINDS for q, written in _QUANTITIES.items()}
_BASE = re.compile(
    r"(?:of\s+)?(?:the\s+)?(?:configured\s+)?(?:channel\s+)?(\w+)[\s_]+(torque|force|current)"
)
_AMPLITUDE = re.compile(r"(?<=A)[\s_]*(rms|eff|peak|pk)\b")
_SIZES: dict[str, Amplitude] = {"rms": "rms", "eff": "rms", "peak": "peak", "pk": "peak"}


@dataclass(frozen=True)
class DriveSignal:
    """What a drive records of its force.

    Args:
        unit: As a log has it: %, ‰, A, mA, V, counts, N m, N.
        base: Of a share, the name of what 100 % is, of `BASES`; else empty.
        amplitude: Of a current.
    """

    unit: str
    base: str = ""
    amplitude: Amplitude = ""

    @property
    def text(self) -> str:
        """As a person writes it: `% of rated torque`, `A rms`, `counts`."""
        if self.base:
            return f"{self.unit} of {self.base.replace('_', ' ')}"
        return f"{self.unit} {self.amplitude}".strip()

    @property
    def dimension(self) -> str:
        """The SI dimension of what is recorded."""
        return unit(self.unit).dimension

    def takes(self, written: str) -> bool:
        """Whether a column in such a unit may hold the signal: every share fits every other."""
        bare, amplitude = sized(written)
        try:
            alike = unit(bare).dimension == self.dimension
        except InputError:
            return False
        return alike and amplitude in ("", self.amplitude)


def sized(written: str) -> tuple[str, Amplitude]:
    """A unit without the size of its current, and that size: `Nm/A rms` is Nm/A, and rms."""
    match = _AMPLITUDE.search(written)
    if match is None:
        return written, ""
    return (written[: match.start()] + written[match.end() :]).strip(), _SIZES[match[1]]


def drive_signal(text: str, place: str) -> DriveSignal:
    """A signal as people write it: `% of rated torque`, `‰ of rated current`, `A rms`, `counts`.

    Raises:
        InputError: it is none of these, or a share of nobody knows what.
    """
    head, _, rest = text.strip().partition(" of ")
    share = _SHARES.get(head.strip())
    if share:
        return DriveSignal(share, _base(rest, text, place))
    bare, amplitude = sized(text.strip())
    try:
        dimension = unit(bare).dimension
    except InputError as error:
        raise InputError(f"{place}: {error}") from error
    if dimension not in (_TORQUE, _FORCE, _CURRENT, unit("V").dimension, unit("count").dimension):
        raise InputError(
            f'{place}: {text!r} is no signal of a drive: write "% of rated torque", "A rms", '
            '"A peak", "A", "counts", "V" or "N m"'
        )
    return DriveSignal(bare, "", amplitude)


def _base(rest: str, text: str, place: str) -> str:
    match = _BASE.fullmatch(rest.strip())
    name = f"{match[1]}_{match[2]}".replace("maximum_", "peak_") if match else ""
    if name not in BASES:
        raise InputError(
            f"{place}: {text!r} does not say what 100 % is: write "
            + ", ".join(f'"% of {base.replace("_", " ")}"' for base in BASES)
        )
    return name
