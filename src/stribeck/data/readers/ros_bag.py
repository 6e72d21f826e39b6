"""ROS 1 bags, ROS 2 bags (sqlite3, MCAP) and MCAP files, by rosbags, without ROS.

The numbers of each message are channels `topic/field`; those of a `sensor_msgs/JointState` go by
the name of the joint, `topic/joint/position`. A topic is a clock: the stamps in the heads of its
messages, or those of the log.
"""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ...errors import InputError
from ...space import Array
from ...wording import option
from .isolated import IsolatedFormat
from .lazy_log import LazyLog
from .log_file import Channel, Reader, ReadOptions
from .raw_table import RawTable, listed, shortened

LIBRARIES = ("rosbags.highlevel", "rosbags.typesys")
_MAGICS = {b"#ROSBAG V2.0": ".bag", b"SQLite format 3\0": ".db3", b"\x89MCAP0\r\n": ".mcap"}
_METADATA = "metadata.yaml"
_NANOSECOND = 1e-9
#: Messages of a topic from which its channels and the offset of its stamps are known.
_FIRST = 100
_MOST_LAST = 1000
_LAST_SECONDS = 2.0
#: Elements of an array beyond which it is an image, a map or a cloud.
_LONGEST = 64
_DEEPEST = 6
_ROTARY = (
    "joint states are in rad, rad/s and N m, as sensor_msgs defines for joints that turn: map "
    "those of a joint that slides, in m, m/s and N"
)
_UNITS = {"position": "rad", "velocity": "rad/s", "effort": "N m"}


@dataclass
class _Topic:
    """A topic of the bag.

    Args:
        name: With its leading slash.
        connections: Of rosbags.
        count: Messages.
        channels: Name -> first and last number.
        header: Whether its messages bear stamps.
        sentences: What is wrong with it.
    """

    name: str
    connections: list[Any]
    count: int
    channels: dict[str, tuple[float, float]] = field(default_factory=dict)
    header: bool = False
    sentences: list[str] = field(default_factory=list)


def library_log(path: Path, options: ReadOptions) -> LazyLog:
    """A bag, in the process that has rosbags."""
    from rosbags.highlevel import AnyReader  # noqa: PLC0415 - an extra
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - an extra

    store = get_typestore(Stores.LATEST)
    bag: Any = AnyReader([_with_suffix(path)], default_typestore=store)
    bag.open()
    topics: dict[str, _Topic] = {}
    unknown = []
    for connection in bag.connections:
        if connection.msgtype not in bag.typestore.fielddefs:
            unknown.append(f"{connection.topic} ({connection.msgtype})")
            continue
        topic = topics.setdefault(connection.topic, _Topic(connection.topic, [], 0))
        topic.connections.append(connection)
        topic.count += connection.msgcount
    for topic in topics.values():
        _look(bag, topic, options)
    channels = [c for topic in topics.values() for c in _channels(topic, bag, options)]

    def load(wanted: Collection[str]) -> tuple[RawTable, ...]:
        return tuple(
            table for topic in topics.values() if set(topic.channels).intersection(wanted)
            for table in _tables(bag, topic, set(wanted), options)
        )  # fmt: skip

    problems = [s for topic in topics.values() for s in topic.sentences]
    if any(c.unit for c in channels):
        problems.append(_ROTARY)
    if unknown:
        problems.append(f"left out, of types that are not in the bag: {listed(unknown)}")
    if bare := [t.name for t in topics.values() if t.count and not t.channels]:
        problems.append(f"left out, without numbers: {listed(bare)}")
    return LazyLog(tuple(channels), load, tuple(problems))


_FORMAT = IsolatedFormat("ros_bag", LIBRARIES, "a ROS bag")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(tuple(_MAGICS))


def _opens_folder(path: Path, _head: bytes) -> bool:
    file = path / _METADATA
    return file.is_file() and b"rosbag2_bagfile_information" in file.read_bytes()[:4096]


