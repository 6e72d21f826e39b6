"""The gate of a log: whether its channels are what they seem.

`inspection` looks at a recording: its `mended` puts right what is certain (a wrap, single wild
samples, a position that breaks off), its `faults` say of the rest what, where and how much, a
`Fault` each (`fault`).
"""

from .fault import Fault, Kind
from .inspection import faults, mended

__all__ = ["Fault", "Kind", "faults", "mended"]
