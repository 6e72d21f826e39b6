"""What is said to a user whose request cannot be met."""

from __future__ import annotations


class InputError(ValueError):
    """The input cannot be used: one line that says what, where, and what to do about it.

    The command line prints it on standard error and exits with status 2.
    """
