"""Where an explorer's own account of a run and its scans differ."""

from __future__ import annotations

from multisrt.analysis.coverage import coverage, known_complete_s
from multisrt.analysis.evidence import evidence
from multisrt.analysis.explorable import explorable, viewers
from multisrt.environments.environment import Environment
from multisrt.events import MapComplete, Sensed
from multisrt.recording import Recording

MIN_DIFFERENCE = 0.01
"""Share of the explorable area from which on a difference is told."""


def account(recording: Recording, world: Environment) -> tuple[float, tuple[str, ...]]:
    """Return what a run covered, and what its explorers note that their scans do not bear out.

    Parameters
    ----------
    recording : Recording
        A run in which all robots have explorers of one kind.
    world : Environment
        Its world.

    Returns
    -------
    (share, differences)
        The share of the explorable area that counts as covered, and one phrase for each
        difference, to follow "it". None of them is a defect: runs are measured by what they did.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> share, differences = account(recording, recording.environment())
    >>> round(share, 2), differences
    (1.0, ())
    """
    what = explorable(world, viewers(recording.spec, recording.starts))
    proof = evidence(recording, world, what)
    covered = coverage(proof)
    told = []
    if not proof.with_nodes and recording.of(Sensed):
        told.append("notes no node, and is measured by its scans")
    elif covered.seen - covered.share > MIN_DIFFERENCE:
        told.append(
            f"notes nodes that cover {100.0 * covered.share:.1f} %, where its scans showed "
            f"{100.0 * covered.seen:.1f} %: only what it notes counts as covered"
        )
    if proof.unshown_m2 > MIN_DIFFERENCE * covered.explorable_m2:
        told.append(
            f"notes nodes whose regions hold {proof.unshown_m2:.1f} m2 that its scans at their "
            "places had not shown: it does not count"
        )
    claims = recording.of(MapComplete)
    if not claims and recording.footer.outcome == "complete":
        told.append(
            "notes no MapComplete: when a robot knows its map complete stays unknown; yield "
            "Note(MapComplete(time_s=..., robot=...)) where no frontier is left"
        )
    if claims and known_complete_s(proof, covered) is None:
        told.append(
            f"notes MapComplete at {claims[0].time_s:.0f} s, but no robot that says so knew what "
            "the team covered in the end: it does not count"
        )
    return covered.share, tuple(told)
