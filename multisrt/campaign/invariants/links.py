"""Messages arrive at the robots that the radio reaches, and at no others."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.links import Links
from multisrt.campaign.violations import Violation
from multisrt.events import Sent

NAME: Final = "messages-over-links"
REACHES_ALL: Final = "reaches-all-in-reach"
LOSSES: Final = "losses-at-rate"

ODDS: Final = 1e9
"""Likelihood ratio above which the losses contradict the rate of the spec."""

TO_ALL: Final = ("no place", "inaccessible")
"""Kinds of messages that are always sent to all."""

Judge = Callable[[JudgedRun, Links, Sent], str | None]
"""Return what is wrong with a message, or None."""


def messages_over_links(run: JudgedRun) -> Violation | None:
    """Check that a message reaches only robots that the radio links, directly or by relays.

    The sender, the receiver and all relays are switched on, alive and not silent. Each link is no
    longer than the range, to 1e-6 m. If walls block, its line lies in free space enlarged by 1e-6
    m; if walls weaken, the range is reduced for each wall that the line crosses. Without relays
    the sender must have a link to the receiver. Messages are lost only if the radio has losses.

    Cost: negligible for radios that reach everywhere; otherwise one line for each pair of places.
    """
    return next(_violations(run, NAME, _wrong), None)


def reaches_all_in_reach(run: JudgedRun) -> Violation | None:
    """Check that a message to all reaches all robots certainly linked, directly or by relays.

    As for `messages_over_links`, with all tolerances reversed: links that are shorter than the
    range by 1e-6 m, whose lines keep 1e-6 m from walls or cross so few walls that the signal
    suffices, between robots that are switched on, alive and not silent. A message counts as one to
    all if it reaches several robots, or is of a kind that is never sent to a single one. A receiver
    to which it was lost counts as reached. A message that reaches no robot is a violation if all
    others are certainly in range.

    Cost: negligible for radios that reach everywhere; otherwise one line for each pair of places.
    """
    return next(_violations(run, REACHES_ALL, _missed, is_sure=True), None)


def losses_at_rate(run: JudgedRun) -> Violation | None:
    """Check that messages are lost at the rate of the radio, independently for each receiver.

    The losses are compared with the rate by a likelihood ratio: that of a uniform prior over all
    rates to that of the rate of the spec. A second ratio is that of a radio by which half of the
    messages are lost for all receivers or for none. If losses are independent at the rate, each
    ratio exceeds 1e9 at any time of a run with probability at most 1e-9 (Ville's inequality).

    Cost: negligible.
    """
    loss, sent = run.recording.spec.radio.loss, run.recording.of(Sent)
    lost = sum(len(message.lost) for message in sent)
    came = sum(len(message.reached) for message in sent)
    if loss == 0.0 or lost + came == 0:
        return None
    mixed = math.lgamma(lost + 1) + math.lgamma(came + 1) - math.lgamma(lost + came + 2)
    if mixed - lost * math.log(loss) - came * math.log1p(-loss) > math.log(ODDS):
        says = (
            f"{lost} of {lost + came} receptions are lost, by a radio that loses {loss:g} of them"
        )
    elif sum(_log_odds_of_one_fate(message, loss) for message in sent) > math.log(ODDS):
        says = (
            "messages are lost for all of their receivers, or for none, more often than by chance"
        )
    else:
        return None
    return Violation(invariant=LOSSES, says=says)


def _log_odds_of_one_fate(message: Sent, loss: float) -> float:
    """Return the logarithm of a likelihood ratio: that half of the messages have one fate for all.

    The other half, and all messages by the radio of the spec, are lost independently.
    """
    lost, came = len(message.lost), len(message.reached)
    if lost + came < 2:
        return 0.0
    independent = loss**lost * (1.0 - loss) ** came
    common = loss if came == 0 else 1.0 - loss if lost == 0 else 0.0
    return math.log(0.5 * common / independent + 0.5)


def _violations(
    run: JudgedRun, name: str, judge: Judge, *, is_sure: bool = False
) -> Iterator[Violation]:
    sent = run.recording.of(Sent)
    links = Links(run, [message.time_s for message in sent], is_sure=is_sure)
    for message in sent:
        wrong = judge(run, links, message)
        if wrong is not None:
            yield Violation(
                invariant=name,
                says=f"a message of {run.named(message.robot)} at {message.time_s:.2f} s "
                f"({message.kind}) {wrong}",
                robot=message.robot,
                time_s=message.time_s,
            )


def _wrong(run: JudgedRun, links: Links, message: Sent) -> str | None:
    """Return what is wrong with a message that arrived where it cannot."""
    sender, receivers, now_s = message.robot, (*message.reached, *message.lost), message.time_s
    if not receivers:
        return None
    if message.lost and run.recording.spec.radio.loss == 0.0:
        return f"is lost to robot {message.lost[0]}, but this radio loses none"
    if not links.works(sender, now_s):
        return f"reaches robot {receivers[0]}, but its sender's radio does not work"
    for receiver in receivers:
        if receiver == sender:
            return "reaches its sender"
        if not links.works(receiver, now_s):
            return f"reaches robot {receiver}, whose radio does not work"
    far = sorted({*receivers} - links.reached(sender, now_s))
    if not far:
        return None
    apart_m = links.apart_m(sender, far[0], now_s)
    return f"reaches robot {far[0]}, {apart_m:.3f} m away, to which there is no link"


def _missed(run: JudgedRun, links: Links, message: Sent) -> str | None:
    """Return what is wrong with a message that did not arrive where it must."""
    sender, now_s = message.robot, message.time_s
    receivers = {*message.reached, *message.lost}
    is_to_all = len(receivers) > 1 or message.kind in TO_ALL
    if receivers and not is_to_all:
        return None
    missed = links.reached(sender, now_s) - receivers
    if is_to_all and missed:
        return f"does not reach {run.named(min(missed))}, which is in reach"
    if missed and len(missed) == len(links.members) - 1:
        return "reaches nobody, but all others are in reach"
    return None
