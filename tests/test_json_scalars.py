"""Scalars beside the records of a JSON log: numbers are read, texts of numbers are reported."""

import json
from pathlib import Path

from stribeck import read


def log(folder: Path, **scalars: object) -> Path:
    records = [{"t_s": 0.01 * k, "position_m": 0.001 * k} for k in range(50)]
    file = folder / "log.json"
    file.write_text(json.dumps({"entries": records, **scalars}), encoding="utf-8")
    return file


def test_numbers_and_names_are_not_told(tmp_path: Path) -> None:
    assert read(log(tmp_path, kp=100, maker="ACME")).notes == ()


def test_a_text_that_means_a_number_is_told(tmp_path: Path) -> None:
    (note,) = read(log(tmp_path, kp="100", maker="ACME", serial=None)).notes
    assert "kp" in note
    assert "100" in note
    assert "not a number" in note
