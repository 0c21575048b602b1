"""Summary of finished runs on the terminal: a column for each run, and who was best."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from multisrt.cli.base_notes import base_apart, not_delivered
from multisrt.cli.reach import MIN_SHARE, elsewhere
from multisrt.cli.tables import show, show_blocks, table

if TYPE_CHECKING:
    from multisrt.finished_run import Run
    from multisrt.informed.reference import Regret

MAX_ROBOTS = 16
"""Maximum size of a team whose robots are listed one by one."""

MAX_WIDE = 2
"""Number of runs side by side up to which some rows have several numbers."""

CONTACT = "(contact: 0)"
"""What distances between bodies and walls are compared with."""

SHOWN_M2 = 0.05
"""Area from which on it is not 0.0 m2 in the summary."""

Rows = dict[str, str]


def robot_to_ask(run: Run) -> int:
    """Return the robot whose decisions are most worth a look.

    Parameters
    ----------
    run : Run
        The run.

    Returns
    -------
    int
        The first robot that did not end; if all did, the one that ended last.
    """
    from multisrt.events import Ended

    ends = {event.robot: event.time_s for event in run.recording.of(Ended)}
    robots = range(len(run.spec.robots))
    return max(robots, key=lambda robot: (ends.get(robot, float("inf")), -robot))


def print_summary(
    runs: list[Run],
    folders: list[Path],
    regrets: list[Regret] | None = None,
    *,
    details: bool = False,
) -> None:
    """Print how runs in one environment ended, their metrics side by side, and their files.

    Of one run, and of several up to `MAX_WIDE`, the main measures are printed. Several runs are
    compared in a last table of a row for each; if they are more, that is the only one, unless
    details or regrets are asked for.

    Parameters
    ----------
    runs : list of Run
        Runs in the same environment, at least one.
    folders : list of Path
        Folders with the files of each run.
    regrets : list of Regret, optional
        For each run its times as multiples of those of the informed plan.
    details : bool, optional
        Whether all measures are printed, of any number of runs.
    """
    from multisrt.finished_run import RUN_FILES, TREE_NAME
    from multisrt.robots.naming import joined

    for run in runs:
        spec = run.spec
        many = f", {len(spec.robots)} robots" if len(spec.robots) > 1 else ""
        click.echo(f"{spec.strategy} in {run.environment.name}{many}, seed {spec.seed}: ", nl=False)
        click.echo(_ended(run))
        click.echo(f"  {run.reason}")
        if said := not_delivered(run):
            click.echo(f"  {said}")
    _print_reach(runs[0])
    if details or regrets or len(runs) <= MAX_WIDE:
        _print_measures(runs, regrets, details=details)
    if len(runs) > 1:
        _print_comparison(runs)
        click.echo("\n".join(str(folder / TREE_NAME) for folder in folders))
        others = [name for name in RUN_FILES if name != TREE_NAME]
        click.echo(f"and beside each {joined(others)}")
    else:
        click.echo("\n".join(str(folders[0] / name) for name in RUN_FILES))


def _ended(run: Run) -> str:
    from multisrt.drawing.account import outcome_told
    from multisrt.experiments.results import is_success

    outcome = outcome_told(run.recording)
    if is_success(run.metrics):
        return outcome
    if run.metrics.reached():
        return f"{outcome}, but with a collision: no success"
    return f"{outcome}, but only {100.0 * run.metrics.coverage:.1f} % covered: no success"


def _print_measures(runs: list[Run], regrets: list[Regret] | None, *, details: bool) -> None:
    # Sorted: nodes first.
    kinds = sorted({_scans(run) for run in runs})
    nodes = " or ".join("informative scans" if scans else "nodes" for scans in kinds)
    rows = [_rows(run, nodes, runs, details=details) for run in runs]
    for row, run, times in zip(rows, runs, regrets or (), strict=False):
        row |= _regret_rows(run, times)
    columns = [">value"] if len(runs) == 1 else [f">{run.spec.strategy}" for run in runs]
    names = dict.fromkeys(name for row in rows for name in row)
    show_blocks(
        ["measure", *columns], [(name, *(row.get(name, "") for row in rows)) for name in names]
    )
    if 1 < len(runs[0].spec.robots) <= MAX_ROBOTS:
        _print_robots(runs)


def _print_comparison(runs: list[Run]) -> None:
    from multisrt.experiments.results import is_success

    measures: dict[str, list[float | None]] = {
        "95 % (s)": [run.metrics.time_to_95_s for run in runs],
        "known (s)": [run.metrics.known_complete_s for run in runs],
        "done (s)": [run.metrics.makespan_s for run in runs],
        "driven (m)": [run.metrics.total_distance_m for run in runs],
    }
    good = [is_success(run.metrics) for run in runs]
    shares = ["coverage", *["delivered_coverage"] * any(run.spec.base is not None for run in runs)]
    headings = (*("covered", "delivered")[: len(shares)], *measures)
    compared = table("strategy", "success", *(f">{heading}" for heading in headings))
    cells = [_with_best(values, good) for values in measures.values()]
    for number, run in enumerate(runs):
        compared.add_row(
            run.spec.strategy,
            "yes" if good[number] else "no",
            *(_share(getattr(run.metrics, name)) for name in shares),
            *(column[number] for column in cells),
        )
    show(compared)
    what = "* best of the successful runs, one" if any(good) else "one run"
    click.echo(f"{what} for each strategy; 'multisrt experiment'\n  compares over many seeds\n")


def _share(value: float | None) -> str:
    return "" if value is None else f"{100.0 * value:.1f} %"


def _with_best(values: Sequence[float | None], good: Sequence[bool]) -> list[str]:
    pairs = list(zip(values, good, strict=True))
    best = min((value for value, is_good in pairs if is_good and value is not None), default=None)
    return [
        "never" if value is None else f"{'* ' * (is_good and value == best)}{value:.1f}"
        for value, is_good in pairs
    ]


def _print_reach(run: Run) -> None:
    # What the reader changed of the map, whether robots get to the base station, and why a part of
    # the map is not part of the task: other areas, then the body.
    m, start = run.metrics, run.recording.starts[0]
    if run.environment.cleaning:
        click.echo(f"  map cleaned: {run.environment.cleaning}")
    if run.environment.layers is not None:
        click.echo(f"  map {run.environment.layers}")
    if apart := base_apart(run.spec, run.environment, run.recording.starts):
        click.echo(f"  {apart}")
    if said := elsewhere(run.environment, start):
        click.echo(f"  {said}")
    area_m2 = run.environment.component(start.x, start.y).area
    if m.explorable_area_m2 < MIN_SHARE * area_m2:
        bodies = ", ".join(dict.fromkeys(robot.footprint for robot in run.spec.robots))
        click.echo(
            f"  with the body {bodies} only {m.explorable_area_m2:.1f} of {area_m2:.1f} m2 "
            f"{'there' if said else 'of free space'} are explorable"
        )


def _rows(run: Run, nodes: str, runs: list[Run], *, details: bool) -> Rows:
    from multisrt.analysis.metrics import SUCCESS_COVERAGE
    from multisrt.experiments.results import is_success
    from multisrt.explain.terms import GIVEN_UP

    m = run.metrics
    team = len(run.spec.robots) > 1
    of_all = " of all robots" if team else ""
    x, y, _ = run.recording.starts[0]
    return {
        **({} if team else {"start": f"({x:.2f}, {y:.2f})"}),
        f"success ({100 * SUCCESS_COVERAGE:g} % covered)": "yes" if is_success(m) else "no",
        **(
            {"covered": f"{100.0 * m.coverage:.2f} % of {m.explorable_area_m2:.1f} m2 explorable"}
            if len(runs) == 1
            else {
                "covered": f"{100.0 * m.coverage:.2f} %",
                "explorable": f"{m.explorable_area_m2:.1f} m2",
            }
        ),
        "seen": f"{100.0 * m.seen:.2f} %",
        **{
            f"uncovered: {GIVEN_UP.get(why, why)}": f"{m.given_up_m2.get(why, 0.0):.1f} m2"
            for why in _kinds(_large(run.metrics.given_up_m2) for run in runs)
        },
        **_times_covered(run, narrow=len(runs) > MAX_WIDE),
        **({} if m.delivered_coverage is None else _base_rows(run, narrow=len(runs) > MAX_WIDE)),
        "map known complete at": _seconds(m.known_complete_s),
        "ended at (makespan)": _seconds(m.makespan_s),
        "lower bound of the makespan": _seconds(m.lower_bound_s),
        f"distance{of_all}": f"{m.total_distance_m:.1f} m",
        **(_team_rows(run, narrow=len(runs) > MAX_WIDE) if team else {}),
        nodes: str(m.nodes),
        "collisions": str(m.collisions),
        f"smallest clearance to walls {CONTACT}": f"{m.min_clearance_m:.3f} m",
        **(_detail_rows(run, runs) if details else {}),
    }


def _detail_rows(run: Run, runs: list[Run]) -> Rows:
    from multisrt.explain.terms import stage_name

    m = run.metrics
    team = {
        "spread of distances": f"{m.distance_spread_m:.1f} m",
        "known to one robot only, over time": f"{m.known_to_one_m2s:.0f} m2 s",
        "known to one robot only, at the end": f"{m.known_to_one_m2:.1f} m2",
        "coordinations": str(m.coordinations),
        "deadlocks": str(m.deadlocks),
        "messages": f"{m.messages} ({m.bytes_sent / 1e6:.2f} MB)",
        "deliveries": f"{m.deliveries} ({m.lost_deliveries} lost)",
    }
    return {
        "free space": f"{m.free_area_m2:.1f} m2",
        **(team if len(run.spec.robots) > 1 else {}),
        **{
            f"nodes: {stage_name(stage)}": str(m.nodes_by_stage.get(stage, 0))
            for stage in _kinds(run.metrics.nodes_by_stage for run in runs if not _scans(run))
        },
        "frontier arcs given up": str(sum(m.arcs_closed.values())),
        **{
            f"arcs given up: {why}": str(m.arcs_closed.get(why, 0))
            for why in _kinds(run.metrics.arcs_closed for run in runs)
        },
    }


def _regret_rows(run: Run, times: Regret) -> Rows:
    m = run.metrics
    bound = m.makespan_s / m.lower_bound_s if m.lower_bound_s else None
    return {
        "time to 99 % / informed": _multiple(times.time_to_99),
        "makespan / informed": _multiple(times.makespan),
        "makespan / lower bound": _multiple(bound),
    }


def _multiple(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f}"


def _times_covered(run: Run, *, narrow: bool) -> Rows:
    m = run.metrics
    times = {"90": m.time_to_90_s, "95": m.time_to_95_s, "99": m.time_to_99_s}
    if narrow:
        return {f"{share} % covered at": _seconds(value) for share, value in times.items()}
    return {"90, 95, 99 % covered at": _times(*times.values())}


def _team_rows(run: Run, *, narrow: bool) -> Rows:
    m = run.metrics
    between = m.min_distance_between_robots_m
    return {
        "waiting of all robots": f"{m.waiting_time_s:.1f} s",
        "seen by several robots": f"{m.overlap_area_m2:.1f} m2"
        + f" ({100.0 * m.overlap_share:.1f} %)" * (not narrow),
        **({} if m.beyond_range_m is None and not m.isolated_total_s else _isolation(run)),
        "protective stops": str(m.protective_stops),
        **(
            {"robots that died": f"{m.deaths} (lost with them: {m.lost_area_m2:.1f} m2)"}
            if m.deaths
            else {}
        ),
        **(
            {}
            if between is None
            else {f"smallest clearance of robots {CONTACT}": f"{between:.3f} m"}
        ),
    }


def _base_rows(run: Run, *, narrow: bool) -> Rows:
    m = run.metrics
    times = {"90": m.delivered_90_s, "95": m.delivered_95_s, "99": m.delivered_99_s}
    share = 0.0 if m.delivered_coverage is None else m.delivered_coverage
    return {
        "delivered to the base": f"{100.0 * share:.2f} %",
        **(
            {f"{name} % delivered at": _seconds(value) for name, value in times.items()}
            if narrow
            else {"90, 95, 99 % delivered at": _times(*times.values())}
        ),
        "mean delivery delay to the base": _seconds(m.delivery_delay_s),
        "a robot had undelivered data for, mean": _seconds(m.carrying_s),
    }


def _isolation(run: Run) -> Rows:
    m = run.metrics
    rows = {
        "some robot isolated for": f"{m.isolated_total_s:.1f} s",
        "longest isolation": f"{m.isolated_longest_s:.1f} s",
    }
    if m.isolated_total_s and m.beyond_range_m is not None:
        rows["farthest beyond radio range"] = f"{m.beyond_range_m:.1f} m"
    return rows


def _scans(run: Run) -> bool:
    """Whether the nodes of a run are scans taken on the way, not chosen configurations."""
    return "scan" in run.metrics.nodes_by_stage


def _print_robots(runs: list[Run]) -> None:
    alone = len(runs) == 1
    columns = [f">{run.spec.strategy}" for run in runs]
    made_what = ">scans" if _scans(runs[0]) else ">nodes"
    made = runs[0].metrics.nodes_by_robot
    rows = []
    for robot, (x, y, _) in enumerate(runs[0].recording.starts):
        values = [f"{run.metrics.distance_by_robot_m[robot]:.1f} m" for run in runs]
        if alone:
            waited = runs[0].metrics.waiting_time_by_robot_s[robot]
            values += [f"{waited:.1f} s", str(made[robot])]
        rows.append((str(robot), f"({x:.2f}, {y:.2f})", *values))
    if not alone:
        click.echo("distance of each robot")
    headings = [">distance", ">waiting", made_what] if alone else columns
    show_blocks(["robot", "start", *headings], rows, labels=2)


def _seconds(value: float | None) -> str:
    return "never" if value is None else f"{value:.1f} s"


def _times(*values: float | None) -> str:
    return ", ".join("never" if value is None else f"{value:.0f} s" for value in values)


def _large(areas_m2: Mapping[str, float]) -> Mapping[str, float]:
    return {why: area for why, area in areas_m2.items() if area >= SHOWN_M2}


def _kinds(counts: Iterable[Mapping[str, float]]) -> list[str]:
    """Return the kinds that occur in any run: all runs have the same rows."""
    return sorted({kind for own in counts for kind in own})
