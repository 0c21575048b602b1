"""The notebooks in examples/ run, and are stored without their outputs."""

import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parent.parent / "examples").glob("*.ipynb"))


def ids(paths: list[Path]) -> list[str]:
    return [path.stem for path in paths]


def test_there_are_three_notebooks():
    assert len(NOTEBOOKS) == 3


@pytest.mark.parametrize("path", NOTEBOOKS, ids=ids(NOTEBOOKS))
def test_notebooks_are_stored_without_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=ids(NOTEBOOKS))
def test_notebooks_run_and_every_result_shows_itself(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(path, tmp_path)
    notebook = nbformat.read(tmp_path / path.name, as_version=4)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [one for cell in notebook.cells for one in cell.get("outputs", [])]
    assert [
        one.text for one in outputs if one.output_type == "stream" and one.name == "stderr"
    ] == []
    shown = [set(one.data) for one in outputs if "data" in one]
    assert any("text/html" in kinds for kinds in shown)
    # A line of progress is written anew in one place.
    if any("progress=True" in cell.source for cell in notebook.cells):
        lines = [one.data["text/plain"] for one in outputs if one.output_type == "display_data"]
        assert sum(" seen, " in line for line in lines) == 1
