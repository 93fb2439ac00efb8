"""The README's lines, as they stand there."""

import re
import shutil
from pathlib import Path

import pytest

from conftest import by_parameters

import zerorate

PROJECT = Path(__file__).parents[3]
PAGES = [PROJECT / "README.md", PROJECT / "crates/python/README.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(PROJECT)))
def test_its_lines_run_and_give_the_commands_numbers(page, csv, command, tmp_path, monkeypatch):
    lines = re.search(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    shutil.copy(csv, "chamber.csv")
    names = {}
    exec(lines.group(1), names)
    command("fit", "chamber.csv", "--out", "commanded.json")
    assert isinstance(names["calibration"], zerorate.Calibration)
    assert names["calibration"].to_json() == by_parameters(Path("commanded.json").read_text())
