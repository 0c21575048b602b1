"""Exponents of power laws beside printed ones: on average, in pairs of maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from multisrt.presets.findings import Saying
from multisrt.reporting.claims import Claim, Verdict
from multisrt.statistics.intervals import LEVEL, Interval, student
from multisrt.statistics.power_law import PowerLaw, fit_power_law

MIN_MAPS = 3
"""Minimum number of maps with a law for a verdict on all of them."""

SOURCE = "Álvarez, Table 4.1"

DEVIATIONS_OF_99 = 2.576
"""Standard deviations from the mean within which 99 % of a normal distribution lie."""


class Laws(NamedTuple):
    """Means by team size on one map, by which a law is fitted, and the printed exponent.

    Attributes
    ----------
    label : str
        Label of the map.
    printed : float
        Exponent in the thesis.
    means : dict from int to float
        Means by team size.
    beside : dict from int to float
        Means by the quantity that is shown beside; empty without one.
    was_seen : bool
        Whether single runs on the map had been looked at when it was chosen.
    """

    label: str
    printed: float
    means: Mapping[int, float]
    beside: Mapping[int, float]
    was_seen: bool = False


Fit = tuple[Laws, Interval]
"""The means on a map, and the exponent that is fitted to them."""


class Quantity(NamedTuple):
    """What falls with team size, and its printed exponents.

    Attributes
    ----------
    name : str
        Name in the text of the claim.
    beside : str
        Name of the quantity that is shown beside.
    band : (float, float)
        Printed bounds of 99 % of all exponents.
    """

    name: str
    beside: str
    band: tuple[float, float]

    @property
    def claim(self) -> str:
        """Text of the claim on its exponents."""
        return (
            f"Averaged over the maps, the {self.name} falls with team size by the printed exponent."
        )

    @property
    def margin(self) -> float:
        """Difference from printed exponents that counts as none: one standard deviation of them.

        It follows from the printed bounds of 99 %. That it is one of them is our choice: the
        thesis does not compare exponents.
        """
        return (self.band[1] - self.band[0]) / (2.0 * DEVIATIONS_OF_99)


def law(means: Mapping[int, float], level: float = LEVEL) -> PowerLaw | None:
    """Return the power law fitted to means by team size; None for fewer than three sizes."""
    if len(means) < 3:
        return None
    return fit_power_law(list(means), list(means.values()), level=level)


def falls_as_printed(what: Quantity, maps: Sequence[Laws]) -> Claim:
    """Return the judged claim that exponents are on average the printed ones.

    The exponents of our maps and the printed ones are pairs. Their mean difference has Student's
    interval over maps. The claim holds if all of it is smaller than `Quantity.margin` on either
    side; otherwise it does not hold if the interval excludes 0. It says nothing of single maps,
    as ours are not those of the thesis: how the exponents correlate is shown, and maps are listed
    whose own intervals, which hold simultaneously (Bonferroni), exclude their printed exponents.

    Parameters
    ----------
    what : Quantity
        The quantity that falls.
    maps : sequence of Laws
        The means of each map.
    """
    level = 1.0 - (1.0 - LEVEL) / max(1, len(maps))
    fits = [(one, fit.exponent) for one in maps if (fit := law(one.means, level))]
    if len(fits) < MIN_MAPS:
        return Claim(
            text=what.claim,
            source=SOURCE,
            verdict="not tested",
            grounds=(
                f"a verdict needs {MIN_MAPS} maps with a printed exponent, each with three team "
                "sizes of which runs succeed",
            ),
        )
    apart = _mean_apart(fits)
    others = _other_choices(what, maps, fits)
    return Claim(
        text=what.claim,
        source=SOURCE,
        verdict=_verdict(apart, what.margin),
        grounds=(
            *_grounds(what, fits, apart),
            *(
                f"{name}: {_verdict(other, what.margin)}; {interval_text(other)} over {count} maps"
                for name, other, count in others
            ),
        ),
        would_show=f"known to ±{apart.high - apart.value:.3f}; the margin is ±{what.margin:.3f}",
        other_verdicts=tuple((name, _verdict(other, what.margin)) for name, other, _ in others),
    )


def _mean_apart(fits: Sequence[Fit]) -> Interval:
    """Return the mean difference of exponents from the printed ones."""
    return student([of.value - one.printed for one, of in fits])


def _other_choices(
    what: Quantity, maps: Sequence[Laws], fits: Sequence[Fit]
) -> list[tuple[str, Interval, int]]:
    """Return by name the mean differences of other maps or by the quantity beside, with counts."""
    unseen = [fit for fit in fits if not fit[0].was_seen]
    beside = [(one, fit.exponent) for one in maps if (fit := law(one.beside))]
    choices = [
        (f"without the {len(fits) - len(unseen)} maps chosen after single runs", unseen),
        (what.beside, beside),
    ]
    return [
        (name, _mean_apart(some), len(some))
        for name, some in choices
        if len(some) >= MIN_MAPS and some != fits
    ]


def _verdict(apart: Interval, margin: float) -> Verdict:
    if -margin <= apart.low and apart.high <= margin:
        return "holds"
    return "does not hold" if apart.low > 0.0 or apart.high < 0.0 else "inconclusive"


def _grounds(what: Quantity, fits: Sequence[Fit], apart: Interval) -> tuple[str, ...]:
    low, high = what.band
    values = [of.value for _, of in fits]
    sayings = [says(of, one.printed) for one, of in fits]
    against = sayings.count("against")
    return (
        f"ours minus the printed exponent, over {len(fits)} maps: {interval_text(apart)}; "
        f"{sum(of.value > one.printed for one, of in fits)} of {len(fits)} are weaker than "
        f"printed; it holds if the whole interval is within {what.margin:.3f} of 0: one standard "
        f"deviation of the thesis's exponents, by its bounds for 99 % of all cases, {low:g} and "
        f"{high:g} (our choice: the thesis compares no exponents)",
        f"ours are {_span(values)}; the thesis's {_span([one.printed for one, _ in fits])}; "
        f"{sum(low <= value <= high for value in values)} of ours lie within the thesis's bounds, "
        f"{low:g} to {high:g}",
        f"simultaneous intervals exclude the printed exponent on {against} of {len(fits)} maps; "
        "agreement map by map is not to be expected, as ours are not the maps of the thesis: "
        f"the exponents correlate at r = {_correlation(fits):.2f}, and their differences have a "
        f"standard deviation of {_spread(fits):.3f}",
        *(
            f"not as printed on {one.label}: ours {interval_text(of)}, printed {one.printed:+.3f}"
            for (one, of), saying in zip(fits, sayings, strict=True)
            if saying == "against"
        ),
    )


def _correlation(fits: Sequence[Fit]) -> float:
    ours, printed = ([of.value for _, of in fits], [one.printed for one, _ in fits])
    with np.errstate(invalid="ignore"):  # nan if all of one side are equal
        return float(np.asarray(np.corrcoef(ours, printed))[0, 1])


def _spread(fits: Sequence[Fit]) -> float:
    return float(np.std([of.value - one.printed for one, of in fits], ddof=1))


def says(exponent: Interval, printed: float) -> Saying:
    """Return whether an interval excludes the printed exponent ("against") or holds it ("for")."""
    return "for" if exponent.low <= printed <= exponent.high else "against"


def interval_text(of: Interval) -> str:
    """Return an estimate with its interval as text."""
    return f"{of.value:+.3f} ({of.low:+.3f} to {of.high:+.3f})"


def _span(exponents: Sequence[float]) -> str:
    return f"{min(exponents):.3f} to {max(exponents):.3f}, {np.mean(exponents):.3f} on average"
