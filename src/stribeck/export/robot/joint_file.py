"""A joint in a robot file that a person wrote: found there, and changed where it stands.

The file is read by expat, which says at which byte a tag begins. A change replaces bytes of that
tag and nothing else: comments, order, quotes, line ends and encoding stay as they were.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NoReturn
from xml.parsers import expat

from ...errors import InputError
from ...text_file import LARGEST

#: Elements inside each other: a robot has a few dozen.
_DEEPEST = 1000
#: Names listed in a refusal, how long one may be there, and how many are searched for a near miss.
_LISTED, _NAME, _SEARCHED = 12, 60, 5000
#: White space as XML has it; Python's own would take in what are bytes of a letter in UTF-8.
_SPACE = r"[ \t\r\n]"
_ATTRIBUTE = re.compile(rf"({_SPACE}+)([^ \t\r\n=/>\"']+){_SPACE}*={_SPACE}*(\"[^\"]*\"|'[^']*')")
_HEAD = re.compile(r"<[^ \t\r\n/>]+")
_QUOTED = re.compile(r"\"[^\"]*\"|'[^']*'|>")
_BLANK = re.compile(rf"{_SPACE}*")


@dataclass(eq=False)
class Tag:
    """An element of the file.

    Args:
        name: As it is written, with its prefix.
        attributes: Its attributes, their values read.
        parent: The element around it.
        line: Where it begins, from 1.
        start: The byte at which it begins.
        end: The byte at which its end tag begins; that of the tag itself where it closes itself.
        text: Its start tag as it stands in the file.
    """

    name: str
    attributes: Mapping[str, str]
    parent: Tag | None
    line: int
    start: int
    end: int = -1
    text: str = field(default="", repr=False)

    @property
    def closed(self) -> bool:
        """Whether it closes itself."""
        return self.text.endswith("/>")

    def around(self) -> Iterable[Tag]:
        """The elements that it stands in, the nearest first."""
        tag = self.parent
        while tag is not None:
            yield tag
            tag = tag.parent


@dataclass(frozen=True)
class Change:
    """Text to stand in place of the bytes from `start` to `stop`."""

    start: int
    stop: int
    text: str


class JointFile:
    """A robot file: its root, and the elements that matter.

    Args:
        source: The file.
        kept: Names of the elements that matter.

    Raises:
        InputError: not XML, too large, nested too deeply, or with a document type (what entities
            it defines would have to be trusted).
    """

    def __init__(self, source: bytes, kept: Collection[str]) -> None:
        if len(source) > LARGEST:
            raise InputError(f"is larger than {LARGEST >> 20} MiB: is it the right file?")
        if not source.strip():
            raise InputError("is empty")
        self.source, self.codec = source, _codec(source)
        self.tags: list[Tag] = []
        #: Names of all elements that have a prefix, such as `xacro:macro`.
        self.prefixed: set[str] = set()
        self._kept, self._open = frozenset(kept), list[Tag]()
        self._parser = parser = expat.ParserCreate()
        parser.StartElementHandler = self._starts
        parser.EndElementHandler = self._ends
        parser.StartDoctypeDeclHandler = self._refuses
        try:
            parser.Parse(source, True)
        except expat.ExpatError as error:
            raise InputError(
                f"line {error.lineno}: not XML: {expat.ErrorString(error.code)}"
            ) from error
        except InputError:
            raise
        except (LookupError, ValueError) as error:
            raise InputError(f"its encoding cannot be read: {error}: save it as UTF-8") from error
        finally:
            del self._parser  # its handlers hold on to this

    @property
    def root(self) -> Tag:
        """The outermost element."""
        return self.tags[0]

    def named(self, *names: str) -> list[Tag]:
        """The elements of these names, in their order."""
        return [tag for tag in self.tags if tag.name in names]

    def attributed(self, tag: Tag, values: Mapping[str, str]) -> Change:
        """A tag with attributes set: replaced where it has them, added behind the last if not."""
        text = tag.text
        for name, value in values.items():
            text = _set(text, name, value)
        return Change(tag.start, tag.start + len(self._bytes(tag.text)), text)

    def inside(self, tag: Tag, text: str) -> Change:
        """A first child: on a line of its own where the children have lines of their own."""
        after = tag.start + len(self._bytes(tag.text))
        if tag.closed:
            head = tag.text[:-2].rstrip(" \t\r\n")
            return Change(tag.start, after, f"{head}>{text}</{tag.name}>")
        # As many blanks as lie before the next thing; they follow what is put in.
        follows = self.source[after : after + 4096]
        blank = _BLANK.match(follows.decode(self.codec, errors="replace"))
        return Change(after, after, f"{blank[0] if blank else ''}{text}")

    def last(self, tag: Tag, text: str) -> Change:
        """A last child, on a line of its own with the indent of its parent."""
        if tag.closed:
            return self.inside(tag, text)
        return Change(tag.end, tag.end, text)

    def changed(self, changes: Sequence[Change]) -> bytes:
        """The file with these changes, none of which touches another."""
        pieces, at = [], 0
        for change in sorted(changes, key=lambda c: c.start):
            pieces += [self.source[at : change.start], self._bytes(change.text)]
            at = change.stop
        return b"".join([*pieces, self.source[at:]])

    def _bytes(self, text: str) -> bytes:
        return text.encode(self.codec)

    def _starts(self, name: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= _DEEPEST:
            raise InputError(f"line {self._parser.CurrentLineNumber}: nested too deeply")
        if ":" in name:
            self.prefixed.add(name)
        at = self._parser.CurrentByteIndex
        parent = self._open[-1] if self._open else None
        tag = Tag(name, attributes, parent, self._parser.CurrentLineNumber, at)
        if name in self._kept or parent is None:
            tag.text = self._tag_at(at)
            self.tags.append(tag)
        self._open.append(tag)

    def _ends(self, name: str) -> None:
        del name
        self._open.pop().end = self._parser.CurrentByteIndex

    def _refuses(self, *doctype: object) -> NoReturn:
        del doctype
        raise InputError(
            f"line {self._parser.CurrentLineNumber}: has a document type (<!DOCTYPE>), which "
            "robot files do without: take it out"
        )

    def _tag_at(self, at: int) -> str:
        """The start tag at a byte; a `>` inside quotes does not end it."""
        length = 1024
        while True:
            text = self.source[at : at + length].decode(self.codec, errors="replace")
            if not text.startswith("<"):
                raise InputError("its encoding cannot be patched: save it as UTF-8")
            for token in _QUOTED.finditer(text):
                if token[0] == ">":
                    return text[: token.end()]
            length *= 4


def _codec(source: bytes) -> str:
    """How its tags are read and written again: all of XML's own signs are ASCII.

    In UTF-8 and the 8-bit encodings of Latin, Greek, Cyrillic and so on, ASCII bytes are ASCII, so
    that each byte may stand for a letter of its own here.
    """
    for head, codec in (
        (b"\xff\xfe", "utf-16-le"), (b"<\x00", "utf-16-le"),
        (b"\xfe\xff", "utf-16-be"), (b"\x00<", "utf-16-be"),
    ):  # fmt: skip
        if source.startswith(head):
            return codec
    return "latin-1"


def _set(text: str, name: str, value: str) -> str:
    """A start tag with an attribute set."""
    attributes = list(_ATTRIBUTE.finditer(text))
    for each in attributes:
        if each[2] == name:
            start, stop = each.span(3)
            quote = each[3][0]
            return f"{text[:start]}{quote}{value}{quote}{text[stop:]}"
    head = _HEAD.match(text)
    at = attributes[-1].end() if attributes else (head.end() if head else 1)
    space = attributes[-1][1] if attributes and "\n" in attributes[-1][1] else " "
    quote = attributes[-1][3][0] if attributes else '"'
    return f"{text[:at]}{space}{name}={quote}{value}{quote}{text[at:]}"


def number(value: float) -> str:
    """A number as it is written into a file: six digits, more than any friction is known to."""
    return f"{value:.6g}"


def joint_named(joints: Sequence[Tag], name: str, elsewhere: str = "") -> Tag:
    """The joint of a name.

    Args:
        joints: All joints of the file.
        name: The one that is meant.
        elsewhere: What to add where it is not there: where else it could be.

    Raises:
        InputError: it is not there, or more than once.
    """
    names = [tag.attributes.get("name") for tag in joints]
    return joints[one_named(names, name, [f"line {tag.line}" for tag in joints], elsewhere)]


def one_named(
    names: Sequence[str | None], name: str, places: Sequence[str], elsewhere: str = ""
) -> int:
    """The index of a joint's name.

    Args:
        names: Those of all joints, None for one without.
        name: The one that is meant.
        places: Where each stands, as a message says it.
        elsewhere: As for `joint_named`.

    Raises:
        InputError: it is not there, or more than once.
    """
    matches = [i for i, each in enumerate(names) if each == name]
    if len(matches) == 1:
        return matches[0]
    if matches:
        at = ", ".join(places[i] for i in matches[:_LISTED])
        raise InputError(
            f"has {len(matches)} joints named {name!r}, at {at}: give them different names"
        )
    known = [each for each in names if each]
    similar = difflib.get_close_matches(name, known[:_SEARCHED], 1)
    listed = ", ".join(each[:_NAME] for each in known[:_LISTED])
    if len(known) > _LISTED:
        listed += f" and {len(known) - _LISTED} more"
    if unnamed := len(names) - len(known):
        listed = f"{listed or 'none with a name'}, and {unnamed} without a name"
    message = f"has no joint {name!r}: there are {listed or 'none'}"
    if similar:
        message += f"; did you mean {similar[0][:_NAME]!r}?"
    raise InputError(f"{message}; {elsewhere}" if elsewhere else message)
