"""Commands run in this process, in a folder of their own."""

import sys
from pathlib import Path

import pytest

from multisrt import cli
from tests.multisrt.cli.commands import MAPS, Call


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, which contains `MAPS`."""
    monkeypatch.chdir(tmp_path)
    for name, text in MAPS.items():
        (tmp_path / f"{name}.wkt").write_text(text)
    return tmp_path


@pytest.fixture
def call(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Call:
    """Run `multisrt` in the folder."""

    def run(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["multisrt", *words])
        with pytest.raises(SystemExit) as end:
            cli.main()
        captured = capsys.readouterr()
        assert isinstance(end.value.code, int)
        return end.value.code, captured.out, captured.err

    return run
