from pathlib import Path

import pytest

from benchmarks import against


@pytest.mark.slow
def test_a_version_does_the_same_as_itself(monkeypatch):
    monkeypatch.setattr(against, "WORLD", "open")
    monkeypatch.setattr(against, "ROBOTS", 2)
    line = against.compare(against.HERE, "closest", seeds=2, limit_s=4.0, rounds=1)
    strategy, *figures, _, _ = line.split()
    assert strategy == "closest"
    old_s, new_s, times, old_end_s, new_end_s, _ = map(float, figures)
    assert min(old_s, new_s, times) > 0.0
    assert old_end_s == new_end_s == 4.0
    assert line.endswith("the same")


def test_a_folder_without_the_library_is_refused(tmp_path: Path, capsys):
    with pytest.raises(SystemExit):
        against.main([str(tmp_path)])
    assert f"{tmp_path} holds no multisrt" in capsys.readouterr().err


def test_what_a_version_does_not_run_is_told(tmp_path: Path):
    package = tmp_path / "multisrt"
    package.mkdir()
    (package / "__init__.py").write_text("")
    with pytest.raises(SystemExit, match="does not run closest"):
        against.mission_cost(tmp_path, "closest", 1, 1.0)