def _opens_any(path: Path, head: bytes) -> bool:
    return _opens_folder(path, head) if path.is_dir() else _opens(path, head)


READER = Reader(
    "rosbag",
    "ROS 1 bag, ROS 2 bag (file or folder), MCAP",
    (".bag", ".db3", ".mcap"),
    _opens_any,
    _FORMAT.open,
    extra="logs",
    library="rosbags (Apache-2.0)",
    folders=True,
)


def _with_suffix(path: Path) -> Path:
    """A path with the extension that rosbags goes by."""
    if path.is_dir():
        return path
    with path.open("rb") as file:
        start = file.read(16)
    suffix = next((s for magic, s in _MAGICS.items() if start.startswith(magic)), "")
    if path.suffix == suffix:
        return path
    link = Path(tempfile.mkdtemp()) / f"log{suffix}"
    link.symlink_to(path.resolve())
    return link


def _look(bag: Any, topic: _Topic, options: ReadOptions) -> None:
    """The channels of a topic, by its first and last messages, and what its stamps are worth."""
    if not topic.count:
        return
    late = bag.end_time - int(_LAST_SECONDS * 1e9)
    first = list(islice(_messages(bag, bag.messages(topic.connections)), _FIRST))
    last = list(islice(_messages(bag, bag.messages(topic.connections, start=late)), _MOST_LAST))
    for _, message in (*first, *last):
        for name, number in _numbers(topic.name, message):
            topic.channels[name] = topic.channels.get(name, (number, number))[0], number
        if len(topic.channels) > _LONGEST * _LONGEST:
            raise InputError(f"{shortened(topic.name)} has too many numbers in a message")
    topic.header = bool(first) and all(_stamp(message) for _, message in (*first, *last))
    if topic.header and last:
        topic.sentences += _drift(topic.name, _Stamps.of(first), _Stamps.of(last), options)


class _Stamps(NamedTuple):
    """Both stamps of messages of a topic.

    Args:
        log: Mean stamp of the log, s.
        offset: Median of what it is later than that of the header, s.
        interval: Median between messages, s.
    """

    log: float
    offset: float
    interval: float

    @classmethod
    def of(cls, messages: list[tuple[int, Any]]) -> Self:
        """Those of messages with their stamps of the log, ns."""
        zero = messages[0][0]
        log = np.array([stamp - zero for stamp, _ in messages]) * _NANOSECOND
        head = np.array([_stamp(message) - zero for _, message in messages]) * _NANOSECOND
        interval = float(np.median(np.diff(log))) if len(log) > 1 else 0.0
        return cls(zero * _NANOSECOND + log.mean(), float(np.median(log - head)), interval)


def _drift(name: str, first: _Stamps, last: _Stamps, options: ReadOptions) -> Iterator[str]:
    """A sentence where the two clocks part by more than half a sample over the log."""
    lasting, parted = last.log - first.log, last.offset - first.offset
    if lasting > 0.0 and abs(parted) > 0.5 * max(first.interval, 1e-3):
        other = "log" if options.stamp == "header" else "header"
        yield (
            f"{shortened(name)}: its header stamps and those of the log drift {1e3 * parted:.3g} "
            f"ms apart in {lasting:.4g} s ({1e6 * parted / lasting:.3g} ppm): the {options.stamp} "
            f"stamps are used; compare {option('columns', {'stamp': other})}"
        )


def _messages(bag: Any, messages: Any) -> Iterator[tuple[int, Any]]:
    for connection, log, raw in messages:
        yield log, bag.deserialize(raw, connection.msgtype)


