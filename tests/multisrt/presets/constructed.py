"""Results of the papers' experiments, constructed without simulation.

The values of a run are a function of its condition and repetition: `srt`, `bidding`, `times` and
`laws` return the functions with which the claims of each paper hold, or do not.
"""

import hashlib
from collections.abc import Callable, Iterable

import msgspec

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import Condition, conditions
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import ExperimentSpec
from multisrt.presets import multi_srt
from multisrt.presets.sbx_r_tables import PAPER
from multisrt.reporting.claims import Claim

ZEROS: dict[object, object] = {float: 0.0, int: 0}
PLAIN = msgspec.convert(
    {
        field.name: ZEROS.get(field.type, {} if "dict" in str(field.type) else None)
        for field in msgspec.structs.fields(Metrics)
        if "tuple" not in str(field.type)
    }
    | {name: [0.0] for name in Metrics.__struct_fields__ if "_by_robot" in name}
    | {"nodes_by_robot": [0], "outcome": "complete", "coverage": 1.0, "known_complete_s": 100.0},
    Metrics,
)
"""Metrics of a run in which nothing went wrong and nobody was isolated."""

Measured = Callable[[Condition, int], dict[str, object]]
"""Metrics that differ from `PLAIN`, by condition and repetition."""

Values = Callable[[Condition, int], dict[str, object] | None]
"""The same, with None for a run that was given up."""

QUICK_SRT = multi_srt.experiment(True)


def results_of(spec: ExperimentSpec, values: Values, planned: int | None = None) -> Results:
    """Return results of all runs of an experiment."""
    found: list[Result] = []
    for repetition in range(spec.repetitions):
        for condition in conditions(spec):
            given = values(condition, repetition)
            found.append(
                Result(
                    key=f"{len(found)}",
                    condition=condition,
                    repetition=repetition,
                    status="over_time" if given is None else "complete",
                    reason="beyond 900 s" if given is None else "nothing left",
                    metrics=None if given is None else msgspec.structs.replace(PLAIN, **given),
                )
            )
    return Results(spec, found, planned or len(found), provenance())


def no_results(spec: ExperimentSpec) -> Results:
    """Return the results of an experiment of which nothing was run."""
    return Results(spec, [], len(conditions(spec)) * spec.repetitions, provenance())


def noise_of(condition: Condition, repetition: int, what: str) -> float:
    """Return a number between -1 and 1 that depends on the arguments only."""
    digest = hashlib.blake2b(f"{condition} {repetition} {what}".encode(), digest_size=4).digest()
    return int.from_bytes(digest) / 2.0**31 - 1.0


def claim_on(found: Iterable[Claim], *words: str) -> Claim:
    """Return the one claim that contains all these words."""
    (one,) = [claim for claim in found if all(word in claim.text for word in words)]
    return one


def srt(
    time: Callable[[Condition], float] = lambda at: 1000.0 / at.robots,
    distance: Callable[[Condition], float] = lambda at: 500.0 + 50.0 * at.robots,
    spread: float = 0.02,
) -> Measured:
    def values(at: Condition, repetition: int) -> dict[str, object]:
        slower = 1.3 if at.strategy == "srt-star" else 1.0
        vary = 1.0 + spread * noise_of(at, repetition, "time")
        return {
            "known_complete_s": slower * time(at) * vary,
            "makespan_s": 1.1 * slower * time(at) * vary,
            "total_distance_m": slower * distance(at) * vary,
        }

    return values


def bidding(
    factors: Callable[[Condition], float] = lambda at: 1.0, spread: float = 0.1
) -> Measured:
    def values(at: Condition, repetition: int) -> dict[str, object]:
        ours = factors(at) if at.strategy == "self-bidding" else 1.0
        value = 100.0 * ours * (1.0 + spread * noise_of(at, repetition, "any"))
        names = [*(table.measure.name for table in PAPER), "makespan_s", "split_s"]
        return dict.fromkeys(names, value)

    return values


def times(
    greedy: Callable[[Condition], float] | float,
    best: Callable[[Condition], float] | float,
    spread: float = 0.02,
) -> Measured:
    """Times that are shorter than those of closest by given percentages."""

    def values(at: Condition, repetition: int) -> dict[str, object]:
        gain = {"closest": 0.0, "greedy": greedy, "minpos": best}[at.strategy.split(",")[0]]
        percent = gain(at) if callable(gain) else gain
        # Most of the difference is that of the repetition's world, which pairs share.
        shared = Condition(environment=at.environment, strategy="", robots=1)
        world = 1000.0 * (1.0 + 0.5 * noise_of(shared, repetition, "world"))
        vary = 1.0 + spread * noise_of(at, repetition, "time")
        time = world / at.robots * (1.0 - percent / 100.0) * vary
        return {"known_complete_s": time, "time_to_99_s": 0.99 * time, "makespan_s": time + 1.0}

    return values


def laws(
    time: Callable[[Condition], float] | float,
    distance: float,
    spread: float = 0.01,
    lost: Callable[[Condition, int], bool] = lambda at, k: False,
) -> Measured:
    def values(at: Condition, repetition: int) -> dict[str, object]:
        exponent = time(at) if callable(time) else time
        vary = 1.0 + spread * noise_of(at, repetition, "time")
        return {
            "known_complete_s": 1000.0 * at.robots**exponent * vary,
            "makespan_s": 1010.0 * at.robots**exponent * vary,
            "total_distance_m": 300.0 * at.robots ** (1.0 + distance) * vary,
            "distance_by_robot_m": (1.0,) * at.robots,
            "coverage": 0.94 if lost(at, repetition) else 0.99,
        }

    return values


SOME: dict[str, Measured] = {
    "multi-srt": srt(),
    "sbx-r": bidding(lambda at: 0.5),
    "minpos": times(8.0, 12.0),
    "alvarez": laws(-0.9, -1.1),
}
