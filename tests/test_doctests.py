import doctest
from functools import partial
from importlib import import_module
from pathlib import Path

import pytest

import multisrt as ms

PACKAGE = Path(__file__).parents[1] / "multisrt"


def modules_with_examples() -> list[str]:
    """The modules with docstrings that show what an interpreter prints, by name."""
    found = []
    for room in sorted(PACKAGE.iterdir()):
        for file in sorted(room.resolve().rglob("*.py")) if room.is_dir() else [room]:
            if file.suffix == ".py" and ">>> " in file.read_text():
                inner = file.relative_to(room.resolve()) if room.is_dir() else Path(room.name)
                parts = [PACKAGE.name, *([room.name] if room.is_dir() else []), *inner.parts]
                found.append(".".join(parts).removesuffix(".py").removesuffix(".__init__"))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", modules_with_examples())
def test_examples_in_docstrings_run(name, tmp_path, monkeypatch):
    module = import_module(name)
    monkeypatch.chdir(tmp_path)
    # A process would take longer to start than the few runs of an example.
    monkeypatch.setattr(ms, "compare", partial(ms.compare, workers=0))
    failed, tried = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert failed == 0
    assert tried > 0


def test_few_examples_are_skipped():
    skipped = [
        name
        for name in modules_with_examples()
        if "doctest: +SKIP" in Path(str(import_module(name).__file__)).read_text()
    ]
    # What writes many files or takes minutes is shown, not run.
    assert len(skipped) <= 4, skipped


def test_modules_with_examples_are_found():
    names = modules_with_examples()
    assert len(names) > 5
