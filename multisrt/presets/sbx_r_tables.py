"""Tables I to V of the SBX-R paper, as printed."""

from __future__ import annotations

import re
from dataclasses import dataclass

from multisrt.experiments.measures import Measure, measure_named
from multisrt.statistics.rank_tests import Mark

CLOSEST, UTILITY, SBX_R = "closest", "utility", "self-bidding"
OTHERS = (CLOSEST, UTILITY)
NAMES = {CLOSEST: "Yamauchi", UTILITY: "Stachniss", SBX_R: "SBX-R"}
"""Names of the strategies in the paper."""

RADIO_RANGES_M = (15, 20, 30)
TEAMS = (2, 3, 4, 5)


def radio_label(range_m: int) -> str:
    """Return the label of a radio."""
    return f"{range_m} m"


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperTable:
    """A table as the paper prints it.

    Attributes
    ----------
    number, title : str
        Number and title of the table.
    measure : Measure
        The measure of its figures.
    lines : dict from (str, int) to str
        Rows by strategy and range of the radio (m). A row has a field for each team of 2 to 5
        robots: a median with its mark.
    """

    number: str
    title: str
    measure: Measure
    lines: dict[tuple[str, int], str]

    def median(self, strategy: str, radio_m: int, robots: int) -> str:
        """Return the median of a cell, as printed."""
        return self._field(strategy, radio_m, robots)[0]

    def mark(self, strategy: str, radio_m: int, robots: int) -> Mark:
        """Return the mark of a cell."""
        return self._field(strategy, radio_m, robots)[1]

    def _field(self, strategy: str, radio_m: int, robots: int) -> tuple[str, Mark]:
        field = self.lines[strategy, radio_m].split()[TEAMS.index(robots)]
        value, sign = re.fullmatch(r"([\d.]+)([+-]?)", field).groups()  # type: ignore[union-attr]
        return value, "+" if sign == "+" else "-" if sign == "-" else ""


PAPER = (
    PaperTable(
        number="I",
        title="Total time out of the radio's range",
        measure=measure_named("isolated_total_s"),
        lines={
            (CLOSEST, 15): "201.10+ 290.90+ 166.00+ 141.05",
            (CLOSEST, 20): "106.55+ 207.20+ 75.10+ 65.55",
            (CLOSEST, 30): "47.70 101.90+ 47.00+ 0.00",
            (UTILITY, 15): "391.40+ 503.10+ 207.00+ 105.40",
            (UTILITY, 20): "351.40+ 289.50+ 111.60+ 32.60",
            (UTILITY, 30): "66.50+ 57.00+ 24.65+ 0.00",
            (SBX_R, 15): "43.20 77.70 16.90 14.70",
            (SBX_R, 20): "17.90 44.00 0.00 3.45",
            (SBX_R, 30): "0.00 11.20 0.00 0.00",
        },
    ),
    PaperTable(
        number="II",
        title="Longest isolation of a robot",
        measure=measure_named("isolated_longest_s"),
        lines={
            (CLOSEST, 15): "162.60+ 181.90+ 135.00+ 60.65+",
            (CLOSEST, 20): "72.80+ 145.55+ 66.00+ 56.40+",
            (CLOSEST, 30): "39.10+ 91.65+ 47.00+ 0.00",
            (UTILITY, 15): "191.80+ 184.00+ 137.80+ 45.30+",
            (UTILITY, 20): "212.70+ 125.10+ 77.65+ 29.20+",
            (UTILITY, 30): "52.30+ 57.00+ 24.65+ 0.00",
            (SBX_R, 15): "26.40 50.30 14.70 0.35",
            (SBX_R, 20): "16.15 33.95 0.00 1.45",
            (SBX_R, 30): "0.00 10.10 0.00 0.00",
        },
    ),
    PaperTable(
        number="III",
        title="Largest distance out of the radio's range",
        measure=measure_named("beyond_range_m"),
        lines={
            (CLOSEST, 15): "19.478+ 26.997+ 19.725+ 7.410+",
            (CLOSEST, 20): "10.794+ 21.946+ 9.138+ 7.828+",
            (CLOSEST, 30): "8.830+ 12.310+ 2.284+ 0.000",
            (UTILITY, 15): "17.499+ 2.881+ 15.408+ 5.117+",
            (UTILITY, 20): "16.423+ 13.122+ 10.207+ 4.421+",
            (UTILITY, 30): "4.903+ 8.800+ 2.028+ 0.000",
            (SBX_R, 15): "4.455 6.841 1.776 1.481",
            (SBX_R, 20): "1.514 2.846 0.000 0.154",
            (SBX_R, 30): "0.000 1.105 0.000 0.000",
        },
    ),
    PaperTable(
        number="IV",
        title="Exploration time",
        measure=measure_named("known_complete_s"),
        lines={
            (CLOSEST, 15): "668- 572.1 544.1+ 393.5",
            (CLOSEST, 20): "648.3 534.65+ 466.15+ 426.35",
            (CLOSEST, 30): "604.6 525.5+ 504.5+ 445.3+",
            (UTILITY, 15): "820.9 582.2 467.45 386.4-",
            (UTILITY, 20): "773.05+ 539.35+ 447.15+ 384.95",
            (UTILITY, 30): "769.9+ 555.05+ 450+ 419.5+",
            (SBX_R, 15): "762.25 535.3 449.6 426.55",
            (SBX_R, 20): "655.75 462.05 391.8 395.5",
            (SBX_R, 30): "608.8 435.9 368.2 363.4",
        },
    ),
    PaperTable(
        number="V",
        title="Distance travelled by the team",
        measure=measure_named("total_distance_m"),
        lines={
            (CLOSEST, 15): "445.03 534.86 642.52+ 544.81",
            (CLOSEST, 20): "438.22- 517.30 566.63+ 583.50+",
            (CLOSEST, 30): "385.48 501.63+ 584.82+ 643.11+",
            (UTILITY, 15): "440.81- 476.46- 486.54- 487.20-",
            (UTILITY, 20): "430.83- 440.94 458.38 485.49",
            (UTILITY, 30): "419.30 455.45+ 479.60+ 497.29",
            (SBX_R, 15): "512.78 512.22 523.49 592.76",
            (SBX_R, 20): "459.24 435.25 464.05 525.48",
            (SBX_R, 30): "402.19 391.33 387.56 466.43",
        },
    ),
)
