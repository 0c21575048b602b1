import pytest

from multisrt.cli.outputs import new_folder, require_no_file, require_no_run, run_folder
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.cli.commands import everything

RECORDED = '{"event":"header","format":"multisrt-recording"}\n'


@pytest.fixture
def run(tmp_path):
    """A folder with the files of a run, and one that is the user's own."""
    for name in ("tree.svg", "run.json", "spec.toml", "notes.txt"):
        (tmp_path / name).write_text("old")
    (tmp_path / "recording.jsonl").write_text(RECORDED)
    return tmp_path


def write(folder, *, force=False):
    with run_folder(folder, force=force) as opened:
        for name in ("tree.svg", "recording.jsonl"):
            (opened / name).write_text("new")


def test_a_new_folder_has_the_next_free_number(tmp_path):
    wanted = tmp_path / "office-0"
    assert new_folder(wanted) == wanted
    wanted.mkdir()
    assert new_folder(wanted).name == "office-0-2"
    (tmp_path / "office-0-2").symlink_to("nowhere")
    assert new_folder(wanted).name == "office-0-3"


def test_a_file_is_replaced_only_by_force(tmp_path):
    path = tmp_path / "a.svg"
    require_no_file(path, force=False)
    path.write_text("old")
    require_no_file(path, force=True)
    with pytest.raises(InvalidInputError, match=r"a\.svg exists already: .* --force"):
        require_no_file(path, force=False)


def test_force_replaces_the_files_of_a_run_and_no_others(run):
    before = everything(run)
    with pytest.raises(InvalidInputError, match="holds a run already"):
        write(run)
    assert everything(run) == before
    write(run, force=True)
    kept = {name: text for name, text in before.items() if name not in everything_new(run)}
    assert everything(run) == kept | everything_new(run)


def everything_new(folder):
    return {name: text for name, text in everything(folder).items() if text == b"new"}


def test_force_replaces_no_file_that_is_of_no_run(tmp_path):
    (tmp_path / "spec.toml").write_text("mine")
    for force in (False, True):
        with pytest.raises(
            InvalidInputError, match=r"spec\.toml exists already and does not belong"
        ):
            require_no_run(tmp_path, force=force)
    (tmp_path / "recording.jsonl").write_text("a song")
    with pytest.raises(InvalidInputError, match="does not belong to a run"):
        require_no_run(tmp_path, force=True)


def test_a_folder_with_other_files_takes_a_run(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    write(tmp_path)
    assert sorted(everything(tmp_path)) == ["notes.txt", "recording.jsonl", "tree.svg"]


def test_an_unfinished_run_is_removed_only_by_force(tmp_path):
    (tmp_path / "unfinished").mkdir()
    (tmp_path / "unfinished" / "recording.jsonl.part").write_text("half")
    with pytest.raises(InvalidInputError, match="killed or is still in progress"):
        write(tmp_path)
    write(tmp_path, force=True)
    assert sorted(everything(tmp_path)) == ["recording.jsonl", "tree.svg"]


def test_a_folder_of_the_same_name_is_never_removed(tmp_path):
    (tmp_path / "unfinished").mkdir()
    (tmp_path / "unfinished" / "novel.txt").write_text("chapter 1")
    for force in (False, True):
        with pytest.raises(InvalidInputError, match="does not belong to a run"):
            write(tmp_path, force=force)
    assert (tmp_path / "unfinished" / "novel.txt").read_text() == "chapter 1"


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["view", "out", "--no-open"], "replay.html"),
        (["animate", "out", "--duration", "1"], "animation.svg"),
        (["figure", "coverage", "out/recording.jsonl"], "coverage.pdf"),
        (["export", "out"], "run.mcap"),
    ],
)
def test_files_made_of_a_run_are_written_to_its_folder(call, folder, words, name):
    call("explore", "room.wkt", "--max-time", "5", "--out", "out", "--quiet")
    assert call(*words, "--quiet") == (0, "", "")
    assert (folder / "out" / name).is_file()
    assert not (folder / name).exists()
    code, _, err = call(*words)
    assert (code, err) == (
        2,
        f"error: out/{name} exists already: name another file, or replace it with --force\n",
    )
    assert call(*words, "--force", "--quiet") == (0, "", "")


def test_options_of_output_are_worded_alike(call):
    def said(option, *command):
        text = " ".join(call(*command, "--help")[1].partition(f"  {option}")[2].split())
        return text[: text.index(" --")]

    single = [said("--out", name) for name in ("animate", "export")]
    several = [said("--out", name) for name in ("view", "figure")]
    assert all(text.endswith("in the folder of the recording]") for text in single)
    assert all(text.endswith("in the folder of the first RECORDING]") for text in several)
    commands = "animate", "export", "view", "figure"
    assert {said("--force", name) for name in commands} == {"Replace FILE if it exists."}
    for name in commands:
        assert "--quiet" in call(name, "--help")[1]


def test_force_removes_what_was_made_of_the_old_run(call, folder):
    options = "room.wkt", "--max-time", "5", "--out", "out", "--quiet"
    call("explore", *options)
    for words in (["view", "out", "--no-open"], ["animate", "out"], ["export", "out"]):
        assert call(*words, "--quiet")[0] == 0
    (folder / "out" / "notes.txt").write_text("mine")
    call("explore", *options, "--seed", "1", "--force")
    assert sorted(path.name for path in (folder / "out").iterdir()) == [
        *("notes.txt", "recording.jsonl", "run.json", "spec.toml", "tree.svg"),
    ]


def test_force_keeps_files_of_others_with_usual_names(call, folder):
    options = "room.wkt", "--max-time", "5", "--out", "out", "--quiet"
    call("explore", *options)
    names = "replay.html", "animation.svg", "run.mcap"
    for name in names:
        (folder / "out" / name).write_text("<svg>mine")
    call("explore", *options, "--force")
    assert all((folder / "out" / name).read_text() == "<svg>mine" for name in names)


def test_a_page_of_several_runs_goes_with_them(call, folder):
    options = (
        *("room.wkt", "--max-time", "5", "--out", "out", "--quiet", "--no-open"),
        *("--strategy", "closest", "--strategy", "minpos"),
    )
    call("explore", *options, "--view")
    assert (folder / "out/replay.html").exists()
    call("explore", *options[:-5], "--force", *options[-4:])
    assert not (folder / "out/replay.html").exists()
    call("explore", *options, "--live")
    call("explore", *options, "--live", "--force")
    assert (folder / "out/replay.html").exists()
