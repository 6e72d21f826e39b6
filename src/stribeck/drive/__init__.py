"""The drive: from what it records to the force of its axis, with what is known of each number."""

from .chain import DriveChain
from .conventions import CONVENTIONS, Convention, convention_named
from .drive_file import drive_from
from .refusals import chain_needed, missing_chain

__all__ = [
    "CONVENTIONS",
    "Convention",
    "DriveChain",
    "chain_needed",
    "convention_named",
    "drive_from",
    "missing_chain",
]
