import pytest

from multisrt.analysis.isolation import isolation
from multisrt.analysis.radio_links import radio_links
from multisrt.events import CameBack, Died, FellSilent
from multisrt.simulation.simulate import simulate
from multisrt.spec import CatalogEnvironment, RadioSpec, RobotSpec, RunSpec, StopRule
from tests.multisrt.drawing.recordings import motion, recorded

NEAR, FAR = (2.0, 4.0), (6.0, 4.0)


def team(*events, range_m=3.0, starts=(NEAR, FAR)):
    return recorded(starts, events, radio=RadioSpec(range_m=range_m))


def test_a_link_holds_within_range():
    recording = team(motion(10.0, 1, FAR, (4.0, 4.0)), motion(20.0, 1, (4.0, 4.0), FAR))
    (spell,) = radio_links(recording)[0, 1]
    assert spell == pytest.approx((10.5, 20.5))  # at 2 m/s


def test_robots_out_of_range_have_no_link():
    assert radio_links(team()) == {}


def test_a_silent_radio_has_no_link():
    recording = team(FellSilent(time_s=5.0, robot=0), CameBack(time_s=7.0, robot=0), range_m=9.0)
    assert radio_links(recording) == {(0, 1): ((0.0, 5.0), (7.0, 100.0))}


def test_a_dead_robot_has_no_link():
    died = Died(time_s=30.0, robot=1, configuration=(*FAR, 0.0), doing="waiting")
    assert radio_links(team(died, range_m=9.0)) == {(0, 1): ((0.0, 30.0),)}


def test_a_robot_alone_has_no_link():
    assert radio_links(recorded([NEAR], [])) == {}


def test_a_radio_without_a_range_reaches_all():
    recording = recorded([NEAR, FAR, (9.0, 4.0)], [FellSilent(time_s=5.0, robot=2)])
    assert radio_links(recording) == {
        (0, 1): ((0.0, 100.0),),
        (0, 2): ((0.0, 5.0),),
        (1, 2): ((0.0, 5.0),),
    }


@pytest.mark.slow
@pytest.mark.parametrize("walls", ["pass", "block"])
def test_a_robot_is_isolated_while_it_has_no_link(walls):
    spec = RunSpec(
        environment=CatalogEnvironment(name="apartment"),
        robots=(RobotSpec(),) * 3,
        strategy="minpos",
        radio=RadioSpec(range_m=5.0, walls=walls),
        stop=StopRule(max_time_s=20.0),
        seed=2,
    )
    recording = simulate(spec)
    links, end_s = radio_links(recording), recording.footer.time_s
    for robot, isolated in enumerate(isolation(recording)):
        linked = [spell for pair, own in links.items() if robot in pair for spell in own]
        assert isolated.spells or linked
        for begin, end in isolated.spells:
            assert not any(a < end - 1e-5 and b > begin + 1e-5 for a, b in linked)
            assert end == end_s or any(abs(a - end) < 1e-5 for a, _ in linked)
