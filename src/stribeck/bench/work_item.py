"""What an engine runs: a text that decides everything, and what its answer means."""

from __future__ import annotations

from typing import Protocol, TypeVar

Outcome_co = TypeVar("Outcome_co", covariant=True)


class WorkItem(Protocol[Outcome_co]):
    """Work whose outcome is a pure function of its text: a run of a search, an axis of a fleet.

    The text is an object of JSON on one line. Its entry `runner` names the module whose function
    `record_text` turns the text into that of a record; without one it is `stribeck.bench.run`.
    """

    @property
    def key(self) -> str:
        """Its identity: a digest of its text."""

    @property
    def text(self) -> str:
        """All that its outcome depends on."""

    @property
    def labels(self) -> tuple[str | int, ...]:
        """What a store's table of jobs says of it."""

    def done(self, line: str) -> Outcome_co:
        """The record whose text a worker has answered.

        Raises:
            ValueError: it is not the record of this work.
        """

    def failed(self, message: str) -> Outcome_co:
        """What stands for its record where there is none, for a reason."""
