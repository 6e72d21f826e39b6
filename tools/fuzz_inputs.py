"""What `tools/fuzz.py` tries: for each reader a corpus made by code, and how an input is read."""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import polars as pl
import scipy.io

from stribeck import cli
from stribeck.bench.campaign import campaign, shipped
from stribeck.compensate.compensator import SETTINGS
from stribeck.compensate.settings import SCHEMA, read_settings
from stribeck.data import read
from stribeck.errors import InputError
from stribeck.export.model import read_model
from stribeck.export.robot.mjcf import mjcf
from stribeck.export.robot.urdf import urdf
from stribeck.report.contents.schema import read_report
from stribeck.rig import RIGS
from stribeck.rig.lookup import rig_named
from stribeck.rig.loop_file import loop_file

_ROWS = 40
_T = np.arange(_ROWS) * 0.01
_LOG = {"t_s": _T, "x_mm": np.round(100 * _T**2, 3), "F_N": np.round(np.sin(9 * _T), 4)}
_MAPS = (
    'position = "x_mm"\nforce = { column = "F_N", unit = "kN", factor = 2.5 }\n',
    '[columns]\ntime = "t_s"\nposition = "x_mm [mm]"\nforce = { column = "F_N", factor = "F_N" }\n',
    (
        '[columns]\nforce = "F_N [%]"\n[drive]\nsignal = "% of rated current"\n'
        'rated_current = "2.5 A rms ± 5 % (data sheet)"\nkt = "0.52 N m/A rms nameplate"\n'
        'gear = 3\nlead = "10 mm"\nefficiency = 0.9\n'
    ),
)
_RIGS = (
    (
        'kind = "slide-bed"\nlaw = "stribeck"\nname = "axis"\ndoc = "my axis"\n'
        'constants = { m = 24.0, F_fm = "12±4", J_m = "4e-6 nameplate" }\n'
        'ranges = { F_S = [20, 90], F_C = [5, 60] }\ncolumns = { position = "actual [mm]" }\n'
    ),
    'kind = "forced"\nlaw = "coulomb-viscous"\n[ranges]\nF_C = [1, 9]\n',
    (
        'kind = "forced"\n[drive]\nconvention = "dynamixel-xm430"\nkt = "1.8 N m/A ± 0.1"\n'
        'lead = "5 mm"\ncounts_per_turn = 4096\nmass = "9 kg"\nside = "axis"\nreversed = true\n'
    ),
)
_AXES = (
    (
        'law = "coulomb-viscous"\nranges = { F_C = [0, 100], F_V_motor = [0, 200] }\n'
        "[controller.damped]\nkp = 20000.0\nkd = 300.0\n[motor.force]\narmature = 2.0\n"
        "[transmission.compliant]\nstiffness = { free = [1e5, 1e7] }\ndamping = 9.0\n"
        "play = { free = [0, 1e-3] }\n[load.mass]\nM = 5.0\n[sensor.motor]\n[sensor.load]\n"
        '[friction]\nside = "both"\n[columns]\nposition = "q [m]"\ncommand = "goal [m]"\n'
    ),
    (
        'law = "bam-m1"\nrotary = true\n[motor.voltage]\nk_t = { free = [0.1, 2] }\nR = 2.0\n'
        "[load.pendulum]\nm = 0.5\n"
    ),
)
_SAVED_MAPS = (
    'heads = ["t_s", "x_mm", "F_N"]\n[columns]\nposition = "x_mm"\nforce = "F_N"\n',
    (
        'heads = ["t_s", "x_mm", "F_N"]\nrate = 100.0\nsubtract = "F_N"\n'
        '[columns]\ntime = "t_s"\nposition = { column = "x_mm", unit = "mm" }\n'
    ),
)
_LOOPS = (
    (
        'kp = "100 N/mm"\nkd = "5 N s/m"\nderivative = "error"\nperiod = "1 ms"\ndelay = 0\n'
        'limit = "40 N"\n[sensor]\nresolution = "0.01 mm"\nnoise = 0\n'
    ),
    "kp = 1000.0\nperiod = 2\ndelay = 2\n",
)
_MJCF = (
    '<mujoco model="a"><default><joint damping="0.1"/></default><worldbody><body name="b">'
    '<inertial pos="0 0 0" mass="24" diaginertia="1 1 1"/>'
    '<joint name="axis" type="slide" axis="1 0 0" frictionloss="1"/></body></worldbody></mujoco>'
)
_URDF = (
    '<?xml version="1.0"?><robot name="r"><link name="a"/><link name="b"/><joint name="axis" '
    'type="prismatic"><parent link="a"/><child link="b"/><limit effort="9" velocity="1"/>'
    '<dynamics damping="0.1" friction="2"/></joint></robot>'
)
_COMMANDS = (
    "check log.csv", "check log.csv --json", "check log.csv --columns map.toml", "laws",
    "laws stribeck", "rigs", "rigs slide-bed", "rigs rig.toml", "methods", "version", "report fit",
    "export card.json --to c", "export card.json --to st --out code",
    "export card.json --to urdf --robot robot.urdf --joint axis", "simulate card.json",
    "twin t.csv --seed 3 --direction up", "bench campaign.toml --show", "identify log.csv --rig x",
    "identify log.csv --set F_S=3±1 --law none", "compensate card.json --loop loop.toml --speed x",
    "plan card.json --budget none", "validate card.json absent.csv --max-error 3", "--help",
)  # fmt: skip


