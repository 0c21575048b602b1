import pytest

from tests.multisrt.cli.commands import everything


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["exlpore", "office"], "there is no command 'exlpore' (did you mean 'explore'?)"),
        (["office"], "(did you mean 'multisrt explore office'?)"),
        (["room.wkt", "--seed", "1"], "(did you mean 'multisrt explore room.wkt --seed 1'?)"),
        (["help"], "(did you mean 'multisrt --help'?)"),
        (["help", "why"], "(did you mean 'multisrt why --help'?)"),
        (["version"], "(did you mean 'multisrt --version'?)"),
        (["show", "office"], "(did you mean 'multisrt environments show office'?)"),
        (["run", "a.toml"], "(did you mean 'multisrt experiment run a.toml'?)"),
        (["environments", "office"], "(did you mean 'multisrt environments show office'?)"),
        (["environments", "shwo", "office"], "(did you mean 'show'?)"),
        (["experiment", "star.toml"], "(did you mean 'multisrt experiment run star.toml'?)"),
        (["xyz"], "there is no command 'xyz'; see 'multisrt --help'"),
        (
            ["explore", "office", "--stratgy", "x"],
            "no option --stratgy (did you mean '--strategy'?)",
        ),
        (["explore", "office", "--limit", "5"], "no option --limit (did you mean '--max-time'?)"),
        (["explore", "office", "--duration", "5"], "(did you mean '--max-time'?)"),
        (["explore", "office", "--drive", "dubin"], "dubins (did you mean 'dubins'?)"),
        (["explore", "office", "--robots", "four"], "--robots: 'four' is not a whole number"),
        (["explore", "office", "--range", "far"], "--range: 'far' is not a number"),
        (
            ["explore", "office", "--start", "2.5", "4"],
            "too many words: 4; write X,Y and KEY=VALUE without a space",
        ),
        (["explore", "office", "--robot", "rnage=6"], "(did you mean 'range'?)"),
        (["explore", "run/spec.toml"], "did you mean --spec run/spec.toml?"),
        (["explore", "office", "--force"], "--force replaces the run in --out DIR"),
        (["explore", "office", "mine.py"], "mine.py (did you mean --strategy mine.py?)"),
        (["explore", "office", "--robot", "3"], "(did you mean --robots 3?)"),
        (["check", "museum"], "an environment, not a strategy: multisrt check STRATEGY --world mu"),
        (["compare", "museum"], "(did you mean 'multisrt experiment new FILE.toml'?)"),
        (["report", "ex.toml"], "its results are in ex.sqlite, which 'multisrt experiment run"),
        (["experiment", "run", "ex.sqlite"], "name the experiment instead, such as ex.toml"),
        (["explore"], "'multisrt environments' lists some"),
        (["strategies", "minpos", "greedy"], "too many words: greedy; see 'multisrt strategies"),
        (["report"], "RESULTS is missing; see 'multisrt report --help'"),
        (["experiment", "new", "star"], "FILE: star must have the suffix .toml"),
        (["completion", "fihs"], "'fihs' is not one of bash, zsh, fish (did you mean 'fish'?)"),
    ],
)
def test_a_mistake_is_told_with_what_was_meant(call, folder, words, said):
    before = everything(folder)
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert said in err
    assert everything(folder) == before


def test_no_command_at_all_shows_the_help(call):
    code, out, err = call()
    assert (code, out) == (2, "")
    assert err.startswith("Usage: multisrt")
    assert err.index("\n  explore ") < err.index("\n  report ")
