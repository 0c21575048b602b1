"""Names in the code of explorers that lead round the contract."""

import logging
import operator
import sys as system
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import multisrt as ms
from multisrt.robots.explorer import Sense
from multisrt.robots.policy import DecisionSpec, policy_strategy
from multisrt.robots.toolkit import assignment
from multisrt.testing.code_reading import names_in_code
from multisrt.testing.own_code import back_door, outside_in
from tests.multisrt.testing.explorers import WORLD, Base, check, explorer, refused


def acting(act) -> Any:  # untyped, as classes are not hashable to mypy
    return explorer(act)


def by_text(self):
    yield Sense()
    getattr(ms, "environment")("open")  # noqa: B009


def by_a_module_in_a_variable(self):
    module = ms
    yield Sense()
    vars(module)["environment"]("open")


def by_the_table_of_a_module(self):
    yield Sense()
    ms.__dict__["environment"]("open")


def by_another_name_of_sys(self):
    yield Sense()
    system.modules["multisrt.environments.catalog"].environment("open")


def by_its_own_globals(self):
    yield Sense()
    globals()["ms"].environment("open")


def by_importing(self):
    yield Sense()
    from importlib import import_module

    import_module("multisrt.environments.catalog")


def by_a_module_imported_by_its_full_name(self):
    import multisrt.robots

    yield Sense()
    vars(multisrt)["environment"]("open")


def by_a_module_of_several_in_variables(self):
    numbers, module = np, ms
    yield Sense()
    getattr(module, "environment")(numbers.hypot(1.0, 2.0))  # noqa: B009


def by_an_attribute_getter(self):
    yield Sense()
    attrgetter("environment")(ms)("open")


def by_a_function_that_is_given_a_module(self):
    yield Sense()
    list(map(getattr, [ms], ["environment"]))


def by_another_name_of_a_function(self):
    look_up = operator.attrgetter("environment")
    yield Sense()
    look_up(ms)("open")


def by_the_globals_of_a_function(self):
    yield Sense()
    by_text.__globals__["ms"].environment("open")


def by_the_text_of_a_frame(self):
    yield Sense()
    attrgetter("gi_frame.f_back.f_locals")(self.actions)


@pytest.mark.parametrize(
    ("act", "name"),
    [
        (by_an_attribute_getter, "ms as an argument"),
        (by_a_function_that_is_given_a_module, "getattr(ms)"),
        (by_another_name_of_a_function, "ms as an argument"),
        (by_the_globals_of_a_function, ".__globals__"),
        (by_the_text_of_a_frame, ".gi_frame.f_back.f_locals"),
        (by_text, "getattr(ms)"),
        (by_a_module_in_a_variable, "vars(module)"),
        (by_a_module_imported_by_its_full_name, "vars(multisrt)"),
        (by_a_module_of_several_in_variables, "getattr(module)"),
        (by_the_table_of_a_module, "ms.__dict__"),
        (by_another_name_of_sys, "system.modules"),
        (by_its_own_globals, "globals"),
        (by_importing, "import of importlib"),
    ],
)
def test_a_name_that_leads_to_the_truth_by_text(act, name):
    assert back_door(acting(act)).startswith(f"{name} (test_own_code.py:")


def test_attributes_of_what_an_explorer_holds_may_go_by_text():
    def act(self):
        yield Sense()
        getattr(self, "at")  # noqa: B009
        vars(self)["at"]
        sorted([self], key=attrgetter("at.x"))
        numbers = np
        numbers.asarray(self.at, dtype=ms.RobotSpec)
        np.hypot(1.0, 2.0)

    assert not back_door(acting(act))


def by_open(self):
    yield Sense()
    with open(__file__) as file:
        file.read()


def by_a_path(self):
    yield Sense()
    Path(__file__).read_text()


def by_a_path_that_it_holds(self):
    yield Sense()
    self.path.read_text()


def by_opening_a_path_that_it_holds(self):
    yield Sense()
    with self.path.open("a") as log:
        log.write("sensed")


def by_a_program(self):
    import subprocess

    yield Sense()
    subprocess.run(["ls"], check=True)


@pytest.mark.parametrize(
    ("act", "name"),
    [
        (by_open, "open"),
        (by_a_path, "Path"),
        (by_a_path_that_it_holds, ".read_text"),
        (by_opening_a_path_that_it_holds, ".open"),
        (by_a_program, "import of subp"),
    ],
)
def test_an_explorer_that_reads_files_while_it_runs(act, name):
    assert outside_in(acting(act)).startswith(name)
    refused(explorer(act), f"names {name}.*test_own_code.py.*could read files while it runs")


