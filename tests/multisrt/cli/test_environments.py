import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from multisrt.environments import environment, read_environment, suites
from multisrt.environments.catalog import names
from tests.multisrt.cli.commands import everything


def test_environments_lists_the_catalogue(call):
    code, out, err = call("environments")
    assert (code, err) == (0, "")
    assert all(re.search(rf"^ *{name} ", out, re.M) for name in names())


def test_environments_show_draws_a_map(call, folder):
    code, out, err = call("environments", "show", "office")
    assert (code, err) == (0, "")
    assert "parameters: " in out
    assert ET.parse(folder / "office.svg").getroot().tag.endswith("svg")
    code, out, _ = call("environments", "show", "pillar.wkt", "--out", "p.svg")
    assert code == 0
    assert "9 x 6 m, 50 m2 free, 8 edges, 1 part" in out
    assert (folder / "p.svg").exists()


def test_environments_show_draws_the_starts_of_a_team(call, folder):
    Image.new("L", (60, 40), 255).save(folder / "plan.png")
    (folder / "team.txt").write_text(
        "1 Base 3 3 0.0 0 200 1000 BaseStation 1 1\n2 A 9 19 0.0 100 200 1000 Explorer 1 1\n"
    )
    words = ("environments", "show", "plan.png", "--resolution", "0.1", "--out")
    assert call(*words, "plain.svg")[0] == 0
    assert call(*words, "team.svg", "--starts-from", "team.txt")[0] == 0
    plain, team = ((folder / name).read_text() for name in ("plain.svg", "team.svg"))
    assert (plain.count(">suggested start<"), team.count(">suggested start<")) == (0, 1)


@pytest.mark.parametrize("out", [".", "room.wkt/x.svg", "none/x.svg", "/"])
def test_environments_show_refuses_bad_paths(call, folder, out):
    before = everything(folder)
    code, _, err = call("environments", "show", "room.wkt", "--out", out)
    assert code == 2
    assert re.match("error: cannot write .*: (there is no folder|it is a folder)", err)
    assert err.count("\n") == 1
    assert everything(folder) == before


def test_a_picture_replaces_a_file_only_by_force(call, folder):
    (folder / "office.svg").write_text("mine")
    for words in (["office"], ["open", "--out", "office.svg"]):
        code, out, err = call("environments", "show", *words)
        assert (code, out) == (2, "")
        assert err == (
            "error: office.svg exists already: name another file, or replace it with --force\n"
        )
    assert (folder / "office.svg").read_text() == "mine"
    assert call("environments", "show", "office", "--force")[0] == 0
    assert (folder / "office.svg").read_text().startswith("<")


@pytest.mark.parametrize("suffix", [".geojson", ".wkt", ".yaml", ".svg", ".dxf", ".stl", ".glb"])
def test_environments_export_writes_maps(call, folder, suffix):
    code, out, err = call("environments", "export", "office", "--out", f"o{suffix}")
    assert (code, err) == (0, "")
    assert "office: " in out
    assert out.endswith(
        "written to o.yaml and o.pgm\n" if suffix == ".yaml" else f"written to o{suffix}\n"
    )
    assert (folder / f"o{suffix}").stat().st_size > 100
    code, out, err = call("environments", "export", "office", "--out", f"o{suffix}")
    assert (code, out) == (2, "")
    assert "exists already: name another file, or replace it with --force" in err
    words = "--force", "--quiet"
    assert call("environments", "export", "office", "--out", f"o{suffix}", *words) == (0, "", "")


def test_environments_export_keeps_world_and_starts(call, folder):
    call("environments", "export", "office", "--out", "o.geojson")
    assert read_environment(folder / "o.geojson").digest == environment("office").digest
    assert read_environment(folder / "o.geojson").starts == environment("office").starts
    call("environments", "export", "room.wkt", "--out", "grid.yaml", "--cell", "0.2")
    call("environments", "export", "grid.yaml", "--out", "again.wkt")
    found, given = (read_environment(folder / f"{name}.wkt") for name in ("again", "room"))
    assert found.free.symmetric_difference(given.free).area < 0.1 * given.free.length


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["office", "--out", "x.png"], "x.png: '.png' is no format of maps"),
        (["office"], "--out"),
        (["office", "--out", "x.wkt", "--cell", "0.1"], "--cell has no meaning for .wkt"),
        (["office", "--out", "x.yaml", "--height", "2"], "--height has no meaning for .yaml"),
        (
            ["office", "--out", "x.stl", "--height", "0"],
            "the height of walls must be 0.01 to 1000 m",
        ),
        (["office", "--out", "none/x.yaml"], "cannot write none/x.yaml: there is no folder none"),
        (["nowhere", "--out", "x.yaml"], "nowhere"),
        (["office", "--out", "."], "cannot write .: it is a folder; name a file"),
        (["room.wkt", "--out", "x.yaml", "--cell", "20"], "cells of 20 m are too wide for x.yaml"),
    ],
)
def test_environments_export_refuses_bad_input(call, folder, words, named):
    before = everything(folder)
    code, out, err = call("environments", "export", *words)
    assert (code, out) == (2, "")
    assert named in err
    assert err.count("\n") == 1
    assert everything(folder) == before


def test_environments_lists_suites_and_draws_their_worlds(call, folder):
    code, out, _ = call("environments")
    assert code == 0
    assert all(re.search(rf"^ *{name} +1 +30 ", out, re.M) for name in suites.names())
    code, out, err = call("environments", "show", "mazes-30/12")
    assert (code, err) == (0, "")
    assert "mazes-30/12: " in out
    assert (folder / "mazes-30-12.svg").exists()
    code, _, err = call("environments", "show", "mazes-30")
    assert code == 2
    assert "a suite of 30 worlds" in err
    assert "Traceback" not in err


