"""Defects of what robots decide and know, and of what is measured of runs."""

from __future__ import annotations

from typing import Final

from benchmarks.mutants.mutant import Mutant

MUTANTS: Final = (
    Mutant(
        name="waits-for-the-dead",
        breaks="A robot of the SRT family never stops asking a robot that does not answer.",
        file="robots/multi_srt/roster.py",
        old="if self._unanswered[number] <= self.patience:",
        new="if self._unanswered[number] >= 0:",
    ),
    Mutant(
        name="master-forgets-a-member",
        breaks="The orders of a master leave one robot of its group out.",
        file="robots/multi_srt/organize.py",
        old="    for i in prospects:\n        grants.orders.setdefault(",
        new="    for i in list(prospects)[1:]:\n        grants.orders.setdefault(",
    ),
    Mutant(
        name="gives-up-at-once",
        breaks="A robot of the SRT family is boxed in after the first setback.",
        file="robots/multi_srt/progress.py",
        old="gives_up = self.setbacks >= self._options.gives_up_after",
        new="gives_up = self.setbacks >= 1",
    ),
    Mutant(
        name="frontier-left-at-home",
        breaks="Robots that do not support others skip the third stage of the planner.",
        file="robots/multi_srt/planner.py",
        old="        if robot.options.complete:\n            self._completing",
        new="        if robot.options.complete and supports:\n            self._completing",
    ),
    Mutant(
        name="closing-for-all",
        breaks="What one robot found not reachable is closed for all others, too.",
        file="robots/exploration_map.py",
        old="return self._robot is None or closing.id.robot == self._robot",
        new="return True",
    ),
    Mutant(
        name="closing-before-its-node",
        breaks="A closing that comes before its node is lost: merging depends on the order.",
        file="robots/local_frontiers.py",
        old=(
            "        self._given_up.setdefault(node_id, []).append(arc)\n"
            "        number = self._regions.numbers.get(node_id)\n"
        ),
        new=(
            "        number = self._regions.numbers.get(node_id)\n"
            "        if number is not None:\n"
            "            self._given_up.setdefault(node_id, []).append(arc)\n"
        ),
    ),
    Mutant(
        name="frontier-dropped-in-merging",
        breaks="A piece of the frontier of each node that is merged is dropped.",
        file="robots/exploration_map.py",
        old="            elif self.add(entry):\n",
        new=(
            "            elif self.add(entry):\n"
            "                self._frontiers.give_up(entry.id, self.frontier(entry.id)[:1])\n"
        ),
    ),
    Mutant(
        name="region-lost-in-an-answer",
        breaks="A robot that is asked for missing regions leaves out the first one.",
        file="robots/listening.py",
        old="entries = self._entries.missing_from(have_of(message.have))",
        new="entries = self._entries.missing_from(have_of(message.have))[1:]",
    ),
    Mutant(
        name="complete-too-early",
        breaks="Robots leave frontiers of three times their width, and say complete.",
        file="robots/frontier/robot.py",
        old="Frontiers(raster, width_m, options.min_frontier_m)",
        new="Frontiers(raster, width_m, options.min_frontier_m or 3.0 * width_m)",
    ),
    Mutant(
        name="farther-of-two",
        breaks="With MinPos, robots go to the farther of two frontiers of equal rank.",
        file="planners/assignment/minpos.py",
        old="if P[robot, j] < lowest:",
        new="if P[robot, j] <= lowest:",
    ),
    Mutant(
        name="ends-anywhere",
        breaks="Robots of the SRT family end where they are, instead of at their roots.",
        file="robots/multi_srt/planner.py",
        old="if here == tree or supports:",
        new="if here is not None:",
    ),
    Mutant(
        name="data-never-returned",
        breaks="Robots of the frontier family that are to return data go home only in chains.",
        file="robots/frontier/robot.py",
        old='if options.home == "never" or me.base is None',
        new='if options.home != "chain" or me.base is None',
    ),
    Mutant(
        name="chain-too-short",
        breaks="Chains of relays count on links of 0.6 times the length that they may have.",
        file="robots/frontier/chain.py",
        old="self._link_m = options.home_link * me.radio.range_m",
        new="self._link_m = 0.6 * options.home_link * me.radio.range_m",
    ),
    Mutant(
        name="limit-for-later",
        breaks="Robots that are to be home in time think that they have half as much time again.",
        file="robots/homing/just_in_time.py",
        old="return self.limit_s - now_s - self.travel_time_s(home_m) - self.reserve_s",
        new="return 1.5 * self.limit_s - now_s - self.travel_time_s(home_m) - self.reserve_s",
    ),
    Mutant(
        name="option-ignored",
        breaks="The option max_waits is ignored: robots wait without limit for others to leave.",
        file="robots/frontier/progress.py",
        old="return self._waits.now[State.WAITING] < self._options.max_waits",
        new="return self._waits.now[State.WAITING] < math.inf",
    ),
    Mutant(
        name="coverage-counted-twice",
        breaks="Area that two robots saw counts twice as covered.",
        file="analysis/coverage.py",
        old="covered_m2=by_state[:, COVERED],",
        new="covered_m2=by_state[:, COVERED] + float(in_the_end[EXPLORABLE:, -1].sum()),",
    ),
    Mutant(
        name="90-after-95",
        breaks="The time to 90 % coverage is that to 97 %.",
        file="analysis/measuring.py",
        old='"time_to_90_s": covered.time_to(0.90),',
        new='"time_to_90_s": covered.time_to(0.97),',
    ),
    Mutant(
        name="covered-too-early",
        breaks="The times to 90, 95 and 99 % are those to 97 % of these shares.",
        file="analysis/coverage.py",
        old="return time_to(share, self.times_s, self.covered_m2, self.explorable_m2)",
        new="return time_to(0.97 * share, self.times_s, self.covered_m2, self.explorable_m2)",
    ),
    Mutant(
        name="silence-not-isolated",
        breaks="A robot whose radio is silent does not count as isolated.",
        file="analysis/isolation.py",
        old="changes = [*_switches(present, silent)]",
        new="changes = [*_switches(present, [])]",
    ),
)
