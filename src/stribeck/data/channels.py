"""The channels of a log: what a recording can have beside time."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

#: Channels beside time, with the SI unit of a linear and of a rotary axis.
CHANNELS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "position": ("m", "rad"),
        "command": ("m", "rad"),
        "velocity": ("m/s", "rad/s"),
        "acceleration": ("m/s**2", "rad/s**2"),
        "force": ("N", "N m"),
        "current": ("A", "A"),
        "voltage": ("V", "V"),
        "temperature": ("K", "K"),
        "pressure": ("Pa", "Pa"),
        "back_pressure": ("Pa", "Pa"),
    }
)
#: No quantity of an axis is larger in SI; the square of one that is could not be computed.
LARGEST = 1e30
