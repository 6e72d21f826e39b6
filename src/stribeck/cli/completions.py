"""What a shell completes: names of rigs, laws, methods and targets; it completes files itself."""

from __future__ import annotations

from collections.abc import Iterable


def rig_names(incomplete: str) -> list[str]:
    """Rigs; of a TOML file the shell knows the names."""
    from ..rig import RIGS

    return _beginning(incomplete, RIGS)


def law_names(incomplete: str) -> list[str]:
    """Laws."""
    from ..friction import LAWS

    return _beginning(incomplete, LAWS)


def laws_named(incomplete: str) -> list[str]:
    """Laws with commas between them."""
    *before, last = incomplete.split(",")
    head = "".join(f"{law}," for law in before)
    return [head + name for name in law_names(last)]


def method_names(incomplete: str) -> list[str]:
    """Search methods."""
    from ..optimize import METHODS

    return _beginning(incomplete, METHODS)


#: The names of `export.TARGETS`, which take a second to import.
TARGETS = (
    "c", "st", "plcopen", "table", "mjcf", "urdf", "usd", "fmu", "modelica", "matlab", "json",
)  # fmt: skip


def target_names(incomplete: str) -> list[str]:
    """Export targets."""
    return _beginning(incomplete, TARGETS)


def drive_names(incomplete: str) -> list[str]:
    """Conventions of drives."""
    from ..drive import CONVENTIONS

    return _beginning(incomplete, CONVENTIONS)


def reader_names(incomplete: str) -> list[str]:
    """Formats of logs."""
    from ..data.readers.registry import readers

    return _beginning(incomplete, readers())


def recording_names(incomplete: str) -> list[str]:
    """Recordings to try."""
    from ..data.published import SAMPLE, published

    return _beginning(incomplete, [SAMPLE, *published()])


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
