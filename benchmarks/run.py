"""All measurements behind the claims of speed, in one run: `make bench`.

    python benchmarks/run.py [--quick] [--only NAME]... [--show NAME [TABLE]]

Writes benchmarks/results.json after every part, and from it benchmarks/README.md (a short pass
writes to benchmarks/quick/). A part that
was measured before stays until it is measured again; an interrupted run keeps what it has done.
`--show` measures nothing: it prints the tables of a part.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import re
import subprocess
import sys
import textwrap
import time
import traceback
from collections.abc import Iterable, Iterator
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
RESULTS, PAGE = FOLDER / "results.json", FOLDER / "README.md"
#: The parts in the order in which they run, and what each is about. Those that time something
#: come before those that count.
PARTS = {
    "kernel": "One simulated candidate",
    "startup": "From the command to the card",
    "overhead": "The optimizer's own cost",
    "scaling": "How cost grows",
    "identification": "Evaluations to identify the slide bed",
    "surfaces": "The paper's functions and their twins",
    "bbob_area": "BBOB",
    "axes": "Real axes, beside what others published",
    "other_tools": "Other tools on the same recordings",
    "presliding": "Loops below breakaway",
    "simulators": "Exported joints in MuJoCo",
    "exports": "Exported C and co-simulation units",
    "intervals": "Whether intervals hold the truth",
    "faults": "Axes that are not what their rig assumes",
    "selection": "Which law two real axes need",
}
LIBRARIES = (
    "stribeck", "numpy", "scipy", "numba", "cma", "pymoo", "niapy", "coco-experiment", "mujoco",
    "fmpy",
)  # fmt: skip


def main() -> None:
    """Measure the parts, and write the results after each."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--quick", action="store_true", help="a short pass, to see that all works")
    ask.add_argument("--only", action="append", choices=PARTS, metavar="NAME", help="this part")
    ask.add_argument("--show", nargs="+", metavar="NAME", help="print a part's tables, or one")
    ask.add_argument("--out", type=Path, default=FOLDER, help="the folder to write to")
    options = ask.parse_args()
    if options.show:
        name, *numbers = options.show
        if name not in PARTS or not all(n.isdecimal() for n in numbers):
            sys.exit(f"--show: a part ({', '.join(PARTS)}), and which of its tables: 1, 2, ...")
        print("\n".join(shown(name, [int(n) for n in numbers])))
        return
    if options.quick and options.out == FOLDER:  # a short pass does not replace what is published
        options.out = FOLDER / "quick"
    options.out.mkdir(parents=True, exist_ok=True)
    missing, failed = [], []
    for name in options.only or PARTS:
        if not (FOLDER / f"{name}.py").exists():
            missing.append(name)
            continue
        print(f"{name} ...", flush=True)
        start_time = time.perf_counter()
        try:
            results = import_module(name).measure(quick=options.quick)
        except Exception:  # noqa: BLE001 - one part that fails does not cost the others
            traceback.print_exc()
            failed.append(name)
            continue
        seconds = time.perf_counter() - start_time
        print(f"{name}: {seconds:.0f} s", flush=True)
        part = {"quick": options.quick, "seconds": seconds, "machine": machine(), "found": results}
        keep(options.out / RESULTS.name, name, part)
        renew_page(options.out)
    if missing:
        print(f"not there: {', '.join(missing)}")
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


# --- results.json ---------------------------------------------------------------------------------


def read(file: Path) -> dict[str, Any]:
    """The parts measured so far."""
    if not file.exists():
        return {}
    parts: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return parts


def keep(file: Path, name: str, part: dict[str, Any]) -> None:
    """Put a part into the file; an interruption leaves the old file or the new one."""
    parts = read(file) | {name: part}
    ordered = {n: parts[n] for n in PARTS if n in parts}
    _write(file, json.dumps(ordered, indent=1, default=_plain) + "\n")


def renew(name: str, results: Any, folder: Path = FOLDER) -> None:
    """Put results of a part of which some rows were measured here and now; renew the page.

    Machines of the other rows stay, as earlier ones.
    """
    file, here = folder / RESULTS.name, machine()
    part = read(file)[name]
    earlier = [m for m in (part["machine"], *part.get("earlier_machines", [])) if m != here]
    keep(file, name, part | {"machine": here, "earlier_machines": earlier, "found": results})
    renew_page(folder)


def renew_page(folder: Path = FOLDER) -> None:
    """Write the page of the results in a folder."""
    _write(folder / PAGE.name, page(read(folder / RESULTS.name)))


def _write(file: Path, text: str) -> None:
    draft = file.with_name(f".{file.name}.new")
    draft.write_text(text, encoding="utf-8")
    draft.replace(file)


def _plain(value: Any) -> Any:
    """A number or an array of numpy's as JSON has it."""
    return value.tolist()


# --- the machine ----------------------------------------------------------------------------------


