"""The words of the studio's page: the same in every language, none missing and none for nothing."""

import json
import re
from importlib.resources import files

import pytest

STUDIO = files("stribeck.studio")
LANGUAGES = {
    language: json.loads((STUDIO / "words" / f"{language}.json").read_text(encoding="utf-8"))
    for language in ("en", "de", "zh")
}
ENGLISH = LANGUAGES["en"]
PAGE = "\n".join(
    item.read_text(encoding="utf-8")
    for item in (STUDIO / "page").iterdir()
    if item.name.endswith(".js")
)
#: Calls whose first argument is a key; and keys of which a part is computed.
VALUES = re.compile(r"\{\w+\}")
KEYS = re.compile(r"\b(?:t|button|field)\(\s*\"([a-z][\w. ]*)\"")
COMPUTED = re.compile(r"\b(?:t|term|field)\(`([a-z.]+)\$\{")


@pytest.mark.parametrize("language", ["de", "zh"])
def test_a_language_has_the_words_of_english_and_their_values(language: str) -> None:
    words = LANGUAGES[language]
    assert list(words) == list(ENGLISH)
    for key, text in words.items():
        assert sorted(VALUES.findall(text)) == sorted(VALUES.findall(ENGLISH[key])), key
        assert text.strip(), key


@pytest.mark.parametrize("language", ["de", "zh"])
def test_a_language_is_not_english(language: str) -> None:
    """What stands in both is a name or a number: few words of a catalogue."""
    same = [key for key, text in LANGUAGES[language].items() if text == ENGLISH[key]]
    assert len(same) < 0.06 * len(ENGLISH), same


def test_every_word_that_the_page_asks_for_is_there() -> None:
    asked = set(KEYS.findall(PAGE))
    assert len(asked) > 100
    assert asked - set(ENGLISH) == set()


def test_every_word_is_asked_for() -> None:
    """By its whole key in quotes, or by the beginning of one whose end is computed."""
    beginnings = set(COMPUTED.findall(PAGE))
    server = (STUDIO / "steps.py").read_text(encoding="utf-8")
    idle = [
        key
        for key in ENGLISH
        if f'"{key}"' not in PAGE + server
        and not any(key.startswith(start) for start in beginnings)
    ]
    assert idle == []
