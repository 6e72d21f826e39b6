"""A rig file: a shipped kind and its changes, or one line that names the error."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck import LAWS, RIGS, InputError
from stribeck.friction import law_named
from stribeck.rig import Rig
from stribeck.rig.custom import rig_file

KIND = 'kind = "slide-bed"\n'


def rig(folder: Path, text: str) -> Rig:
    file = folder / "mine.toml"
    file.write_text(text, encoding="utf-8")
    return rig_file(file)


@pytest.mark.parametrize("kind", RIGS)
def test_nothing_said_is_the_shipped_rig_under_the_name_of_the_file(
    kind: str, tmp_path: Path
) -> None:
    loaded, shipped = rig(tmp_path, f'kind = "{kind}"\n'), RIGS[kind]
    assert loaded.name == "mine"
    assert type(loaded) is type(shipped)
    assert loaded.constants == shipped.constants
    assert loaded.columns == shipped.columns
    for law in map(LAWS.get, shipped.laws):
        assert law is not None
        assert loaded.parameters(law) == shipped.parameters(law)


def test_numbers_are_in_the_units_that_the_kind_shows(tmp_path: Path) -> None:
    loaded = rig(tmp_path, KIND + "constants = { m = 24, F_fm = 12.5, 'k_hat+' = 4 }\n"
               "ranges = { v_SS = [2, 9], F_V = [0.2, 0.8], F_S = [20, 90] }\n")  # fmt: skip
    assert (loaded["m"], loaded["F_fm"], loaded["k_hat+"]) == (24.0, 12.5, 4000.0)
    ranges = {q.name: (q.lower, q.upper) for q in loaded.parameters(LAWS["stribeck"])}
    assert ranges["v_SS"] == pytest.approx((2e-3, 9e-3))
    assert ranges["F_V"] == pytest.approx((200.0, 800.0))
    assert ranges["F_S"] == (20.0, 90.0)
    assert ranges["F_C"] == (40.0, 80.0)  # not said, as shipped


def test_a_range_without_a_sign_is_for_both_directions(tmp_path: Path) -> None:
    loaded = rig(
        tmp_path,
        KIND + 'law = "stribeck-directional"\nranges = { F_S = [20, 90], "F_C-" = [1, 2] }\n',
    )
    assert loaded.laws[0] == "stribeck-directional"
    ranges = {q.name: (q.lower, q.upper) for q in loaded.parameters(LAWS[loaded.laws[0]])}
    assert ranges["F_S+"] == ranges["F_S-"] == (20.0, 90.0)
    assert (ranges["F_C+"], ranges["F_C-"]) == ((40.0, 80.0), (1.0, 2.0))


def test_a_law_may_have_elements_and_terms_and_a_range_be_for_all_elements(tmp_path: Path) -> None:
    loaded = rig(
        tmp_path,
        'kind = "presliding"\nlaw = "gms:6+temperature"\n'
        "ranges = { W = [0.5, 20], W_3 = [1, 2], r = [1.5, 9], temp_slope = [-0.02, 0.02] }\n",
    )
    assert loaded.laws[0] == "gms:6+temperature"
    ranges = {
        q.name: (q.lower, q.upper, q.log) for q in loaded.parameters(law_named(loaded.laws[0]))
    }
    assert ranges["W_3"] == (1.0, 2.0, True)
    assert {ranges[f"W_{k}"] for k in (1, 2, 4, 5, 6)} == {(0.5, 20.0, True)}
    assert {ranges[f"r_{k}"] for k in range(2, 7)} == {(1.5, 9.0, True)}
    assert ranges["temp_slope"] == (-0.02, 0.02, False)
    # As well for a law that is named later, with elements that none of the rig's own has.
    later = {q.name: (q.lower, q.upper) for q in loaded.parameters(law_named("maxwell-slip:9"))}
    assert later["W_9"] == (0.5, 20.0)
    with pytest.raises(InputError, match=r"ranges: no parameter 'sigmas': there are W_1"):
        rig(tmp_path, 'kind = "presliding"\nlaw = "gms"\nranges = { sigmas = [1, 2] }\n')


def test_columns_and_name(tmp_path: Path) -> None:
    loaded = rig(
        tmp_path, KIND + 'name = "bench 2"\ndoc = "mine"\ncolumns = { position = "actual [mm]" }\n'
    )
    assert (loaded.name, loaded.doc) == ("bench 2", "mine")
    assert dict(loaded.columns) == {"position": "actual [mm]"}
    assert rig(tmp_path, "\ufeff" + KIND).name == "mine"  # a byte order mark does no harm


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["kind", "missing"]),
        ("kind = 3", ["kind", "text"]),
        ('kind = "nope"', ["'nope'", "slide-bed"]),
        ("kind = ", ["not TOML"]),
        ('kind = "cylinder"\nconstants = { bore = -0.1 }', ["bore = -0.1 mm", "above zero"]),
        ('kind = "joint"\nconstants = { hold = 9 }', ["hold = 9", "0, 1 or 2", "demand held"]),
        ('kind = "slide-bed"\nconstants = { F_fm = "-3±1" }', ["F_fm = -3 N", "below 0"]),
        ('kind = "emps"\nconstants = { T = 0 }', ["T = 0 ms must be above zero"]),
        ('kind = "presliding"\nconstants = { step = -1 }', ["step = -1 ms must be above zero"]),
        (KIND + KIND, ["not TOML", "overwrite"]),
        ("[" * 5000, ["not TOML"]),
        (KIND + "x." * 3000 + "y = 1", ["x", "no such word"]),
        (KIND + "m = 3", ["m:", "no such word", "constants"]),
        (KIND + "constants = 3", ["constants", "table"]),
        (KIND + "constants = { nope = 3 }", ["'nope'", "F_fm"]),
        (KIND + 'constants = { m = "3" }', ["constants.m", "number"]),
        (KIND + 'constants = { m = "3±x" }', ["constants.m", "3±x"]),
        (KIND + "constants = { m = true }", ["constants.m", "number"]),
        (KIND + "constants = { m = nan }", ["constants.m", "finite"]),
        (KIND + "constants = { m = 1e400 }", ["constants.m", "finite"]),
        (KIND + f"constants = {{ m = {'9' * 5000} }}", ["not TOML"]),
        (KIND + "ranges = { nope = [1, 2] }", ["'nope'", "F_S"]),
        (KIND + "ranges = { F_S = [150, 100] }", ["F_S", "150", "not below", "100"]),
        (KIND + "ranges = { F_S = [150, 150] }", ["F_S", "not below"]),
        (KIND + "ranges = { F_S = [1] }", ["ranges.F_S", "pair"]),
        (KIND + "ranges = { F_S = [1, 2, 3] }", ["ranges.F_S", "pair"]),
        (KIND + "ranges = { F_S = 3 }", ["ranges.F_S", "pair"]),
        (KIND + "ranges = { F_S = [nan, 2] }", ["ranges.F_S", "finite"]),
        (KIND + 'law = "nope"', ["'nope'", "stribeck"]),
        (KIND + 'law = "stribeck:3"', ["stribeck:3", "only maxwell-slip"]),
        (KIND + 'law = "stribeck+damp"', ["'damp'", "temperature"]),
        (KIND + 'name = "emps"', ["'emps'", "another"]),
        (KIND + 'name = ""', ["name", "printable"]),
        (KIND + 'name = "a\\nb"', ["name", "printable"]),
        (KIND + 'columns = { nope = "x" }', ["'nope'", "position"]),
        (KIND + "columns = { position = 3 }", ["position", "write"]),
        (KIND + 'columns = { position = { column = "x", factor = 0 } }', ["position", "factor"]),
    ],
    ids=lambda x: x[:50] if isinstance(x, str) else "",
)  # fmt: skip
def test_what_is_refused(text: str, words: list[str], tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        rig(tmp_path, text)
    line = str(refused.value)
    assert line.startswith(f"{tmp_path / 'mine.toml'}: ")
    assert [w for w in words if w not in line] == []


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    for path, word in ((tmp_path / "no.toml", "no such file"), (tmp_path, "is a folder")):
        with pytest.raises(InputError, match=word):
            rig_file(path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8"):
        rig_file(tmp_path / "binary.toml")
    with (tmp_path / "huge.toml").open("wb") as f:
        f.truncate(1 << 30)  # sparse: it takes no room, and must take no memory
    with pytest.raises(InputError, match="larger than 4 MiB"):
        rig_file(tmp_path / "huge.toml")


WORDS = st.sampled_from(
    ["kind", "constants", "ranges", "law", "m", "F_S", "=", "{", "}", "[", "]", ",", "1", "-2e9",
     "nan", '"slide-bed"', '"emps"', '"stribeck"', "\n", ".", "'", "#", "inf", "columns",
     "position"]
)  # fmt: skip


@given(words=st.lists(WORDS, max_size=14), with_kind=st.booleans())
@settings(max_examples=300)
def test_any_text_is_a_rig_or_one_line(
    words: list[str], with_kind: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    text = KIND * with_kind + " ".join(words)
    try:
        loaded = rig(tmp_path_factory.getbasetemp(), text)
    except InputError as error:
        assert "mine.toml: " in str(error)  # noqa: PT017 - either way is right, nothing else is
        return
    assert loaded.parameters(LAWS[loaded.laws[0]])