@dataclass(frozen=True)
class Target:
    """Something that reads an input.

    Args:
        corpus: Inputs that it accepts, or nearly.
        file: The name of the file that an input is written to, in the working directory.
        call: What reads that file; raises `InputError` for a refusal.
    """

    corpus: Callable[[], list[bytes]]
    file: str
    call: Callable[[bytes], object]


def prepare() -> None:
    """Write the files that inputs refer to into the working directory: a log, a fit, a robot."""
    Path("log.csv").write_bytes(_texts()[0])
    Path("mapped").mkdir(exist_ok=True)
    Path("mapped/log.csv").write_bytes(_texts()[0])
    positions = {"t_s": _T, "x_mm": _LOG["x_mm"]}
    Path("pos.csv").write_text(_columns(positions), encoding="utf-8")
    Path("dated.csv").write_text(_columns({**positions, "t_s": 1.7e9 + _T}), encoding="utf-8")
    for name, text in (("map.toml", _MAPS[0]), ("rig.toml", _RIGS[0]), ("loop.toml", _LOOPS[0]),
                       ("robot.urdf", _URDF), ("campaign.toml", shipped()["paper"])):  # fmt: skip
        Path(name).write_text(text, encoding="utf-8")
    if not Path("corpus").exists():
        program = Path(__file__).with_name("fuzz_logs.py")
        subprocess.run([sys.executable, str(program), "corpus"], check=True)  # noqa: S603 - ours
    if not Path("fit/card.json").exists():
        command("twin", "up.csv", "--direction", "up", "--seed", "1")
        command("identify", "up.csv", "--rig", "slide-bed", "--exact", "--budget", "20",
                "--repeats", "1", "--train", "112:295", "--out", "fit")  # fmt: skip
    Path("card.json").write_bytes(Path("fit/card.json").read_bytes())


def command(*arguments: str) -> None:
    """A call of the command line.

    Raises:
        InputError: it was refused, in one line.
        RuntimeError: it ended otherwise than a command may.
    """
    out, err = io.StringIO(), io.StringIO()
    before, sys.argv = sys.argv, ["stribeck", *arguments]
    status: object = 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            cli.main()
    except SystemExit as end:
        status = end.code or 0
    finally:
        sys.argv = before
    lines = err.getvalue().splitlines()
    if status == 2 and len(lines) == 1 and lines[0].isprintable():  # noqa: PLR2004 - refused
        raise InputError(lines[0])
    if status not in (0, 1):
        raise RuntimeError(f"status {status}: {err.getvalue()[:500]}")


def _texts() -> list[bytes]:
    rows = [
        ",".join(_LOG),
        *(",".join(f"{c:g}" for c in row) for row in zip(*_LOG.values(), strict=True)),
    ]
    plain = "\n".join(rows)
    comma = plain.replace(",", ";").replace(".", ",")
    quoted = "\n".join(f'"{r}"'.replace(",", '","') for r in rows)
    units = plain.replace("t_s,x_mm,F_N", "Zeit,Weg,Kraft\ns,mm,N")
    words = "\n".join(f"{r},{'note' if i % 3 else 'off'}" for i, r in enumerate(rows))
    texts = [plain, comma, quoted, units, words, plain.replace(",", "\t"), f"# log\n{plain}"]
    return [
        *(t.encode() for t in texts),
        plain.replace(",", " ").encode(),
        plain.replace("\n", "\r\n").encode(),
        plain.encode("utf-16"),
    ]


