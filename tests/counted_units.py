"""Co-simulation units whose C counts how often each of its lines is run."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

from fmu_unit import Unit, fmpy
from stribeck.export.fmu.build import fmu
from stribeck.export.model import Model

GCOV = shutil.which("gcov")


class Built:
    """Units compiled to count how often each line of their C is run."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._n = folder, 0

    def compiled(self, compiler: str, _: Path, sources: Mapping[str, bytes], target: str) -> bytes:
        """In place of `build._compiled`."""
        self._n += 1
        folder = self.folder
        folder.mkdir()
        for name, text in sources.items():
            (folder / name).write_bytes(text)
        subprocess.run(
            [compiler, "-std=c99", "-O0", "--coverage", "-fPIC", "-shared", "-fvisibility=hidden",
             "axis.c", "fmi2.c", "-lm", "-o", target],
            cwd=folder, check=True, capture_output=True,
        )  # fmt: skip
        return (folder / target).read_bytes()

    @property
    def folder(self) -> Path:
        """Where the last one was built."""
        return self._folder / str(self._n)

    def opened(self, model: Model) -> Unit:
        """A unit, loaded."""
        path = self._folder / f"{self._n + 1}.fmu"
        path.write_bytes(fmu(model))
        return Unit(fmpy.extract(str(path), str(path.with_suffix(".d"))),
                    fmpy.read_model_description(str(path)))  # fmt: skip

    def lines(self) -> tuple[set[str], set[str]]:
        """Lines of its motion that the last unit ran, now unloaded, and those that it did not.

        Each begins with its function, as a unit has its own.
        """
        data = next(self.folder.glob("*axis.gcda"))
        subprocess.run([str(GCOV), data.name], cwd=self.folder, check=True, capture_output=True)
        ran, idle, function = set[str](), set[str](), ""
        for line in (self.folder / "axis_motion.h.gcov").read_text("utf-8").splitlines():
            count, _, text = line.split(":", 2)
            if text.startswith("static "):
                function = text.partition("(")[0].rpartition(" ")[2]
            elif count.strip() != "-":
                (idle if "#" in count else ran).add(f"{function}: {text.strip()}")
        return ran, idle
