"""The registry of strategies: from a name to the factory of a robot's explorer.

Other packages add their own by an entry point in the group ``multisrt.strategies`` that names a
`Strategy`, or by `register`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.geometry.regions.safe_region import Shape
from multisrt.planners.motion.kinematics import Car
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.frontier.alvarez import rules_explorer
from multisrt.robots.frontier.explore import FrontierExplorer, Rule
from multisrt.robots.frontier.nearness import drive_by_option
from multisrt.robots.frontier.options import (
    BiddingOptions,
    RulesOptions,
    SelfBiddingOptions,
    UtilityOptions,
)
from multisrt.robots.frontier.robot import Watch
from multisrt.robots.frontier.self_bidding import choose_by_self_bidding, send_stop_signals
from multisrt.robots.frontier.utility import choose_utility
from multisrt.robots.frontier.wavefront_rules import choose_closest, choose_greedy, choose_minpos
from multisrt.robots.multi_srt.build_multi_srt import SrtExplorer
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.strategy import Strategy, as_strategy
from multisrt.spec import RunSpec


def register(strategy: Strategy | Callable[..., Explorer], *, replace: bool = False) -> None:
    """Make a strategy known by its name, for this process.

    Parameters
    ----------
    strategy : Strategy, type or callable
        The strategy, or what `Strategy.of` makes one of: the class of an explorer, or a function
        that builds one.
    replace : bool
        Whether it takes the place of one with the same name that was registered before, as when
        a notebook's cell runs again. Built-in strategies are not replaced.

    Raises
    ------
    InvalidInputError
        If there is a strategy of that name already.

    Examples
    --------
    >>> register(strategy("minpos"))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: there is a strategy 'minpos' already, and it ...
    """
    added, known = as_strategy(strategy), _registry()
    if is_built_in(added.name):
        raise InvalidInputError(
            f"there is a strategy {added.name!r} already, and it is built in; choose another "
            "name, as by Strategy.of(..., name=...)"
        )
    if added.name in known and not replace:
        raise InvalidInputError(
            f"there is a strategy {added.name!r} already; to replace it, as when a cell runs "
            "again, give register(..., replace=True)"
        )
    known[added.name] = added


def is_built_in(name: str) -> bool:
    """Whether a strategy of this package has a name.

    Parameters
    ----------
    name : str
        The name.

    Returns
    -------
    bool
        False for those of other packages and those that were registered.

    Examples
    --------
    >>> is_built_in("minpos"), is_built_in("mine")
    (True, False)
    """
    return any(name == own.name for own in (*_OWN, _INFORMED.load()))


@contextmanager
def registered(strategy: Strategy) -> Iterator[None]:
    """Register a strategy within a ``with`` block, in place of one that has its name.

    Parameters
    ----------
    strategy : Strategy
        The strategy.
    """
    known = _registry()
    before = known.get(strategy.name)
    known[strategy.name] = strategy
    try:
        yield
    finally:
        del known[strategy.name]
        if before is not None:
            known[strategy.name] = before


def strategies() -> tuple[Strategy, ...]:
    """Return all strategies: those of this package first, then those of others.

    Returns
    -------
    tuple of Strategy
        The strategies that can be loaded; see `broken_strategies` for the others.

    Examples
    --------
    >>> "srt-radial" in {strategy.name for strategy in strategies()}
    True
    """
    return tuple(_registry().values())


def strategy(name: str) -> Strategy:
    """Return the strategy of a name.

    Parameters
    ----------
    name : str
        Its name.

    Returns
    -------
    Strategy
        The strategy.

    Raises
    ------
    InvalidInputError
        If there is none; the message lists all.

    Examples
    --------
    >>> strategy("minpos").summary
    'To the frontier where fewest are nearer'
    """
    registered = _registry()
    if name not in registered:
        broken = broken_strategies()
        if name in broken:
            raise InvalidInputError(
                f"the strategy {name!r} of another package could not be loaded "
                f"({broken[name]}); fix or uninstall that package"
            )
        raise InvalidInputError(
            f"there is no strategy {name!r}{did_you_mean(name, registered)}; "
            f"there are: {', '.join(registered)}; one of your own is imported by --import FILE.py "
            "on the command line, or registered by multisrt.register"
        )
    return registered[name]


def broken_strategies() -> Mapping[str, str]:
    """Return why entry points of other packages could not be loaded, by name.

    Returns
    -------
    mapping of str to str
        The error of each such entry point, by its name.

    Examples
    --------
    >>> "srt-radial" in broken_strategies()
    False
    """
    return _from_entry_points()[1]


@cache
def _registry() -> dict[str, Strategy]:
    found = {s.name: s for s in (*_OWN, _INFORMED.load())}
    for entry, loaded in _from_entry_points()[0].items():
        if loaded.name in found:
            raise InvalidInputError(
                f"entry point {entry!r} gives a second strategy {loaded.name!r}"
            )
        found[loaded.name] = loaded
    return found


def _from_entry_points() -> tuple[dict[str, Strategy], dict[str, str]]:
    # A broken package does not take away the strategies of the others.
    loaded: dict[str, Strategy] = {}
    broken: dict[str, str] = {}
    for entry in sorted(entry_points(group="multisrt.strategies"), key=lambda e: e.name):
        try:
            given = entry.load()
        except Exception as error:  # whatever another package's code raises
            broken[entry.name] = f"{type(error).__name__}: {error}"
            continue
        if isinstance(given, Strategy):
            loaded[entry.name] = given
        else:
            broken[entry.name] = f"it gives a {type(given).__name__}, not a Strategy"
    return loaded, broken


def _srt(shape: Shape, summary: str) -> Strategy:
    def explorer(me: RobotSelf, options: MultiSrtOptions) -> Explorer:
        return SrtExplorer(me, shape, options)

    return Strategy(
        name=f"srt-{shape}",
        summary=summary,
        options=MultiSrtOptions,
        explorer=explorer,
        fits=_require_reach,
    )


def _require_reach(spec: RunSpec) -> None:
    # Robots that may become engaged have to hear one another before: R_c >= 3 R_p (Multi-SRT,
    # section 2).
    reach, ranges = spec.radio.range_m, [robot.range_finder.range_m for robot in spec.robots]
    least = 3.0 * max(ranges)
    if len(spec.robots) == 1 or reach is None or math.isclose(reach, least):
        return
    if reach < least:
        raise InvalidInputError(
            f"{spec.strategy} needs a radio range of at least three times the sensor range: "
            f"{least:g} m for a sensor range of {max(ranges):g} m, not {reach:g} m; "
            "give a longer radio range, or none for an unlimited one"
        )


def _bids(
    name: str,
    summary: str,
    options: type[BiddingOptions],
    rule: Rule,
    watch: Watch | None = None,
    fits: Callable[[RunSpec], None] | None = None,
) -> Strategy:
    def explorer(me: RobotSelf, options: BiddingOptions) -> Explorer:
        return FrontierExplorer(me, options, rule, drive_by_option, watch)

    def require_fit(spec: RunSpec) -> None:
        if spec.options.get("drive", options().drive) == "nearness-diagram":
            _require_no_car(spec)
        if fits is not None:
            fits(spec)

    return Strategy(
        name=name, summary=summary, options=options, explorer=explorer, fits=require_fit
    )


def _require_no_car(spec: RunSpec) -> None:
    for number, robot in enumerate(spec.robots):
        if isinstance(robot.drive.kinematics(), Car):
            raise InvalidInputError(
                f"robot {number} is a car, which {spec.strategy} cannot drive by the nearness "
                "diagram; choose drive=path, or give it a holonomic or differential drive"
            )


def _require_talk(spec: RunSpec) -> None:
    # Assigning, bidding for others and swapping goals need their positions.
    if len(spec.robots) > 1 and spec.radio.range_m == 0.0:
        raise InvalidInputError(
            f"{spec.strategy} needs robots that hear one another, and the radio range is 0; "
            "give a longer radio range, or none for an unlimited one"
        )


_OWN = (
    _srt("ball", "Sensor-based Random Tree; safe regions are discs of the smallest reading"),
    _srt("star", "Sensor-based Random Tree; safe regions are stars of equal cones"),
    _srt("radial", "Sensor-based Random Tree; safe regions keep every reading"),
    _bids("closest", "Every robot to its nearest frontier", BiddingOptions, choose_closest),
    _bids("greedy", "The shortest ways first, every frontier once", BiddingOptions, choose_greedy),
    _bids("minpos", "To the frontier where fewest are nearer", BiddingOptions, choose_minpos),
    _bids(
        "utility",
        "A leader weighs ways against views",
        UtilityOptions,
        choose_utility,
        fits=_require_talk,
    ),
    _bids(
        "self-bidding",
        "SBX-R: bids for the whole team, which keeps within radio range",
        SelfBiddingOptions,
        choose_by_self_bidding,
        send_stop_signals,
        fits=_require_talk,
    ),
    Strategy(
        name="rules",
        summary="Álvarez: scores of unexplored cells, right of way, and swaps of goals",
        options=RulesOptions,
        explorer=rules_explorer,
        fits=_require_talk,
    ),
)

_INFORMED = EntryPoint("informed", "multisrt.informed.registration:INFORMED", "multisrt.strategies")
"""The strategy that sees the truth. It is loaded by its name, as those of other packages are: what
runs on robots imports nothing of it."""
