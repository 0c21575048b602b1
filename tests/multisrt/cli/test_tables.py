import pytest

from multisrt.cli.tables import show_blocks


@pytest.mark.parametrize(("width", "blocks"), [(24, 3), (30, 2), (80, 1)])
def test_columns_follow_below_where_they_do_not_fit(capsys, monkeypatch, width, blocks):
    monkeypatch.setattr("multisrt.terminal.WIDTH", width)
    show_blocks(["measure", ">first", ">second", ">third"], [("time", *3 * ["12.5 s"])])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= width
    assert sum("measure" in line for line in lines) == blocks
    assert sum(line.count("12.5 s") for line in lines) == 3
