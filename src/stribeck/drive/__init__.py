"""The drive: from what it records to the force of its axis, with what is known of each number."""

from .chain import DriveChain
from .conventions import CONVENTIONS, Convention, convention_named
from .refusals import chain_needed, missing_chain, refuse_without_drive

__all__ = [
    "CONVENTIONS",
    "Convention",
    "DriveChain",
    "chain_needed",
    "convention_named",
    "missing_chain",
    "refuse_without_drive",
]
