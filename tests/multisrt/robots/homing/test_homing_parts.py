"""The parts that deliver data: time, places of contact, the delivered share, and pairs."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.robots.homing.contact import RANGE_MARGIN_M, ContactPlaces
from multisrt.robots.homing.delivered_share import DeliveredShare
from multisrt.robots.homing.just_in_time import JustInTime
from multisrt.robots.homing.options import HomingOptions, require_home
from multisrt.robots.homing.pairs import Pair, Rendezvous, RendezvousMessage, Role, Stage
from multisrt.robots.knowledge import Entries
from multisrt.robots.registry import strategy
from multisrt.robots.robot_self import RadioSelf, RobotSelf
from multisrt.spec import BaseSpec, CatalogEnvironment, RobotSpec, RunSpec


def self_with(**changes):
    known: dict[str, Any] = {
        "robot": 0,
        "start": Configuration(1.0, 1.0, 0.0),
        "footprint": Footprint.disc(0.25),
        "kinematics": Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2),
        "range_m": 4.0,
        "rng": np.random.default_rng(0),
        "base": (1.0, 1.0),
        "radio": RadioSelf(range_m=3.0, reaches_all=False),
        "limit_s": 100.0,
    }
    return RobotSelf(**known | changes)


# Just in time ------------------------------------------------------------------------------------


def test_a_path_takes_longer_by_the_margin_and_half_a_turn():
    time = JustInTime.of(self_with(), HomingOptions(home_margin=0.5, home_reserve_s=7.0))
    # 6 m at 0.5 m/s are 12 s, half of that is 6 s, half a turn at 90 degrees a second 2 s.
    assert time.travel_time_s(6.0) == 20.0
    assert time.slack_s(70.0, 6.0) == 100.0 - 70.0 - 20.0 - 7.0


def test_the_delivery_takes_four_messages():
    radio = RadioSelf(range_m=3.0, latency_s=0.5)
    assert JustInTime.of(self_with(radio=radio), HomingOptions()).reserve_s == 12.0


@pytest.mark.parametrize(
    ("drive", "half_turn_s"),
    [
        (Holonomic(speed_m_s=0.5), 0.0),
        (Car(speed_m_s=0.5, turning_radius_m=1.0), 2.0 * math.pi),
    ],
)
def test_half_a_turn_is_that_of_the_drive(drive, half_turn_s):
    time = JustInTime.of(self_with(kinematics=drive), HomingOptions())
    assert time.half_turn_s == pytest.approx(half_turn_s)


def test_a_limit_too_short_from_the_start_is_refused():
    # 13 m less 3 m of radio: 20 s, and 5 s; half a turn 2 s; 10 s in reserve: 37 s.
    far = {"start": Configuration(14.0, 1.0, 0.0)}
    assert JustInTime.of(self_with(**far, limit_s=37.0), HomingOptions()).limit_s == 37.0
    with pytest.raises(InvalidInputError, match=r"36\.9 s is too short.* of at least 37 s") as told:
        JustInTime.of(self_with(**far, limit_s=36.9), HomingOptions())
    assert "\n" not in str(told.value)
    # A robot that begins late has less time.
    with pytest.raises(InvalidInputError, match=r"begins at 5 s.* of at least 42 s"):
        JustInTime.of(self_with(**far, limit_s=37.0, time_s=5.0), HomingOptions())


@pytest.mark.parametrize(
    "wrong",
    [
        {"home_margin": -0.1},
        {"home_reserve_s": math.inf},
        {"home_ratio": 1.0},
        {"home_ratio": 0.0},
        {"home_wait_s": 0.0},
        {"home_period_s": math.nan},
    ],
)
def test_invalid_options_are_refused(wrong):
    with pytest.raises(InvalidInputError, match=next(iter(wrong))):
        HomingOptions(**wrong)


BASE = BaseSpec(x=1.0, y=1.0)


def run_of(home, *, robots=2, base=BASE, name="minpos"):
    return RunSpec(
        environment=CatalogEnvironment(name="open"),
        strategy=name,
        options={} if home is None else {"home": home},
        robots=(RobotSpec(),) * robots,
        base=base,
    )


def test_news_need_a_base_station_and_relays_a_pair():
    for home in (None, "never"):
        strategy("minpos").require_fit(run_of(home, base=None))
    for home in ("in-time", "worth", "relays"):
        strategy("minpos").require_fit(run_of(home))
        with pytest.raises(InvalidInputError, match=f"home='{home}' of minpos needs a base"):
            strategy("minpos").require_fit(run_of(home, base=None))
    with pytest.raises(InvalidInputError, match="needs pairs of robots"):
        strategy("minpos").require_fit(run_of("relays", robots=1))


def test_options_of_others_by_the_same_name_are_passed_over():
    class Own(msgspec.Struct, frozen=True, kw_only=True):
        home: str = "x"

    require_home(run_of(None, base=None), Own, {"home": "in-time"})


# Places of contact -------------------------------------------------------------------------------


def nodes_at(rectangle_node, *spans):
    entries = Entries()
    for serial, (x0, x1) in enumerate(spans):
        entries.add_node(rectangle_node(serial, x0, 0.0, x1, 2.0, "left right"))
    return entries


def places_of(contact):
    return [node.configuration[:2] for node in contact.nodes.values()]


def test_contact_is_within_range_where_walls_do_not_matter(rectangle_node):
    # Nodes are in the middle of their regions: at x = 2, 3.9 and 4.1, and the base at x = 1.
    entries = nodes_at(rectangle_node, (0.0, 4.0), (3.0, 4.8), (3.2, 5.0))
    contact = ContactPlaces(self_with())
    assert contact.update(entries)
    assert places_of(contact) == [(2.0, 1.0), (3.9, 1.0)]
    assert not contact.update(entries)
    assert contact.certainly_in_range(1.0, 4.0 - RANGE_MARGIN_M)
    assert not contact.certainly_in_range(1.0, 4.0)


def test_behind_walls_the_base_must_lie_in_the_region(rectangle_node):
    entries = nodes_at(rectangle_node, (0.0, 4.0), (3.0, 4.8))
    contact = ContactPlaces(self_with(radio=RadioSelf(range_m=3.0, walls_matter=True)))
    contact.update(entries)
    assert places_of(contact) == [(2.0, 1.0)]
    assert not contact.certainly_in_range(1.0, 1.0)


def test_beside_a_node_contact_is_not_taken_for_granted(rectangle_node):
    # The region is x from 0 to 4 and y from 0 to 2, with the base station in it.
    [node] = nodes_at(rectangle_node, (0.0, 4.0)).nodes.values()
    open_, walls = (
        ContactPlaces(self_with(radio=RadioSelf(range_m=1.5, walls_matter=matter)))
        for matter in (False, True)
    )
    x, y = open_.base
    inside, too_far, behind = (x + 1.4, y), (x + 1.46, y), (x, y + 1.2)
    assert [open_.is_certain_beside(node, at) for at in (inside, too_far, behind)] == [1, 0, 1]
    assert [walls.is_certain_beside(node, at) for at in (inside, too_far, behind)] == [1, 0, 0]


# The delivered share -----------------------------------------------------------------------------


def test_the_delivered_share_is_by_area_and_not_by_count(rectangle_node):
    # Regions of 4 m2, 4 m2 of which half is known, and 12 m2.
    entries = nodes_at(rectangle_node, (0.0, 2.0), (1.0, 3.0), (3.0, 9.0))
    raster = Occupancy(0.1, 0.25)
    for node in entries.nodes.values():
        raster.add(node.region)
    delivered = DeliveredShare(entries, raster)

    def cells(length_m):
        # Walls take the lowest and the highest row of cells, of 20, or one of them.
        return delivered.delivered_m2({0: (length_m, 0)})

    first, second, third = cells(1), cells(2), cells(3)
    assert second / first == pytest.approx(1.5, rel=0.05)
    assert third / first == pytest.approx(4.5, rel=0.05)
    assert DeliveredShare(entries, raster).share({0: (2, 0)}) == pytest.approx(1.0 / 3.0, abs=0.02)
    assert DeliveredShare(entries, raster).share({}) == 0.0
    assert DeliveredShare(entries, raster).share({0: (3, 0), 1: (5, 0)}) == 1.0
    beyond = ((0, 0, 2), (0, 1, 1), (7, 0, 2))
    assert DeliveredShare(entries, raster).share({0: (2, 0)}, beyond) == 1.0


def test_nodes_that_this_robot_lacks_count_once_it_has_them(rectangle_node):
    entries = nodes_at(rectangle_node, (0.0, 2.0))
    delivered = DeliveredShare(entries, Occupancy(0.1, 0.25))
    before = delivered.delivered_m2({0: (2, 0)})
    entries.add_node(rectangle_node(1, 2.0, 0.0, 4.0, 2.0, "left right"))
    assert delivered.delivered_m2({0: (2, 0)}) == pytest.approx(2.0 * before, rel=0.05)


# Pairs -------------------------------------------------------------------------------------------


def pair_of(number, team=2):
    return Pair(number, team, base=(1.0, 1.0), period_s=60.0, now_s=0.0)


def test_a_pair_agrees_on_the_next_place_with_the_last_as_backup():
    explorer, relay = pair_of(0), pair_of(1)
    relay.knows_home = lambda: True
    for k, place in enumerate([(9.0, 1.0), (20.0, 1.0)], start=1):
        relay.set_out()
        assert relay.take_ready_turn(10.0 * k, 0.5)
        proposal = explorer.propose(place, 10.0 * k, 100.0, (), 0)
        assert not explorer.accepted
        relay.accept(proposal)
        answer = RendezvousMessage(sender=1, rendezvous=proposal.rendezvous, have=(), accepts=True)
        explorer.take_acceptance(answer)
        assert explorer.accepted
        assert explorer.rendezvous == relay.rendezvous
        assert explorer.stage is relay.stage is Stage.UNTIL_DUE
    assert relay.rendezvous == Rendezvous(
        number=2, place=(20.0, 1.0), backup=(9.0, 1.0), due_s=120.0
    )
    # However near the place is, the time is not before the period is over.
    assert explorer.propose((2.0, 1.0), 30.0, 5.0, (), 0).rendezvous.due_s == 90.0


def test_who_waits_in_vain_goes_to_the_backup_and_then_continues_alone():
    explorer = pair_of(0)
    proposal = explorer.propose((9.0, 1.0), 0.0, 0.0, (), 0)
    explorer.take_acceptance(
        RendezvousMessage(sender=1, rendezvous=proposal.rendezvous, have=(), accepts=True)
    )
    explorer.set_out()
    assert explorer.target() == (9.0, 1.0)
    explorer.note_missed()
    assert (explorer.stage, explorer.target()) == (Stage.BACKUP, (1.0, 1.0))
    explorer.note_missed()
    assert explorer.role is Role.ALONE
    # Where the place is the backup, as at first, there is no second wait.
    relay = pair_of(1)
    relay.note_missed()
    assert relay.role is Role.ALONE


def test_an_answer_to_another_proposal_is_passed_over():
    explorer = pair_of(0)
    first = explorer.propose((9.0, 1.0), 0.0, 0.0, (), 0)
    explorer.propose((12.0, 1.0), 1.0, 0.0, (), 0)
    explorer.take_acceptance(
        RendezvousMessage(sender=1, rendezvous=first.rendezvous, have=(), accepts=True)
    )
    assert not explorer.accepted
    assert explorer.rendezvous.number == 0


def test_a_relay_accepts_once_and_never_an_older_rendezvous():
    relay, explorer = pair_of(1), pair_of(0)
    first = explorer.propose((9.0, 1.0), 0.0, 0.0, (), 0)
    relay.accept(first)
    relay.set_out()
    relay.accept(first)
    # Heard again: the relay is on its way already.
    assert relay.stage is Stage.PLACE
    assert relay.rendezvous == first.rendezvous


def answer_to(proposal):
    return RendezvousMessage(sender=1, rendezvous=proposal.rendezvous, have=(), accepts=True)


def test_a_lost_acceptance_leaves_no_two_rendezvous():
    explorer, relay = pair_of(0), pair_of(1)
    assert relay.accept(explorer.propose((9.0, 1.0), 0.0, 0.0, (), 0))
    # The explorer did not hear that, and proposes another place when they meet again.
    second = explorer.propose((1.0, 20.0), 90.0, 0.0, (), 0)
    assert relay.accept(second)
    explorer.take_acceptance(answer_to(second))
    assert explorer.rendezvous == relay.rendezvous == second.rendezvous


def test_a_proposal_that_comes_late_is_not_accepted():
    explorer, relay = pair_of(0), pair_of(1)
    first = explorer.propose((9.0, 1.0), 0.0, 0.0, (), 0)
    second = explorer.propose((12.0, 1.0), 1.0, 0.0, (), 0)
    assert relay.accept(second)
    assert not relay.accept(first)
    assert relay.rendezvous == second.rendezvous


def test_a_pair_that_missed_each_other_is_one_again_when_it_agrees():
    explorer, relay = pair_of(0), pair_of(1)
    explorer.note_missed()
    relay.note_missed()
    assert explorer.role is relay.role is Role.ALONE
    assert not relay.take_ready_turn(100.0, 0.5), "it knows no path home"
    relay.knows_home = lambda: True
    assert relay.take_ready_turn(101.0, 0.5)
    proposal = explorer.propose((9.0, 1.0), 101.0, 0.0, (), 0)
    assert relay.accept(proposal)
    assert explorer.role is Role.ALONE, "until it hears that"
    explorer.take_acceptance(answer_to(proposal))
    assert (explorer.role, relay.role) == (Role.EXPLORER, Role.RELAY)


def test_an_explorer_that_is_done_lets_its_relay_go():
    explorer, relay = pair_of(0), pair_of(1)
    relay.knows_home = lambda: True
    relay.accept(explorer.propose(None, 5.0, 0.0, (), 0))
    explorer.take_acceptance(RendezvousMessage(sender=1, rendezvous=None, have=(), accepts=True))
    assert explorer.role is relay.role is Role.ALONE
    assert not relay.take_ready_turn(50.0, 0.5), "they are none again"
    assert not explorer.lacks_partner
    assert not relay.lacks_partner


def test_robots_of_odd_teams_and_those_that_lost_their_partner_lack_one():
    assert pair_of(2, team=3).lacks_partner
    relay = pair_of(1)
    assert not relay.lacks_partner
    relay.note_missed()
    assert relay.lacks_partner


def test_a_relay_says_that_it_is_ready_once_a_period_and_on_its_way_out_only():
    relay = pair_of(1)
    assert not relay.take_ready_turn(0.4, 0.5), "it knows no path home"
    relay.knows_home = lambda: True
    assert [relay.take_ready_turn(t, 0.5) for t in (1.0, 1.2, 1.6)] == [True, False, True]
    relay.stage = Stage.UNTIL_DUE
    assert not relay.take_ready_turn(9.0, 0.5)
    assert not pair_of(0).take_ready_turn(9.0, 0.5)
