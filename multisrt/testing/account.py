"""Where an explorer's own account of a run and its scans differ."""

from __future__ import annotations

from multisrt.analysis.coverage import CLAIMED, coverage, known_complete_s
from multisrt.analysis.evidence import evidence
from multisrt.analysis.explorable import explorable, viewers
from multisrt.analysis.metrics import SUCCESS_COVERAGE
from multisrt.environments.environment import Environment
from multisrt.events import MapComplete, Sensed
from multisrt.recording import Recording

MIN_DIFFERENCE = 0.01
"""Share of the explorable area from which on a difference is told."""


def differences(recording: Recording, world: Environment) -> tuple[str, ...]:
    """Return what an explorer says of itself that its scans do not bear out, in words.

    Parameters
    ----------
    recording : Recording
        A run in which all robots have explorers of one kind.
    world : Environment
        Its world.

    Returns
    -------
    tuple of str
        One phrase for each difference, to follow "it"; empty if there are none. None of them is a
        defect: runs are measured by what they did.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> differences(recording, recording.environment())
    ()
    """
    what = explorable(world, viewers(recording.spec, recording.starts))
    proof = evidence(recording, world, what)
    covered = coverage(proof)
    told = []
    if recording.footer.outcome == "complete" and covered.share < SUCCESS_COVERAGE:
        told.append(
            f"says that it is complete, but covered {covered.share:.1%} of what can be explored: "
            f"below {SUCCESS_COVERAGE:.0%} a run does not count as a success"
        )
    if not proof.with_nodes and recording.of(Sensed):
        told.append("notes no node, and is measured by its scans")
    elif covered.seen - covered.share > MIN_DIFFERENCE:
        told.append(
            f"notes nodes that cover {covered.share:.1%}, where its scans showed "
            f"{covered.seen:.1%}: only what it notes counts as covered"
        )
    unseen = float(covered.plane.areas_m2[CLAIMED]) / covered.explorable_m2
    if unseen > MIN_DIFFERENCE:
        told.append(
            f"notes nodes whose regions hold {unseen:.1%} of what can be explored that no scan "
            "had shown: it does not count"
        )
    claims = recording.of(MapComplete)
    if claims and known_complete_s(proof, covered) is None:
        told.append(
            f"notes MapComplete at {claims[0].time_s:.0f} s, but no robot that says so knew what "
            "the team covered in the end: it does not count"
        )
    return tuple(told)
