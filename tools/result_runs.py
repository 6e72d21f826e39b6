"""The runs whose results `compare_results.py` compares.

Every command that a page of the README or the docs shows, the demo, and a fixed list that enters
each kind of rig, search method, estimate and export once. All go through the command line, so that
the same list runs on any checkout. Left out are the programs that only draw (law_figures.py,
physics_figures.py): drawings are not results.
"""

from __future__ import annotations

import re
import zlib
from dataclasses import dataclass
from pathlib import Path

from docs import BLOCK

#: Folder that commands write to, as those of the pages do.
DEMO = "demo/"
#: CPU seconds of the pages' blocks that take more than `BLOCK_COST`, by how their commands begin.
BLOCK_COST = 2
BLOCK_COSTS = {
    "python tools/rig_study.py": 11,
    "stribeck compensate": 40,
    "stribeck identify ../shared/data/openarm": 70,
    "stribeck identify": 5,
}


@dataclass(frozen=True)
class Run:
    """A command in a shell, from the root of a checkout.

    Attributes:
        name: What the comparison calls it.
        command: The line; it leaves its files below `demo/`.
        cost: About how many CPU seconds it takes, for the order of magnitude.
    makes: Files or folders that other runs read.
    """

    name: str
    command: str
    cost: int = 2
    makes: tuple[str, ...] = ()

    @property
    def folder(self) -> str:
        """A file name that is the run's own."""
        words = re.sub(r"[^A-Za-z0-9]+", "-", self.name).strip("-")[:60]
        return f"{words}-{zlib.crc32(self.command.encode()):08x}"

    @property
    def outputs(self) -> tuple[str, ...]:
        """Files that it writes: `makes`, and the values of `--out`."""
        return (*self.makes, *re.findall(rf"--out ({DEMO}\S+)", self.command))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Files that it reads and other runs write."""
        words = re.findall(rf"(?<!\S){DEMO}[^\s)]+", self.command)
        return tuple(w for w in words if not any(_inside(w, output) for output in self.outputs))


def _inside(path: str, folder: str) -> bool:
    return path == folder or path.startswith(f"{folder}/")


def makers(run: Run, runs: list[Run]) -> list[Run]:
    """The runs that write what `run` reads; the first of those that write the same.

    Raises:
        LookupError: No run writes it.
    """
    chosen = []
    for path in run.inputs:
        maker = next((r for r in runs if any(_inside(path, output) for output in r.outputs)), None)
        if maker is None:
            raise LookupError(f"{run.name}: no run makes {path}")
        if maker not in chosen:
            chosen.append(maker)
    return chosen


def all_runs(checkout: Path) -> list[Run]:
    """The fixed list and the blocks of a checkout's pages; what takes longest comes last."""
    runs = {run.command: run for run in FIXED}
    for page in [checkout / "README.md", *sorted((checkout / "docs").rglob("*.md"))]:
        for match in BLOCK.finditer(page.read_text(encoding="utf-8")):
            command = match["command"]
            cost = next((c for k, c in BLOCK_COSTS.items() if command.startswith(k)), BLOCK_COST)
            name = f"{page.relative_to(checkout)}: {command}"
            runs.setdefault(command, Run(name, command, cost))
    return [*runs.values(), *CAMPAIGNS]


# --- the fixed list -------------------------------------------------------------------------------

_DATA = "../shared/data"
_TWIN = "demo/twin.csv --rig slide-bed --train 325:127 --holdout 352:325 --holdout 127:68"
_SHORT = "demo/twin.csv --rig slide-bed --train 325:127 --repeats 1 --budget 600 --json"
_CARD = "demo/left/card.json"
_SERVO = f"{_DATA}/bam_xl330/logs"
_SERVO_LOGS = f"{_SERVO}/*.json"
#: A richer law on nine of the sixteen logs, or it takes minutes.
_SERVO_NINE = f"{_SERVO}/*h29m*.json {_SERVO}/*h28m5*.json"
_SERVO_FIT = "--rig servo-pendulum --loss absolute --seed 5 --repeats 1"
_O_RING = " ".join(f"{_DATA}/pneumatic/O-ring257_{bar}bar.csv" for bar in (1, 3, 5, 7))
_LOOP = f"{_DATA}/direct_drive/sig0_j1_6_exp2.csv --rig benchmarks/direct_drive.toml"
_PENDULUM = (
    "printf '[columns]\\ntime = \"time [s]\"\\nposition = \"position [rad]\"\\n"
    "velocity = \"velocity [rad/s]\"\\nforce = \"torque [Nm]\"\\n' > columns.toml; "
)  # fmt: skip
_PENDULUM_LOG = f"{_DATA}/dfki_pendulum/sysid_measured.csv"

_DEMO = [
    Run("demo", "python tools/demo.py", 30,
        ("demo/twin.csv", "demo/twin.truth.json", "demo/left", "demo/right", "demo/c")),
]  # fmt: skip