def _others() -> list[bytes]:
    """Text as instruments write it: preambles, units below heads, dates, thousands, runs."""
    rows = list(zip(_T, *list(_LOG.values())[1:], strict=True))
    tool = "Model,MR-J4-A\nSampling time,10 ms\n\nTime,Position,Torque\nms,mm,%\n" + "\n".join(
        f"{1e3 * t:g},{x},{f}," for t, x, f in rows
    )
    dates = "stamp;x [mm];F [N]\n" + "\n".join(
        f"14.11.2023 22:13:{20 + t:06.3f};{x};{f}" for t, x, f in rows
    )
    thousands = "t [us];x [mm]\n" + "\n".join(f"{1e6 * t:,.0f};{x}" for t, x, _ in rows)
    speeds = "v_mean [mm/s],F_mean [N],F_sd [N],n\n" + "\n".join(
        f"{10 * (k - 9.5):g},{3 + k % 3},0.2,{k + 5}" for k in range(20)
    )
    return [text.encode() for text in (tool, dates, thousands, speeds)]


def _columns(columns: Mapping[str, Any]) -> str:
    rows = zip(*columns.values(), strict=True)
    cells = (",".join(c if isinstance(c, str) else f"{c:.16g}" for c in row) for row in rows)
    return "\n".join([",".join(columns), *cells])


def _parts() -> list[bytes]:
    """Files with the force of a run whose positions are in another, or in both."""
    fast = np.arange(3 * _ROWS) * 0.004
    force = np.round(np.sin(9 * fast), 4)
    dates = [f"2023-11-14T23:13:{20 + t:09.6f}+01:00" for t in fast]  # 1.7e9 s since 1970
    tables = (
        {"t_s": fast, "F_N": force},
        {"t_ms": 1e3 * fast + 35.0, "F_N": force, "x_mm": 100 * fast**2},
        {"time": 1.7e12 + np.round(1e3 * fast), "F_N": force},
        {"time": dates, "F_N": force},
    )
    return [_columns(table).encode() for table in tables]


def _joined(data: bytes) -> None:
    """The run of a file with another whose clock counts the same."""
    read("dated.csv+force.csv" if data.startswith(b"time") else "pos.csv+force.csv")


def _jsons() -> list[bytes]:
    records = [
        dict(zip(_LOG, map(float, row), strict=True)) for row in zip(*_LOG.values(), strict=True)
    ]
    whole = {"log": records, "mass_kg": 24, "on": True, "name": "a", "gain": "3.5"}
    return [json.dumps(x).encode() for x in (records, whole, [{**r, "q": [1, 2]} for r in records])]


def _matlabs() -> list[bytes]:
    files = []
    for more in ({}, {"k": 3.0, "w": "text", "s": {"a": 1}, "m": np.ones((_ROWS, 3))}):
        for packed in (False, True):
            buffer = io.BytesIO()
            log: dict[str, Any] = {**_LOG, **more, "i": np.arange(_ROWS, dtype="i2")}
            scipy.io.savemat(cast("str", buffer), log, do_compression=packed)
            files.append(buffer.getvalue())
    return files


def _parquets() -> list[bytes]:
    more = {"w": ["on"] * _ROWS, "l": [[1, 2]] * _ROWS, "b": _T[9] < _T, "i": np.arange(_ROWS)}
    files = []
    for columns in (_LOG, {**_LOG, **more}):
        for packing in ("uncompressed", "zstd", "snappy", "gzip"):
            buffer = io.BytesIO()
            pl.DataFrame(columns).write_parquet(buffer, compression=cast("Any", packing))
            files.append(buffer.getvalue())
    return files


def _settings() -> list[bytes]:
    values = {s.name: {"value": 0.5, "unit": s.unit} for s in SETTINGS}
    return [
        json.dumps(
            {"schema": SCHEMA, "recommended": {"settings": {**values, "feedback": {"value": on}}}}
        ).encode()
        for on in (0, 1)
    ]


def _of_folder(*names: str) -> Callable[[], list[bytes]]:
    return lambda: [Path(name).read_bytes() for name in names]


def _encoded(*texts: str) -> Callable[[], list[bytes]]:
    return lambda: [text.encode() for text in texts]


