import re

from multisrt.robots.registry import strategies


def test_strategies_lists_names_and_options(call):
    code, out, err = call("strategies")
    assert (code, err) == (0, "")
    assert all(known.name in out for known in strategies())
    # The strategy that sees the truth says so.
    assert [line.split()[0] for line in out.splitlines() if "sees the map" in line] == ["informed"]
    code, out, err = call("strategies", "srt-star")
    assert (code, err) == (0, "")
    for option, default in (("alpha", "0.8"), ("cones", "16"), ("approach", "true")):
        assert re.search(rf"{option} +{default} +\w", out)
    text = " ".join(out.split())
    assert "need a base station. Values: in-time, never, worth." in text
    assert "`HomeOptions`" not in text
    assert "Values: true" not in text
    code, _, err = call("strategies", "srt-square")
    assert code == 2
    assert err.count("\n") == 1


def test_own_options_come_before_inherited_ones(call):
    _, out, _ = call("strategies", "utility")
    assert [line.split()[0] for line in out.splitlines()[4:] if re.match(r" \w", line)][:3] == [
        "replan",
        "beta",
        "overlap_ranges",
    ]
    assert "As above" not in out
    assert "in the paper a robot asks for a goal" in " ".join(out.split())


def test_show_is_understood_and_the_list_says_how_options_are_listed(call):
    code, out, _ = call("strategies")
    assert code == 0
    assert out.endswith("next: multisrt strategies minpos  (the options of one)\n")
    assert call("strategies", "show", "minpos") == call("strategies", "minpos")
    for words in (["show"], ["minpos", "closest"]):
        code, _, err = call("strategies", *words)
        assert code == 2
        assert "name one strategy" in err
