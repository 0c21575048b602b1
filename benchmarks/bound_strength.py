"""Lower bounds beside the informed plan: ``python -m benchmarks.bound_strength``.

Plans each world of the catalogue for one robot and for a team that starts together, drives the
plan, and prints its end, the lower bounds with witnesses for the share that it covered, and the
ratio of the two; then the median of the ratios. Between a bound and a plan lies the least possible
time, so that the ratio says how much both leave open.
"""

from __future__ import annotations

import argparse
import statistics

from multisrt import CatalogEnvironment, RobotSpec, RunSpec, catalog
from multisrt.analysis.bounds import LowerBounds, lower_bounds
from multisrt.analysis.explorable import explorable, viewers
from multisrt.informed.reference import Reference, informed_reference
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import build_environment

TEAMS = (1, 4)
"""Numbers of robots."""


def main() -> None:
    """Print a row for each world and team, and the median."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("worlds", nargs="*", help="names of the catalogue; default: all")
    chosen = parser.parse_args().worlds or [entry.name for entry in catalog()]
    print(f"{'world':<12} robots  informed s  bound s  by        ratio")
    ratios = []
    for name in chosen:
        for robots in TEAMS:
            reference, bounds = measured(name, robots)
            ratio = bounds.largest_s / reference.makespan_s if reference.makespan_s else 1.0
            ratios.append(ratio)
            print(
                f"{name:<12} {robots:>6} {reference.makespan_s:>11.1f} {bounds.largest_s:>8.1f}  "
                f"{_strongest(bounds):<9} {ratio:.2f}",
                flush=True,
            )
    print(f"median of {len(ratios)}: {statistics.median(ratios):.3f}")


def measured(name: str, robots: int) -> tuple[Reference, LowerBounds]:
    """Return the informed plan's figures in a world, and the bounds for what it covered."""
    spec = RunSpec(
        environment=CatalogEnvironment(name=name),
        robots=(RobotSpec(),) * robots,
        starts="clustered",
        seed=1,
    )
    world = build_environment(spec.environment)
    starts = starts_of(spec, world)
    reference = informed_reference(spec, world)
    what = explorable(world, viewers(spec, starts))
    return reference, lower_bounds(spec, world, what, starts, reference.coverage, witnesses=True)


def _strongest(bounds: LowerBounds) -> str:
    by_name = {"reach": bounds.reach_s, "area": bounds.area_s, "witnesses": bounds.witness_s or 0.0}
    return max(by_name, key=lambda name: by_name[name])


if __name__ == "__main__":
    main()
