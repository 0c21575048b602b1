"""Defects of the simulation: of motions, sensors, radio, faults, chance and the end of runs."""

from __future__ import annotations

from typing import Final

from benchmarks.mutants.mutant import Mutant

MUTANTS: Final = (
    Mutant(
        name="no-protective-stop",
        breaks="No motion is ended before another body.",
        file="simulation/motions.py",
        old="self._traffic.begin(number, now_s, trajectory, move.guard_m)",
        new="self._traffic.begin(number, now_s, trajectory, None)",
    ),
    Mutant(
        name="stops-too-early",
        breaks="Protective stops end motions 15 % farther from another body than they are to.",
        file="simulation/motions.py",
        old="self._traffic.begin(number, now_s, trajectory, move.guard_m)",
        new="self._traffic.begin(number, now_s, trajectory, move.guard_m and 1.15 * move.guard_m)",
    ),
    Mutant(
        name="too-fast",
        breaks="Straight motions are 2 % faster than the drive allows.",
        file="planners/motion/kinematics.py",
        old="Waypoint(distance / speed, x, y, heading)",
        new="Waypoint(distance / (1.02 * speed), x, y, heading)",
    ),
    Mutant(
        name="too-slow",
        breaks="Straight motions are 10 % slower than the drive allows.",
        file="planners/motion/kinematics.py",
        old="Waypoint(distance / speed, x, y, heading)",
        new="Waypoint(distance / (0.9 * speed), x, y, heading)",
    ),
    Mutant(
        name="car-turns-in-place",
        breaks="A Reeds-Shepp car drives as a differential drive does, and turns in place.",
        file="spec/robots.py",
        old='if self.kind == "differential":',
        new='if self.kind in ("differential", "reeds-shepp"):',
    ),
    Mutant(
        name="start-heading-ignored",
        breaks="A robot with a start in the spec starts there in another heading.",
        file="simulation/starts.py",
        old="starts[number] = Configuration(*robot.start)",
        new="starts[number] = Configuration(*robot.start[:2])",
    ),
    Mutant(
        name="range-too-far",
        breaks="Range finders see 10 % farther than the spec says.",
        file="simulation/sensing.py",
        old="time_s, finder.range_m, finder.beams, covered)",
        new="time_s, 1.1 * finder.range_m, finder.beams, covered)",
    ),
    Mutant(
        name="range-too-near",
        breaks="Range finders see only 90 % of the range of the spec.",
        file="simulation/sensing.py",
        old="time_s, finder.range_m, finder.beams, covered)",
        new="time_s, 0.9 * finder.range_m, finder.beams, covered)",
    ),
    Mutant(
        name="laser-reads-too-far",
        breaks="All readings of lasers are too long by 3 cm, so that regions reach into walls.",
        file="geometry/regions/scan.py",
        old="ranges=laser_ranges(index, x, y, range_m, beams),",
        new="ranges=laser_ranges(index, x, y, range_m, beams) + 0.03,",
    ),
    Mutant(
        name="region-beyond-walls",
        breaks="Regions of exact scans are shifted by 0.3 mm, into walls.",
        file="geometry/regions/safe_region.py",
        old="boundary, tags = scan.boundary, scan.tags",
        new="boundary, tags = scan.boundary + 2e-4, scan.tags",
    ),
    Mutant(
        name="message-after-death",
        breaks="Robots that have died still receive messages.",
        file="simulation/faults.py",
        old='robot.state, robot.hears = "dead", False',
        new='robot.state, robot.hears = "dead", True',
    ),
    Mutant(
        name="radio-through-walls",
        breaks="Walls that block the radio do not.",
        file="simulation/radio.py",
        old="if not self._spec.walls_matter or not len(others):",
        new='if self._spec.walls != "weaken" or not len(others):',
    ),
    Mutant(
        name="radio-range-ignored",
        breaks="A radio that no wall blocks reaches everywhere, whatever its range.",
        file="simulation/radio.py",
        old="self.reaches_everywhere = spec.reaches_everywhere",
        new='self.reaches_everywhere = spec.walls != "block"',
    ),
    Mutant(
        name="latency-ignored",
        breaks="Messages take no time where neither loss nor jitter is drawn.",
        file="simulation/radio.py",
        old="return [(receiver, self._spec.latency_s) for receiver in receivers], []",
        new="return [(receiver, 0.0) for receiver in receivers], []",
    ),
    Mutant(
        name="latency-doubled",
        breaks="Messages take twice their time where neither loss nor jitter is drawn.",
        file="simulation/radio.py",
        old="return [(receiver, self._spec.latency_s) for receiver in receivers], []",
        new="return [(receiver, 2.0 * self._spec.latency_s) for receiver in receivers], []",
    ),
    Mutant(
        name="half-the-losses",
        breaks="The radio loses half as many messages as the spec says.",
        file="simulation/radio.py",
        old="self._rng.random() < self._spec.loss:",
        new="self._rng.random() < 0.5 * self._spec.loss:",
    ),
    Mutant(
        name="sees-through-walls",
        breaks="Robots see each other through walls, and at any distance.",
        file="simulation/traffic.py",
        old="self._distance_to_point(other, there, x, y) <= range_m and line_of_sight(",
        new="self._distance_to_point(other, there, x, y) <= range_m or line_of_sight(",
    ),
    Mutant(
        name="sees-where-others-were",
        breaks="Robots see others where these were a quarter of a second ago.",
        file="simulation/sensing.py",
        old="configuration=self._traffic.where(number, time_s),",
        new="configuration=self._traffic.where(number, time_s - 0.25),",
    ),
    Mutant(
        name="seen-as-another-body",
        breaks="Robots see the bodies of all others as that of robot 0.",
        file="simulation/sensing.py",
        old="footprint=self._robots[number].body.footprint,",
        new="footprint=self._robots[0].body.footprint,",
    ),
    Mutant(
        name="stopped-by-itself",
        breaks="A robot that a protective stop has stopped is told that its own body did.",
        file="simulation/motions.py",
        old="blocked_by=self._sensing.sighting(met.other, now_s)",
        new="blocked_by=self._sensing.sighting(robot.number, now_s)",
    ),
    Mutant(
        name="laser-reads-too-near",
        breaks="All readings of lasers are too short by 1 %.",
        file="geometry/regions/scan.py",
        old="ranges=laser_ranges(index, x, y, range_m, beams),",
        new="ranges=0.99 * laser_ranges(index, x, y, range_m, beams),",
    ),
    Mutant(
        name="jitter-not-on-the-data-sheet",
        breaks="Robots are told the latency of the radio without its jitter.",
        file="simulation/radio.py",
        old="latency_s=self._spec.latency_s + self._spec.jitter_s,",
        new="latency_s=self._spec.latency_s,",
    ),
    Mutant(
        name="streams-of-robot-0",
        breaks="All robots draw the same random numbers.",
        file="simulation/setting_up.py",
        old='rng=streams.of("robots", number),',
        new='rng=streams.of("robots", 0),',
    ),
    Mutant(
        name="base-drops-messages",
        breaks="The base station drops messages that arrive in odd milliseconds.",
        file="simulation/base_station.py",
        old="        now_s = self._clock.now_s\n        self._journal.note_time(now_s)\n",
        new=(
            "        now_s = self._clock.now_s\n"
            "        if int(1000.0 * now_s) % 2:\n"
            "            return\n"
            "        self._journal.note_time(now_s)\n"
        ),
    ),
    Mutant(
        name="waits-for-faults",
        breaks="A run in which all robots have ended goes on to the last fault that is due.",
        file="simulation/simulation.py",
        old="if self.mail.messages_in_flight > 0:",
        new="if self.clock.next_s < math.inf:",
    ),
    Mutant(
        name="jitter-ignored",
        breaks="Messages arrive after the latency, whatever the jitter.",
        file="simulation/radio.py",
        old="delay += self._spec.jitter_s * self._rng.random()",
        new="delay += 0.0 * self._rng.random()",
    ),
    Mutant(
        name="addressee-ignored",
        breaks="A message for one robot is received by all in reach.",
        file="simulation/radio.py",
        old="receivers = [to] if to in receivers else []",
        new="receivers = receivers if to in receivers else []",
    ),
    Mutant(
        name="lost-on-the-way",
        breaks="The radio loses messages that are on their way with no other.",
        file="simulation/mail.py",
        old="self.messages_in_flight -= 1\n        member.deliver(message)",
        new=(
            "self.messages_in_flight -= 1\n"
            "        if self.messages_in_flight > 0:\n"
            "            member.deliver(message)"
        ),
    ),
    Mutant(
        name="message-received-twice",
        breaks="A message that arrives at a robot that moves is received twice.",
        file="simulation/robot.py",
        old="self.mailbox.append(message)",
        new="self.mailbox += [message] if self.motion is None else [message, message]",
    ),
    Mutant(
        name="arrival-unnoticed",
        breaks="A robot that waits notices messages only when its wait ends.",
        file="simulation/robot.py",
        old="if self.motion is None or message.wakes:",
        new="if self.motion is not None and message.wakes:",
    ),
    Mutant(
        name="one-relay-only",
        breaks="A message is relayed once, and not over several hops.",
        file="simulation/radio.py",
        old="if self._spec.multi_hop:\n                relays",
        new="if self._spec.multi_hop and len(found) == len(heard):\n                relays",
    ),
    Mutant(
        name="wall-counted-twice",
        breaks="A wall weakens the radio as two walls do.",
        file="simulation/radio.py",
        old="loss_db = spec.wall_loss_db * walls.astype(np.float64)",
        new="loss_db = 2.0 * spec.wall_loss_db * walls.astype(np.float64)",
    ),
    Mutant(
        name="base-hears-what-is-lost",
        breaks="The base station is told what never reached it: messages that were lost.",
        file="simulation/mail.py",
        old="        for receiver, delay_s in deliveries:\n",
        new=(
            "        base = -1 if self._base is None else self._base.number\n"
            "        heard = [(base, 0.0)] if base in lost else []\n"
            "        for receiver, delay_s in [*deliveries, *heard]:\n"
        ),
    ),
    Mutant(
        name="overheard",
        breaks="A robot learns what another one was sent, which no message brought to it.",
        file="simulation/mail.py",
        old="                self._members[receiver].deliver(message)\n",
        new=(
            "                for member in self._members if to is not None else ():\n"
            "                    if member.number not in (robot.number, receiver):\n"
            "                        member.deliver(message)\n"
            "                self._members[receiver].deliver(message)\n"
        ),
    ),
    Mutant(
        name="silence-not-silent",
        breaks="A radio failure is recorded, but the radio keeps working.",
        file="simulation/faults.py",
        old="            robot.hears = False\n            self._record",
        new="            self._record",
    ),
    Mutant(
        name="death-ignored",
        breaks="A death that waits for nothing never strikes.",
        file="simulation/faults.py",
        old='        self.on_doing(robot, "any")\n',
        new="",
    ),
    Mutant(
        name="moving-death-ignored",
        breaks="A robot that is to die moving, and stands when that is due, sets out again alive.",
        file="simulation/faults.py",
        old='if death is None or death.when != "moving" or motion is None:',
        new='if death is None or death.when != "motionless" or motion is None:',
    ),
    Mutant(
        name="late-start-at-zero",
        breaks="A robot that starts late starts at 0 s.",
        file="simulation/interpreter.py",
        old="while self._clock.now_s < join_s - ROUNDING_S:",
        new="while self._clock.now_s < 0.0 * join_s:",
    ),
    Mutant(
        name="no-outcome",
        breaks="A run ends without a reason, and all are called stalled.",
        file="simulation/simulation.py",
        old="return self._finish(self.journal.last_s, *self._outcome())",
        new='return self._finish(self.journal.last_s, "stalled", "")',
    ),
    Mutant(
        name="order-of-hashes",
        breaks="Random numbers depend on the hash of a text, which differs between processes.",
        file="simulation/random_streams.py",
        old="key = (STREAMS[stream], number)",
        new="key = (hash(stream) % 2**32, number)",
    ),
    Mutant(
        name="streams-of-earlier-runs",
        breaks="Random streams go on where those of an earlier run of the process ended.",
        file="simulation/random_streams.py",
        old=(
            "    def __init__(self, seed: int) -> None:\n"
            "        self._seed = seed\n"
            "        self._streams: dict"
        ),
        new=(
            "    def __init__(self, seed: int, streams: dict = {}) -> None:\n"
            "        self._seed = seed\n"
            "        self._streams = streams\n"
            "        self._unused: dict"
        ),
    ),
)
