"""The reference of Python is that of the code, and says what it must of every public name."""

from __future__ import annotations

import inspect
import re

import pytest

import api_reference
import stribeck

NAMES = [name for names in api_reference.CHAPTERS.values() for name in names]


def test_the_page_is_what_the_code_says() -> None:
    text = api_reference.PAGE.read_text(encoding="utf-8")
    assert text == api_reference.page(), "renew it: python tools/api_reference.py"


def test_every_public_name_is_in_it_once() -> None:
    assert sorted([*NAMES, *api_reference.REGISTRIES]) == sorted(stribeck.__all__)


@pytest.mark.parametrize("name", [n for n in NAMES if inspect.isfunction(getattr(stribeck, n))])
def test_a_function_says_its_arguments_and_what_it_refuses(name: str) -> None:
    function = getattr(stribeck, name)
    text = inspect.getdoc(function) or ""
    described = set(re.findall(r"^    (\w+): ", text.partition("Args:")[2], re.MULTILINE))
    assert set(inspect.signature(function).parameters) <= described | {"args", "kwargs"}
    assert "Raises:" in text
