import re

import click
import msgspec

from multisrt import cli
from multisrt.spec import RadioSpec, RobotSpec, RunSpec, StopRule


def test_every_help_page_has_examples_and_fits_80_columns(call, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    commands = [[], *([name] for name in cli.cli.commands)]
    for name in ("experiment", "environments", "strategy"):
        group = cli.cli.commands[name]
        assert isinstance(group, click.Group)
        commands += [[name, below] for below in group.commands]
    for command in commands:
        code, out, err = call(*command, "--help")
        assert (code, err) == (0, "")
        assert "Usage: multisrt" in out
        assert "Examples" in out
        assert "..." not in out.partition("Commands:")[2].partition("Examples")[0]
        assert max(map(len, out.splitlines())) <= 80
    code, out, err = call("--version")
    assert (code, err) == (0, "")
    assert out.startswith("multisrt, version ")


def test_help_states_the_defaults_of_the_specs(call):
    _, out, _ = call("explore", "--help")
    stated = {}
    for entry in re.split(r"\n {2}(?=--)", out):
        text = " ".join(entry.split())
        if found := re.search(r"\[default: ([^\],]*)", text):
            stated[text.split()[0]] = found[1]
    robot = RobotSpec()
    defaults = {field.name: field.default for field in msgspec.structs.fields(RunSpec)}
    assert stated == {
        "--strategy": defaults["strategy"],
        "--seed": str(defaults["seed"]),
        "--max-time": f"{StopRule().max_time_s:g}",
        "--robots": str(len(defaults["robots"])),
        "--starts": defaults["starts"],
        "--range": f"{robot.range_finder.range_m:g}",
        "--beams": str(robot.range_finder.beams).lower(),
        "--footprint": robot.footprint,
        "--drive": robot.drive.kind,
        "--speed": f"{robot.drive.speed_m_s:g}",
        "--turning-radius": f"{robot.drive.turning_radius_m:g}",
        "--radio-range": str(RadioSpec().range_m).lower(),
        "--latency": f"{RadioSpec().latency_s:g}",
        "--jitter": f"{RadioSpec().jitter_s:g}",
        "--loss": f"{RadioSpec().loss:g}",
        "--walls": RadioSpec().walls,
        "--out": "runs/ENV-STRATEGY-SEED",
    }
