"""What all tests share: which of them need recordings, that are not part of the repository."""

from pathlib import Path

import pytest

#: The recordings of real axes, one folder each.
RECORDINGS = Path(__file__).parents[2] / "shared" / "data"


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "recordings(*folders): needs these folders of recordings of real axes"
    )


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what needs recordings that are absent; skipped in one place, it is told in one line."""
    for mark in item.iter_markers("recordings"):
        if not all((RECORDINGS / folder).exists() for folder in mark.args or (".",)):
            pytest.skip(
                "the recordings of real axes (../shared/data) are not beside the repository"
            )
