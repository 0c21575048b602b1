"""Which errand comes first, how a pair agrees on its next meeting, and how an errand ends."""

from __future__ import annotations

import msgspec

from multisrt.events import Decided, PresumedLost
from multisrt.robots.explorer import Note, Send, Steps
from multisrt.robots.frontier.chain import Chain
from multisrt.robots.frontier.errands import Errand
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.homing import FrontierHoming
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.homing.pairs import Role, Stage

MAX_PROPOSALS = 6
"""Number of proposals of a rendezvous after which an explorer goes on without one."""


def errand_now(robot: FrontierRobot) -> Errand | None:
    """Return the errand that comes before all exploration, if there is one."""
    found = None if robot.homing is None else news_errand(robot, robot.homing)
    if found is not None or robot.pursuit is None or robot.team.requests.meet:
        return found
    if robot.homing is not None and robot.homing.chain is not None:
        # A robot that pursues a teammate breaks the chain.
        return None
    return robot.pursuit.errand()


def news_errand(robot: FrontierRobot, homing: FrontierHoming) -> Errand | None:
    """Return the errand that delivers data, or to the partner that does."""
    why = homing.reason() if robot.team.carries else None
    if why is not None:
        robot.team.requests.meet = False
        return homing.errand(why)
    if homing.chain is not None:
        return homing.chain.follow()
    pair = homing.pair
    if robot.team.requests.meet or not homing.update_meeting():
        return None
    if pair.role is Role.RELAY and pair.stage is Stage.UNTIL_DUE:
        if homing.may_deliver():
            return homing.errand(f"it carries the data of robot {pair.partner}")
        pair.set_out()
    return homing.meeting()


def agree(robot: FrontierRobot, homing: FrontierHoming, following: Place | None) -> Steps:
    """Agree with the relay, which is here, on the next rendezvous.

    Parameters
    ----------
    robot : FrontierRobot
        The explorer.
    homing : FrontierHoming
        Its part of the pair.
    following : (x, y) or None
        Where it goes next; None if it is done. It proposes that place if there is time for it.
    """
    team, pair = robot.team, homing.pair
    team.requests.meet = False
    if not pair.may_meet:
        return
    assert pair.partner is not None
    proposal = homing.propose(following)
    for _ in range(MAX_PROPOSALS):
        have = robot.map.entries.counts()
        yield Send(msgspec.structs.replace(proposal, have=have), pair.partner)
        yield from team.pause(team.period_s)
        if pair.accepted:
            break
    team.requests.meet = False
    made = proposal.rendezvous
    text = f"meets robot {pair.partner}, which takes its data"
    if not pair.accepted:
        text = f"meets robot {pair.partner}, which accepts no rendezvous"
    elif made is not None:
        text += f"; next at {made.due_s:.0f} s (rendezvous {made.number})"
    elif following is not None:
        text += "; no time is left for another rendezvous"
    place = None if made is None else made.place
    yield Note(Decided(time_s=robot.time_s, robot=robot.me.robot, text=text, goal=place))


def end_in_chain(robot: FrontierRobot, chain: Chain, errand: Errand) -> Steps:
    """Record which robots are presumed lost, as they did not come or were not heard."""
    if errand.kind == "wait":
        lost = chain.note_missed()
    else:
        front = chain.note_unheard()
        lost = [] if front is None else [front]
    for other in lost:
        yield Note(PresumedLost(time_s=robot.time_s, robot=robot.me.robot, other=other))


def end_errand(robot: FrontierRobot, errand: Errand, *, barred: bool) -> Steps:
    """Record that an errand is over, perhaps in vain.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    errand : Errand
        The errand.
    barred : bool
        Whether bodies bar all paths there.
    """
    if errand.kind == "pursue":
        assert robot.pursuit is not None
        robot.pursuit.note_end()
        return
    homing = robot.homing
    assert homing is not None
    if errand.is_over():
        return
    if homing.chain is not None and errand.kind in ("link", "wait"):
        yield from end_in_chain(robot, homing.chain, errand)
        return
    if errand.kind == "home":
        if barred:
            homing.note_barred(robot.at[:2])
        else:
            homing.note_unheard(robot.time_s)
        return
    homing.pair.note_missed()
    partner = homing.pair.partner
    if not homing.pair.is_paired and partner is not None:
        yield Note(PresumedLost(time_s=robot.time_s, robot=robot.me.robot, other=partner))