def test_parameters_of_generators_are_set(call, folder):
    words = ("--set", "difficulty=0.8", "--set", "size_m=30", "--set", "seed=3")
    code, out, err = call("environments", "export", "dungeon", *words, "--out", "d.wkt")
    assert (code, err) == (0, "")
    made = environment("dungeon", difficulty=0.8, size_m=30, seed=3)
    assert read_environment(folder / "d.wkt").digest == made.digest
    assert (
        "parameters: size_m=40, difficulty=0.5, passage_m=1.4, seed=0 by default, set by "
        "--set NAME=VALUE\n" in out
    )
    plain = environment("office", furnished=False)
    code, out, _ = call("environments", "show", "office", "--set", "furnished=false")
    assert code == 0
    assert f"{plain.area_m2:.4g} m2 free, {len(plain.edges)} edges" in out
    assert "furnished=true" in out
    assert "; also difficulty, from 0 to 1\n" in out
    code, out, _ = call("environments", "check", "open", "--set", "size_m=12")
    assert code == 0
    assert "12 x 12 m" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["maze", "--set", "cell=9"], "maze has no parameter 'cell'; it takes seed and"),
        (["maze", "--set", "cells=many"], "maze: cells='many' is out of range; give a whole"),
        (["maze", "--set", "seed=x"], "maze: seed='x' is out of range"),
        (["maze", "--set", "cells"], "--set: 'cells' is not KEY=VALUE"),
        (["museum", "--set", "size_m=9"], "the bundled map 'museum' is fixed"),
        (["room.wkt", "--set", "size_m=9"], "'room.wkt' is a map file: parameters are for gen"),
        (["mazes-30/12", "--set", "seed=9"], "a world of a suite, which is fixed"),
    ],
)
def test_parameters_that_no_generator_takes_are_refused(call, folder, words, said):
    before = everything(folder)
    for command in (
        ("environments", "show"),
        ("environments", "check"),
        ("environments", "export", "--out", "x.wkt"),
        ("explore",),
    ):
        code, out, err = call(*command, *words)
        assert (code, out) == (2, "")
        assert said in err
        assert err.count("\n") == 1
    assert everything(folder) == before


def test_check_and_export_take_the_starts_of_a_team(call, folder):
    Image.new("L", (60, 40), 255).save(folder / "plan.png")
    (folder / "team.txt").write_text("2 A 9 19 0.0 100 200 1000 Explorer 1 1\n")
    words = ("plan.png", "--resolution", "0.1", "--starts-from", "team.txt")
    assert call("environments", "export", *words, "--out", "plan.geojson")[0] == 0
    (start,) = read_environment(folder / "plan.geojson").starts
    assert start == pytest.approx((0.95, 2.05))
    code, out, _ = call("environments", "check", *words, "--fix", "clean.geojson")
    assert code == 0
    assert "with all suggested starts" in out
    assert read_environment(folder / "clean.geojson").starts == (start,)


@pytest.mark.parametrize(
    ("world", "said"),
    [
        ("", "the name of the world is empty: name an environment or a map file"),
        ("https://example.org/a.png", "is an address, and maps are read from files: download it"),
        ("indor-30/07", "'indor-30/07', and no suite of that name (did you mean 'indoor-30'?)"),
        ("maze-30", "'maze-30', and no suite of that name (did you mean 'mazes-30'?)"),
        ("officee", "there is no environment 'officee' (did you mean 'office'?)"),
        ("maps/07", "maps/07 does not exist"),
        ("goal.scen", "line 2 names the map b.map, which is not in the folder of the map; copy it"),
    ],
)
def test_worlds_that_are_not_there_are_told_plainly(call, folder, world, said):
    (folder / "goal.scen").write_text("version 1\n0 b.map 3 2 0 1 1 0 1.4\n")
    options = ("--resolution", "1") if world == "goal.scen" else ()
    for command in (["environments", "show"], ["environments", "check"], ["explore"]):
        code, out, err = call(*command, world, *options)
        assert (code, out) == (2, "")
        assert said in err
        assert err.count("\n") == 1


def test_export_to_cells_tells_how_much_of_the_world_is_free_in_them(call, folder):
    code, out, _ = call("environments", "export", "pillar.wkt", "--out", "p.yaml", "--cell", "0.5")
    assert code == 0
    assert out.endswith("written to p.yaml and p.pgm\n")  # walls are at multiples of 0.5 m
    code, out, _ = call("environments", "export", "pillar.wkt", "--out", "q.yaml", "--cell", "0.8")
    assert code == 0
    levels = np.asarray(Image.open(folder / "q.pgm"))
    in_cells = 0.64 * np.count_nonzero(levels == 254)
    assert f"q.pgm, with {in_cells:.4g} m2 free in cells of 0.8 m (the world has 50 m2)\n" in out


def test_the_folder_of_a_run_is_told_from_a_map(call, folder):
    (folder / "my run").mkdir()
    (folder / "my run" / "recording.jsonl").write_text("")
    for command in (["environments", "export", "--out", "z.wkt"], ["explore"]):
        code, out, err = call(*command, "my run")
        assert (code, out) == (2, "")
        assert "'multisrt export 'my run' --what world --out world.geojson' writes" in err
        assert err.count("\n") == 1
