"""Set-up of all tests: compiled code, and recordings that are not part of the repository."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import settings

# Workers share the cores already: threads of BLAS beside them wait, each busily, for one another,
# which takes most of the time of small matrices. BLAS reads this when numpy is imported, here and
# in what tests start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# An example has no deadline: its time depends on the load of the machine.
settings.register_profile("tests", deadline=None)
settings.load_profile("tests")

#: The recordings of real axes, one folder each.
RECORDINGS = Path(__file__).parents[2] / "shared" / "data"


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "recordings(*folders): needs these folders of recordings of real axes"
    )


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile everything once, before workers start that would each do it, and print that."""
    if not hasattr(session.config, "workerinput"):
        command = [sys.executable, "-m", "stribeck", "warm"]
        subprocess.run(command, stdout=subprocess.DEVNULL, check=False)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip tests of absent recordings, in one place, so that pytest reports them in one line."""
    for mark in item.iter_markers("recordings"):
        if not all((RECORDINGS / folder).exists() for folder in mark.args or (".",)):
            pytest.skip(
                "the recordings of real axes (../shared/data) are not beside the repository"
            )
