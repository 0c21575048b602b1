import ast
import inspect

import pytest

import multisrt as ms
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.loading import load_strategy
from multisrt.robots.strategy import as_strategy
from multisrt.robots.toolkit.templates import SIZES, explorer, planner, rule, template
from multisrt.testing import check_explorer, two_rooms

STRATEGIES = {
    "rule": as_strategy(rule.mine),
    "planner": as_strategy(planner.Mine),
    "explorer": as_strategy(explorer.Mine),
}
COARSE: dict[str, dict[str, float]] = {
    "rule": {"sense_period_s": 2.0, "replan_period_s": 2.0, "cell_m": 0.2},
    "planner": {},
    "explorer": {"leg_s": 2.0},
}
"""Fewer scans than by default, so that a museum takes seconds."""


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(("world", "robots"), [("museum", 1), ("apartment", 3)])
def test_templates_cover_bundled_worlds_without_collision(size, world, robots):
    options = COARSE[size] if world == "museum" else {}
    run = ms.explore(world, strategy=STRATEGIES[size], robots=robots, seed=1, options=options)
    assert run.metrics.coverage >= 0.95
    assert run.metrics.collisions == 0
    assert (run.metrics.decisions > 0) == (size != "rule")
    assert run.outcome == "complete"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_planners_do_not_box_each_other_in(seed):
    run = ms.explore("apartment", strategy=STRATEGIES["planner"], robots=3, seed=seed)
    assert run.outcome == "complete", run.reason
    assert run.metrics.coverage > 0.98
    assert run.metrics.makespan_s < 220.0


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
def test_templates_keep_to_the_contract(size):
    checked = check_explorer(STRATEGIES[size], worlds=[two_rooms()])
    assert {run.outcome for run in checked.runs} == {"complete"}


@pytest.mark.parametrize("size", SIZES)
def test_templates_are_short_and_explain_themselves(size):
    module = {"rule": rule, "planner": planner, "explorer": explorer}[size]
    tree = ast.parse(inspect.getsource(module))
    told = {
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        for line in range(node.lineno, (node.end_lineno or 0) + 1)
    }
    lines = [
        line
        for number, line in enumerate(inspect.getsource(module).splitlines(), 1)
        if line.strip() and not line.strip().startswith("#") and number not in told
    ]
    assert len(lines) < {"rule": 25, "planner": 40, "explorer": 100}[size]
    assert "multisrt check mine.py" in (module.__doc__ or "")


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", ["nearest-door", "nearest_door", "NearestDoor"])
def test_a_template_is_written_under_any_name(tmp_path, size, name):
    path = tmp_path / "doors.py"
    path.write_text(template(size, name, "doors.py"))
    assert load_strategy(str(path)).name == "nearest-door"
    text = path.read_text()
    assert "mine" not in text.lower()
    assert "multisrt explore museum --strategy doors.py" in text


@pytest.mark.parametrize(
    ("size", "name", "told"),
    [
        ("planer", "mine", "there is no size 'planer' (did you mean 'planner'?)"),
        ("rule", "2nd", "cannot be called '2nd'"),
        ("rule", "class", "cannot be called 'class'"),
        ("rule", "über", "cannot be called 'über'"),
        ("rule", "a.b", "cannot be called 'a.b'"),
        ("rule", "MinPos", None),
        ("rule", "minpos", "there is a strategy 'minpos' already"),
    ],
)
def test_names_that_cannot_be_are_refused(size, name, told):
    if told is None:
        assert "def min_pos(" in template(size, name, "x.py")
        return
    with pytest.raises(InvalidInputError) as error:
        template(size, name, "x.py")
    assert told in str(error.value)