_AXES = [
    Run("emps: select", f"stribeck select {_DATA}/emps/DATA_EMPS.mat --rig emps", 30),
    Run("xl330: m1",
        f"stribeck identify {_SERVO_LOGS} --law coulomb-viscous {_SERVO_FIT} --budget 700 --json",
        40),
    Run("xl330: m3",
        f"stribeck identify {_SERVO_LOGS} --law bam-m3 {_SERVO_FIT} --budget 500 --out demo/m3",
        60),
    Run("xl330: m4",
        f"stribeck identify {_SERVO_NINE} --law bam-m4 {_SERVO_FIT} --budget 400 --json", 50),
    Run("direct drive: loop", f"stribeck identify {_LOOP} --train 2s:11s --set J=2.519"
        " --out demo/loop", 20),
    Run("direct drive: loop, lugre", f"stribeck identify {_LOOP} --train 2s:11s --set J=2.519"
        " --law lugre --repeats 1 --budget 500 --json", 5),
    Run("direct drive: ramp", f"stribeck check {_DATA}/direct_drive/est_j1_05.csv"),
    Run("cylinder: O-ring", f"stribeck identify {_O_RING} --rig cylinder --set bore=25.7"
        " --set F_V=0 --out demo/o-ring", 7),
    Run("pendulum: identify", f"{_PENDULUM} stribeck identify {_PENDULUM_LOG}"
        " --rig forced-pendulum --set g_cos=0 --columns columns.toml --out demo/pendulum", 6),
    Run("pendulum: validate", f"{_PENDULUM} stribeck validate demo/pendulum/card.json"
        f" {_PENDULUM_LOG} --columns columns.toml --max-error 30"),
    Run("pendulum: check", f"{_PENDULUM} stribeck check {_PENDULUM_LOG} --columns columns.toml"),
]  # fmt: skip

_ESTIMATES = [
    *(Run(f"method: {m}", f"stribeck identify {_SHORT} --method {m}", 5)
      for m in ("random", "ts", "ats", "bfo", "abfo", "ga", "bts", "mbts")),
    Run("identify: --paper", f"stribeck identify {_TWIN} --paper --json", 10),
    Run("identify: --bootstrap", f"stribeck identify {_SHORT} --bootstrap 20", 8),
    Run("identify: --restart", f"stribeck identify {_SHORT} --restart", 5),
    Run("identify: absolute", f"stribeck identify {_SHORT} --loss absolute", 5),
    Run("identify: directional, tied",
        "stribeck identify demo/twin.csv --rig slide-bed --directional --tie k_spring+=k_spring-"
        " --bounds F_S+=100:200 --seed 2 --repeats 1 --budget 600 --json", 8),
    Run("select", f"stribeck select {_TWIN} --out demo/select", 8),
    Run("plan", f"stribeck plan {_CARD}"),
    Run("plan: --json", f"stribeck plan {_CARD} --json"),
    Run("compensate: feedback", f"stribeck compensate {_CARD} --mode feedback --scale 0.9"
        " --noise 0.01 --resolution 0.01 --json", 10),
    Run("compensate: joint", "stribeck compensate demo/joint/card.json --mode reference"
        " --scale 0.8 --speed 50 --json", 6),
    Run("compensate: emps", "stribeck compensate demo/emps/card.json --mode reference"
        " --scale 0.8 --speed 50 --json", 4),
    Run("compensate: refused", "stribeck compensate demo/emps/card.json --scale 0.8 --json"),
]  # fmt: skip

_EXPORTS = [
    Run("export: c", f"stribeck export {_CARD} --to c --out demo/code"),
    Run("export: c, compensation", f"stribeck export {_CARD} --to c --out demo/tuned"
        " --compensation demo/compensation/compensation.json"),
    Run("export: st", f"stribeck export {_CARD} --to st --set scale=0.8 --set feedback=1"),
    Run("export: plcopen", f"stribeck export {_CARD} --to plcopen --out demo/friction.plcopen.xml"),
    Run("export: table", f"stribeck export {_CARD} --to table --out demo/table.csv"),
    Run("export: mjcf", f"stribeck export {_CARD} --to mjcf --into docs/exports/bed.xml"
        " --joint bed --out demo/bed.xml"),
    Run("export: mjcf, lugre", f"stribeck export {_CARD} --to mjcf --into docs/exports/bed.xml"
        " --joint bed --set lugre=1 --out demo/sticky.xml"),
    Run("export: urdf", f"stribeck export {_CARD} --to urdf --into docs/exports/bed.urdf"
        " --joint bed --out demo/bed.urdf"),
    Run("export: usd", f"stribeck export {_CARD} --to usd --joint /slide_bed/bed"
        " --out demo/bed.usda"),
    Run("export: fmu", f"stribeck export {_CARD} --to fmu --out demo/unit.fmu"),
    Run("export: modelica", f"stribeck export {_CARD} --to modelica --out demo/Friction.mo"),
    Run("export: matlab", f"stribeck export {_CARD} --to matlab --out demo/functions"),
    Run("export: json", f"stribeck export {_CARD} --to json --out demo/copy.json"),
    *(Run(f"export: {kind}, {to}", f"stribeck export {card}/card.json --to {to} --out {out}")
      for kind, card in (("joint", "demo/joint"), ("emps", "demo/emps"), ("xl330", "demo/m3"),
                         ("loop", "demo/loop"), ("cylinder", "demo/o-ring"),
                         ("pendulum", "demo/pendulum"))
      for to, out in (("fmu", "demo/unit.fmu"), ("c", "demo/code"), ("st", "demo/friction.st"),
                      ("matlab", "demo/functions"), ("modelica", "demo/Friction.mo"))),
]  # fmt: skip

CAMPAIGNS = [
    Run("bench paper", "stribeck bench paper --trials 2 --out demo/paper", 140),
]

FIXED = [*_DEMO, *_AXES, *_ESTIMATES, *_EXPORTS]
