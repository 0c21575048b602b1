"""The claims of the MinPos paper, with its printed gains (section V A)."""

from __future__ import annotations

from multisrt.presets.minpos_experiment import GREEDY, HOSPITAL, MAZE, MINPOS

SOURCE = "MinPos, section V A, Figures 9 and 10"

MEAN_GAINS = {GREEDY: 8.0, MINPOS: 12.0}
"""Mean gains on closest, in percent."""

LARGEST_GAINS = {HOSPITAL: 15.0, MAZE: 20.0}
"""Maximum gains of greedy and minpos on closest, in percent."""

FASTER = {rule: f"The rule {rule} is faster than closest." for rule in MEAN_GAINS}

ON_AVERAGE = {
    rule: f"On average {rule} shortens the exploration by at least {percent:g} %, compared with "
    "closest."
    for rule, percent in MEAN_GAINS.items()
}

UP_TO = {
    world: f"In the {world} the largest gain on closest is at least {percent:g} %."
    for world, percent in LARGEST_GAINS.items()
}

BEFORE_GREEDY = "On average minpos is slightly faster than greedy."
MORE_WITH_MORE_ROBOTS = "The larger the team, the more greedy and minpos gain on closest."
MORE_IN_MAZES = "Minpos gains more on greedy in mazes than in the hospital."
