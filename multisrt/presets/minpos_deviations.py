"""Where the experiment of MinPos differs from that of the paper, and what it does not test."""

from __future__ import annotations

from multisrt.presets.minpos_ablations import APART, ARRIVAL, SCANS, SCANS_ARRIVAL, TARGETS, WIDE
from multisrt.presets.minpos_experiment import (
    BODY,
    CELL_M,
    MAZE_CELLS,
    MAZE_M,
    RANGE_M,
    SCAN_STEPS,
    SPEED_M_S,
    STEP_S,
    every,
)
from multisrt.presets.preset import WORLD, Deviation

DEVIATIONS = (
    Deviation(
        f"Mazes: perfect mazes of {MAZE_M:g} x {MAZE_M:g} m with {MAZE_CELLS} x {MAZE_CELLS} "
        "cells, one for each repetition. The paper's are not available."
    ),
    Deviation(
        f"{WORLD} a generated hospital of 143.6 x 60 m. That of the paper is one of Player/Stage, "
        "whose size the paper does not give (in Stage it is 140 x 60 m); `--map` takes that file, "
        "or another one, in its place."
    ),
    Deviation(
        f"Robots: discs of 0.4 m ({BODY}) that drive in any direction, on cells of {CELL_M:g} m; "
        f"in the paper they are as wide as a cell. {SPEED_M_S:g} m/s, so that a step from cell to "
        f"cell takes {STEP_S:g} s; range finders {RANGE_M:g} m, exact; a radio of unlimited "
        "range. The paper gives no range."
    ),
    Deviation(
        "Robots obstruct each other where two cannot pass: bodies have a size, and robots give "
        "way. Doors and corridors have room for two. The paper does not say whether its simulated "
        "robots obstruct each other. Robots that follow one another to the same frontier may wait "
        "more. How long robots stood still by each rule is shown in a table.",
        (WIDE,),
    ),
    Deviation(
        "Starts: close together, as in the paper (section II), which does not say where. Here the "
        "configuration of the first robot is drawn in each repetition and the others stand around "
        "it. All strategies have the same starts and worlds.",
        (APART,),
    ),
    Deviation(
        f"All strategies take a scan at {every(SCAN_STEPS)} ({SCAN_STEPS * STEP_S:g} s, "
        f"{SCAN_STEPS * CELL_M:g} m), and choose at every step after a scan of one of the team "
        "that shows news. In the paper time is discrete. How often robots choose anew is named an "
        "open problem (section II); it is to be done at each time step, or at least whenever a "
        "frontier is observed or discovered (section II B), ideally whenever news may change the "
        "path (section IV B). Yamauchi, whose rule is closest, chooses when a goal is reached.",
        (SCANS, TARGETS, ARRIVAL, SCANS_ARRIVAL),
    ),
    Deviation(
        "Robots choose each at its own time, from positions of the others that are up to a period "
        "old, and not without news. In the paper time is discrete, and every robot has the "
        "position of all. Robots without a frontier to go to and those presumed lost are not "
        "counted as nearer to one; in the paper all robots count."
    ),
    Deviation(
        "Costs and ties: costs are lengths of paths by a fast march, where the paper counts steps "
        "of a breadth-first search, which has many ties, and the march hardly any. Of equally near "
        "frontiers closest takes the first, where the paper draws one (section III A, Figure 3): "
        "by chance its robots separate. With ties the paper's strict comparison puts both robots "
        "first; here robots at one place take turns. The pages of the algorithms list these."
    ),
    Deviation(
        "Frontiers: a robot goes to one cell of a group, that nearest to the centroid; in the "
        "paper the potential field rises from all cells of a frontier, so that the nearest of them "
        "counts. Groups shorter than the body is wide are left out."
    ),
    Deviation(
        "An exploration ends when one of the robots has a complete map, as in the paper (section "
        "II). The claims are judged by this time. The time to 99 % coverage is shown beside it, as "
        "the last small frontiers may take long; the time until all are done is not, as it follows "
        "within seconds with a radio of unlimited range."
    ),
    Deviation(
        "The paper gives neither team sizes nor the number of runs in its text, and times as "
        "curves only: there are no printed figures for single team sizes. It does not say by which "
        "mean the gains of 8 and 12 % are averages; they are most likely ratios of mean times, "
        "averaged over conditions. Claims are judged by signed ranks of all cells together; "
        "geometric means and ratios of mean times are given beside."
    ),
    Deviation(
        "Power, by earlier runs: “slightly faster than greedy” (12 against 8 %: about 4 %) is just "
        "within what 40 repetitions show, and so is a difference between mazes and hospital of "
        "about 4 %, while that of the paper is probably 2 to 5."
    ),
    Deviation(
        "Claims that are not tested: complexity, O(nm) against O(n²m) of greedy, and "
        "“computationally inexpensive”; that robots separate more rapidly than by closest (section "
        "V A); that minpos needs less communication; and the experiments with robots (V B)."
    ),
)