def test_an_explorer_may_have_doors_that_it_opens_and_a_list_of_open_nodes():
    class Door:
        def open(self):
            return True

    class Opens(Base):
        def act(self):
            self.open = [self.at]
            self.open.append(self.door().open())
            yield Sense()

        def door(self):
            return Door()

    opens: Any = Opens
    assert not outside_in(opens)


def test_an_explorer_may_log_while_it_runs():
    class Logs(Base):
        def __init__(self, me):
            super().__init__(me)
            self.log = logging.getLogger("own")

        def act(self):
            scan = yield Sense()
            self.log.info("robot %d sensed at %g s", self.me.robot, scan.time_s)
            LOG.warning("it is so %s", scan)

    check(Logs)


def test_all_names_of_an_import_in_a_function_are_read():
    def act(self):
        from multisrt.environments.catalog import environment, names

        yield Sense()
        environment(names()[0])

    named = {name for name, *_ in names_in_code(act.__code__, globals())}
    places = {f"import of multisrt.environments.catalog.{n}" for n in ("names", "environment")}
    assert places < named


def test_names_of_modules_that_a_function_imports():
    def act(self):
        import multisrt.robots
        import multisrt.robots.toolkit as kit

        one, other = kit, ms
        yield one.assignment, other.environment, multisrt.environment, multisrt.robots.toolkit
        if (again := ms) is not None:
            yield again.RunSpec

    named = {name: value for name, value, *_ in names_in_code(act.__code__, globals())}
    assert named["import of multisrt.robots.toolkit"] is system.modules["multisrt.robots.toolkit"]
    assert named["one.assignment"] is assignment
    assert named["other.environment"] is named["multisrt.environment"] is ms.environment
    assert named["multisrt.robots.toolkit"] is system.modules["multisrt.robots.toolkit"]
    assert named["again.RunSpec"] is ms.RunSpec


def test_names_of_relative_imports():
    home: dict[str, Any] = {"__package__": "multisrt.robots"}
    exec("def act():\n    from . import policy\n    from ..testing import check\n", home)
    named = {name: value for name, value, *_ in names_in_code(home["act"].__code__, home)}
    assert named["import of multisrt.robots.policy"] is system.modules["multisrt.robots.policy"]
    assert named["import of multisrt.testing.check"] is ms.testing.check


def test_a_module_in_a_tuple_that_is_taken_apart_is_no_argument():
    def act(self):
        yield Sense()
        numbers, library = np, ms
        return numbers.hypot(1.0, 2.0), library.RobotSpec

    assert not back_door(acting(act))


def test_weights_may_be_read_where_an_explorer_is_built():
    class Trained(Base):
        def __init__(self, me):
            super().__init__(me)
            self.weights = self.load()

        def load(self):
            return Path(__file__).read_bytes()

        def act(self):
            self.score = len(self.weights)
            yield Sense()

    class Reloading(Trained):
        def act(self):
            self.load()
            yield Sense()

    trained: Any = Trained
    reloading: Any = Reloading
    assert not outside_in(trained)
    assert outside_in(reloading).startswith("Path (test_own_code.py:")
    check(Trained, repeat_in_process=False)


def knows_the_map(observation):
    return int(ms.environment("open").free.area) * 0


class Peeking:
    def __call__(self, observation):
        return self.choose(observation)

    def choose(self, observation):
        return knows_the_map(observation)


@pytest.mark.parametrize(
    "policy", [knows_the_map, Peeking(), Peeking().choose, lambda seen: knows_the_map(seen)]
)
def test_a_policy_that_knows_the_map(policy):
    strategy = policy_strategy("knows-the-map", policy, DecisionSpec(observe=()))
    refused(strategy, r"ms\.environment is multisrt\.environments\.catalog\.environment")


def test_a_rule_of_assignment_that_knows_the_map():
    @assignment
    def peek(costs, robot):
        return costs[robot].argmin() if ms.environment("open").free.area else None

    refused(peek, r"ms\.environment is multisrt\.environments\.catalog\.environment")


@pytest.mark.slow
def test_a_policy_that_counts_its_calls():
    def count(observation):
        CALLS.append(1)
        return int(len(CALLS) > 2)

    strategy = policy_strategy("counts", count, DecisionSpec(observe=()))
    changes = "global 'CALLS' changes, which explorers share"
    refused(strategy, changes, world=WORLD, start=(10.4, 4.2))


CALLS: list[int] = []

LOG = logging.getLogger(__name__)
