"""Errors whose message is for the user."""

from __future__ import annotations


class InputError(ValueError):
    """The input cannot be used: one line that says what, where, and what to do about it.

    The command line prints it on standard error and exits with status 2. What a hostile file
    puts into a name (line ends, control characters) becomes a space.
    """

    def __init__(self, message: str) -> None:
        line = "".join(c if c.isprintable() else " " for c in message)
        super().__init__(" ".join(line.split()))


class MissingLibrary(InputError):  # noqa: N818 - what is missing, not what is wrong
    """What would read a file is not installed: the file may be all right."""


class ChoiceError(InputError):
    """The channels of a log cannot be told from its heads: what they are has to be said."""