def _robot(change: Callable[..., object]) -> Callable[[bytes], object]:
    return lambda data: change(read_model("card.json"), data, "axis")


def _arguments(data: bytes) -> None:
    """A command line; what it may write stays in the working directory."""
    arguments = data.decode(errors="replace").split()
    if "bench" in arguments and "--show" not in arguments:
        raise InputError("a campaign would take hours")
    if not any(a.startswith(("/", "~")) or ".." in a or "\0" in a or "=/" in a for a in arguments):
        command(*arguments)


def _of_corpus(name: str) -> Callable[[], list[bytes]]:
    return lambda: [file.read_bytes() for file in sorted(Path("corpus").glob(f"{name}-*"))]


def _reads(file: str) -> Callable[[bytes], object]:
    return lambda _: read(file, columns=_COLUMNS.get(file))


#: Columns of those whose names say no units, or that have several joints.
_COLUMNS: dict[str, dict[str, Any]] = {
    "input.trace.csv": {"columns": {"position": "x [mm]"}, "time_unit": "ms"},
    "bare.txt": {"columns": {"position": "1 [mm]", "force": "2 [N]"}, "rate": 100.0},
    "input.json.gz": {"position": "x position [mm]"},
    "input.ulg": {"position": "axis.0/x [mm]"},
    "dataset": {"position": "observation.state/elbow.pos [rad]"},
}
#: Formats of logs whose files are made by `fuzz_logs`: the name of the file that is damaged.
_FILES = {
    "twincat": "input.scope.csv", "codesys": "input.trace.csv",
    "klipper": "input.json.gz", "lvm": "input.lvm",
    "npz": "input.npz", "feather": "input.feather", "hdf5": "input.h5", "tdms": "input.tdms",
    "mdf4": "input.mf4", "rosbag": "input.bag", "ulog": "input.ulg",
    "signalexpress": "input.express.txt", "db3": "input.db3", "mcap": "input.mcap",
}  # fmt: skip


TARGETS = {
    **{name: Target(_of_corpus(name), file, _reads(file)) for name, file in _FILES.items()},
    "lerobot": Target(
        _of_corpus("lerobot"), "dataset/data/chunk-000/file-000.parquet", _reads("dataset")
    ),
    "text": Target(_texts, "input.csv", lambda _: read("input.csv")),
    "instruments": Target(_others, "input.csv", lambda _: read("input.csv")),
    "headless": Target(
        lambda: [
            "\n".join(f"{x} {f}" for x, f in zip(*list(_LOG.values())[1:], strict=True)).encode()
        ],
        "bare.txt",
        _reads("bare.txt"),
    ),
    "window": Target(_texts, "input.csv", lambda _: read("input.csv@0.05s:0.3s")),
    "savedmap": Target(
        _encoded(*_SAVED_MAPS), "mapped/stribeck.columns.toml", lambda _: read("mapped/log.csv")
    ),
    "joined": Target(_parts, "force.csv", _joined),
    "json": Target(_jsons, "input.json", lambda _: read("input.json")),
    "matlab": Target(_matlabs, "input.mat", lambda _: read("input.mat")),
    "parquet": Target(_parquets, "input.parquet", lambda _: read("input.parquet")),
    "columns": Target(
        _encoded(*_MAPS), "input.toml", lambda _: read("log.csv", columns="input.toml")
    ),
    "rig": Target(_encoded(*_RIGS), "input.toml", lambda _: rig_named("input.toml")),
    "axis": Target(_encoded(*_AXES), "input.toml", lambda _: rig_named("input.toml")),
    "loop": Target(
        _encoded(*_LOOPS), "input.toml", lambda _: loop_file(Path("input.toml"), RIGS["slide-bed"])
    ),
    "campaign": Target(
        lambda: [t.encode() for t in shipped().values()],
        "input.toml",
        lambda _: campaign("input.toml"),
    ),
    "card": Target(_of_folder("card.json"), "input.json", lambda _: read_model("input.json")),
    "report": Target(
        _of_folder("fit/report.json"), "result/report.json", lambda _: read_report("result")
    ),
    "settings": Target(
        _settings,
        "input.json",
        lambda _: read_settings("input.json"),
    ),
    "mjcf": Target(_encoded(_MJCF), "input.xml", _robot(mjcf)),
    "urdf": Target(_encoded(_URDF), "input.urdf", _robot(urdf)),
    "command": Target(_encoded(*_COMMANDS), "input.txt", _arguments),
}
