"""The gate of a log: whether its channels are what they seem.

`inspection` looks at a recording: its `mended` puts right what is certain (a wrap, single wild
samples, a position that breaks off), its `faults` say of the rest what, where and how much, a
`Fault` each (`fault`). Where a drive is flat at an extreme, `limits_below_noise` says.
"""

from .fault import Fault, Kind
from .inspection import faults, mended
from .plateaus import limits_below_noise

__all__ = ["Fault", "Kind", "faults", "limits_below_noise", "mended"]
