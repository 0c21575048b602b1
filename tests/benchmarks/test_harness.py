from collections.abc import Iterator

import pytest

from benchmarks.__main__ import main
from benchmarks.harness import Claim, show
from benchmarks.yardstick import yardstick, yardstick_s


def faster() -> Iterator[Claim | str]:
    yield Claim(text="as fast as wanted", ours=1.0, theirs=12.0, at_least=12.0)
    yield "a line that is no claim"


def slower() -> Iterator[Claim]:
    yield Claim(text="too slow", ours=1.0, theirs=11.9, at_least=12.0)
    yield Claim(text="too large", ours=2.1, theirs=1.0, unit="MB", at_most=2.0)
    yield Claim(text="wrong", ours=1.0, theirs=1.0, at_most=2.0, holds=False)


def broken() -> Iterator[Claim]:
    yield Claim(text="before the error", ours=1.0, theirs=1.0, at_most=1.0)
    raise RuntimeError("no such kernel")


def test_every_claim_has_a_line_met_or_not(capsys):
    show({"faster": faster, "slower": slower})
    lines = capsys.readouterr().out.splitlines()
    verdicts = {line[:20].strip(): line.split()[-1] for line in lines[1:6]}
    assert verdicts["as fast as wanted"] == "met"
    assert verdicts["a line that is no cl"] == "claim"
    for text in ("too slow", "too large", "wrong"):
        assert verdicts[text] == "MET"
        assert f"{text:60}" in "\n".join(lines)
    assert sum("NOT MET" in line for line in lines) == 3
    assert lines[-1] == "1 of 4 targets are met"


def test_an_error_is_a_line_and_the_next_benchmark_runs(capsys):
    show({"broken": broken, "faster": faster})
    out = capsys.readouterr().out
    assert "before the error" in out
    assert "ERROR: RuntimeError: no such kernel" in out
    assert "as fast as wanted" in out
    assert out.splitlines()[-1] == "2 of 2 targets are met; benchmarks that failed: 1"


@pytest.mark.parametrize(
    ("claim", "ratio"),
    [
        (Claim(text="", ours=2.0, theirs=6.0, at_least=1.0), 3.0),
        (Claim(text="", ours=2.0, theirs=8.0, at_most=1.0), 0.25),
        (Claim(text="", ours=2.0, theirs=0.0, at_most=1.0), float("inf")),
    ],
)
def test_the_ratio_is_what_the_target_bounds(claim, ratio):
    assert claim.ratio == ratio


def test_a_yardstick_takes_time_and_goes_on_through_memory():
    first = yardstick()
    assert yardstick(0) == first != yardstick(first)
    assert 0.0 < yardstick_s() < 60.0


def test_parts_of_the_table_are_named(capsys):
    with pytest.raises(SystemExit):
        main(["lerning"])
    assert "no part 'lerning'; there are: kernels" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "claim" not in capsys.readouterr().out