def _stamp(message: Any) -> int:
    """The stamp in the head of a message, ns; 0 where it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _numbers(path: str, value: Any, depth: int = 0) -> Iterator[tuple[str, float]]:
    """The numbers of a message with their names."""
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield path, float(value)
    elif isinstance(value, np.ndarray):
        if value.dtype.kind in "iufb" and value.size <= _LONGEST:
            yield from ((f"{path}/{i}", float(v)) for i, v in enumerate(value.reshape(-1), 1))
    elif isinstance(value, list):
        if len(value) <= _LONGEST and depth < _DEEPEST:
            for i, entry in enumerate(value, 1):
                yield from _numbers(f"{path}/{i}", entry, depth + 1)
    elif is_dataclass(value) and depth < _DEEPEST:
        yield from _members(path, value, depth)


def _members(path: str, value: Any, depth: int) -> Iterator[tuple[str, float]]:
    joints = _joints(value)
    for member in fields(value):
        content = getattr(value, member.name)
        if member.name in ("header", "__msgtype__") or member.name.startswith("__"):
            continue
        if joints and isinstance(content, np.ndarray) and len(content) == len(joints):
            yield from (
                (f"{path}/{joint}/{member.name}", float(v))
                for joint, v in zip(joints, content, strict=True)
            )
        else:
            yield from _numbers(f"{path}/{member.name}", content, depth + 1)


def _joints(value: Any) -> list[str]:
    """Names of joints that its arrays go by."""
    for member in ("name", "joint_names"):
        names = getattr(value, member, None)
        if isinstance(names, list) and names and all(isinstance(n, str) and n for n in names):
            return names
    return []


def _unit(topic: _Topic, name: str) -> str | None:
    """Of a `JointState`: its definition has radians, for joints that turn."""
    kinds = {c.msgtype for c in topic.connections}
    if kinds != {"sensor_msgs/msg/JointState"}:
        return None
    return _UNITS.get(name.rpartition("/")[2])


def _channels(topic: _Topic, bag: Any, options: ReadOptions) -> list[Channel]:
    if not topic.count:
        return []
    lasting = (bag.end_time - bag.start_time) * _NANOSECOND
    rate = (topic.count - 1) / lasting if lasting > 0.0 and topic.count > 1 else None
    if options.stamp == "header" and not topic.header and topic.channels:
        topic.sentences.append(f"{shortened(topic.name)}: its messages bear no stamps: those of "
                               "the log are used")  # fmt: skip
    return [
        Channel(
            n,
            _unit(topic, n),
            topic.count,
            topic.name,
            rate,
            (0.0, lasting),
            ends if np.isfinite(ends).all() else None,
        )
        for n, ends in topic.channels.items()
    ]


def _tables(bag: Any, topic: _Topic, wanted: set[str], options: ReadOptions) -> Iterator[RawTable]:
    """The channels of a topic; those that not all of its messages have are apart."""
    cells: dict[str, tuple[array[float], array[float]]] = {
        n: (array("d"), array("d")) for n in topic.channels if n in wanted
    }
    start = bag.start_time
    by_header = options.stamp == "header" and topic.header
    for log, message in _messages(bag, bag.messages(topic.connections)):
        t = ((_stamp(message) if by_header else log) - start) * _NANOSECOND
        for name, number in _numbers(topic.name, message):
            if name in cells:
                cells[name][0].append(t)
                cells[name][1].append(number)
    clocks: list[tuple[array[float], dict[str, Array]]] = []
    for name, (t_of, values) in cells.items():
        columns = next((c for clock, c in clocks if clock == t_of), None)
        if columns is None:
            columns = {}
            clocks.append((t_of, columns))
        columns[name] = np.frombuffer(values) if values else np.empty(0)
    make = partial(RawTable, word="message")
    for k, (t_of, columns) in enumerate(clocks, 1):
        t_array = np.frombuffer(t_of) if t_of else np.empty(0)
        order = np.argsort(t_array, kind="stable")
        yield make(
            {n: a[order] for n, a in columns.items()},
            np.arange(1, len(t_array) + 1),
            units={n: u for n in columns if (u := _unit(topic, n))},
            t=t_array[order],
            began=start * _NANOSECOND,
            clock=topic.name if k == 1 else f"{topic.name} #{k}",
        )