def machine() -> dict[str, Any]:
    """The machine: processor, cores, memory, system and libraries."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
        "threads_allowed": os.environ.get("OMP_NUM_THREADS", "all"),
        "memory_GiB": _memory(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "gcc": _gcc(),
        "libraries": {name: v for name in LIBRARIES if (v := _version(name))},
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    text = info.read_text(encoding="utf-8") if info.exists() else ""
    model = re.search(r"model name\s*:\s*(.+)", text)
    family = re.search(r"cpu family\s*:\s*(\d+)", text)
    if not model:
        return platform.processor() or platform.machine()
    return model[1].strip() + (f" (family {family[1]})" if family else "")


def _memory() -> int | None:
    try:
        size = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None
    return math.ceil(size / 2**30)


def _gcc() -> str | None:
    try:
        completed = subprocess.run(["gcc", "--version"], check=True, capture_output=True, text=True)  # noqa: S607
    except (OSError, subprocess.CalledProcessError):
        return None
    return completed.stdout.partition("\n")[0]


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


# --- the page -------------------------------------------------------------------------------------


def page(parts: dict[str, Any]) -> str:
    """README.md: the machine, and the tables of every part."""
    return "\n".join(_page(parts)) + "\n"


def _page(parts: dict[str, Any]) -> Iterator[str]:
    yield "# Benchmarks\n"
    yield "All of this is measured by `make bench`, which writes this page and `results.json`;"
    yield "`make bench ARGS=--quick` is a short pass, `ARGS='--only NAME'` one part.\n"
    for described, names in _machines(parts):
        yield f"Measured on {described}: {', '.join(names)}.\n"
    for name, part in parts.items():
        yield f"## {PARTS[name]}\n"
        if part["quick"]:
            yield "*A short pass: fewer seeds, smaller budgets.*\n"
        yield f"`python benchmarks/run.py --only {name}`, {part['seconds'] / 60:.1f} minutes.\n"
        yield from (t.strip("\n") + "\n" for t in tables(name, part["found"]))
        if name == "scaling" and not part["quick"]:
            yield "![Seconds a call over samples, candidates and strokes](scaling.png)\n"


def tables(name: str, results: Any) -> list[str]:
    """The tables of a part; one that returns single lines has one table."""
    texts: list[str] = import_module(name).tables(results)
    return texts if any("\n" in text for text in texts) else ["\n".join(texts)]


def _machines(parts: dict[str, Any]) -> list[tuple[str, list[str]]]:
    """Each machine in words, and the parts of which rows were measured on it."""
    by: dict[str, list[str]] = {}
    for name, part in parts.items():
        for host in (part["machine"], *part.get("earlier_machines", [])):
            by.setdefault(described(host), []).append(name)
    return list(by.items())


def described(host: dict[str, Any]) -> str:
    """A machine in words."""
    libraries = ", ".join(f"{name} {v}" for name, v in host["libraries"].items())
    threads = "" if host["threads_allowed"] == "all" else f", {host['threads_allowed']} thread(s)"
    memory = f", {host['memory_GiB']} GiB" if host["memory_GiB"] else ""
    gcc = f", {host['gcc']}" if host["gcc"] else ""
    return (
        f"{host['processor']}, {host['cores']} cores{threads}{memory}, {host['system']}; "
        f"Python {host['python']}, {libraries}{gcc}"
    )


def shown(name: str, numbers: list[int]) -> Iterator[str]:
    """The tables of a part as plain text, all or those with the numbers."""
    parts = read(RESULTS)
    if name not in parts:
        sys.exit(f"{name} has not been measured: python benchmarks/run.py --only {name}")
    for k, text in enumerate(tables(name, parts[name]["found"]), 1):
        if not numbers or k in numbers:
            yield plain(text)


def plain(markdown: str) -> str:
    """Markdown with its tables as aligned columns."""
    lines: list[str] = []
    rows: list[list[str]] = []
    for line in [*markdown.split("\n"), ""]:
        if line.startswith("|"):
            rows.append([_bare(cell) for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]])
            continue
        if rows:
            lines += _aligned(rows)
            rows = []
        lines += textwrap.wrap(_bare(line), 100) or [""]
    return "\n".join(lines).strip("\n") + "\n"


def _aligned(rows: list[list[str]]) -> Iterable[str]:
    head, marks, *body = rows
    widths = [max(map(len, column)) for column in zip(head, *body, strict=True)]
    to_right = [mark.endswith(":") and not mark.startswith(":") for mark in marks]
    for k, row in enumerate([head, *body]):
        cells = zip(row, widths, to_right, strict=True)
        yield "  ".join(c.rjust(w) if r else c.ljust(w) for c, w, r in cells).rstrip()
        if k == 0:
            yield "  ".join("-" * w for w in widths)


def _bare(text: str) -> str:
    """Text without the marks of Markdown."""
    text = text.strip().removeprefix("**").removesuffix("**")
    return re.sub(r"\\([\\`*_|<>\[\]])", r"\1", text)


if __name__ == "__main__":
    main()
