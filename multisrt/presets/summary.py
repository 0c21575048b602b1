"""The summary of a preset's results, in Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from multisrt.experiments.crossing import conditions
from multisrt.experiments.results import Results
from multisrt.presets.ablations import Ablation, Ablations
from multisrt.presets.preset import Deviation, Preset
from multisrt.presets.words import failed_runs
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.reporting.study import Study
from multisrt.reporting.tables import gap_table

Beside = Mapping[str, Sequence[tuple[str, Claim]]]
"""By the text of a claim the changes, each with the claim as judged by its runs."""

JUDGING = (
    "A claim is judged by one two-sided test at 5 % of all its cells together, which are "
    "conditions of the experiment, in repetitions that have the same worlds and starts. Below it "
    "each cell is tested by itself, with p-values adjusted by Holm's procedure over the cells of "
    "the claim. A is Vargha and Delaney's effect size: the probability that a run of the first set "
    "has a lower value than one of the second. A verdict is *inconclusive* if the difference may "
    "be chance; the last column of the table says what these runs would have shown. Verdicts are "
    "about these worlds alone, and are not adjusted over the claims of a paper."
)
"""How claims are judged, in short."""

MAX_FAILURES = 50
"""Upper bound of the failed runs that are listed."""


def summary(
    preset: Preset,
    results: Results,
    command: str,
    *,
    claims: Sequence[Claim],
    tables: Sequence[PrintedTable],
    ablations: Results | None = None,
) -> str:
    """Return the summary of a preset's results: claims, figures, deviations and failed runs.

    Parameters
    ----------
    preset : Preset
        The experiment of a paper.
    results : Results
        Its results, which may be incomplete.
    command : str
        The command that made them.
    claims : sequence of Claim
        The judged claims.
    tables : sequence of PrintedTable
        The figures beside the paper's, and the comparisons behind the claims.
    ablations : Results, optional
        Results of the preset's ablations, which may be incomplete; None if they were left out.

    Returns
    -------
    str
        The Markdown document.
    """
    made = None
    beside: Beside = {}
    if preset.ablations is not None and ablations is not None:
        made = preset.ablations.made_in(ablations.experiment)
        beside = made.verdicts_beside(ablations)
    sections = [
        f"# {preset.about}",
        f"Made with `{command}`. The paper: {preset.paper}.",
        _bullets(_account(results)),
        "## Claims",
        markdown_table(
            ("claim", "verdict", "sensitivity"),
            [(claim.text, _verdicts(claim, beside), claim.would_show) for claim in claims],
        ),
        JUDGING,
        *(_claim(claim, made, beside) for claim in claims),
        "## Differences from the paper's experiment",
        *_differences(preset.deviations, made),
        "## Figures beside the paper's",
        *(_printed(table) for table in tables if table.source),
        *_ablations(made, ablations),
        *_gaps(results),
        "## Unsuccessful runs",
        _bullets(failed_runs([r for r in results if r.failed], MAX_FAILURES)) or "None.",
        "## Figures behind the claims",
        *(_printed(table) for table in tables if not table.source),
    ]
    return "\n\n".join(section.rstrip() for section in sections if section) + "\n"


def _account(results: Results) -> list[str]:
    complete = sum(result.status == "complete" for result in results)
    seconds = sum(result.computing_s for result in results)
    versions = results.provenance.versions
    spec = results.experiment
    teams = sorted({at.robots for at in conditions(spec)})
    lines = [
        f"Experiment: {spec.name}; teams of {', '.join(map(str, teams))}; {spec.repetitions} "
        "repetitions.",
        f"Runs: {len(results)} of {results.planned}; {complete} complete, "
        f"{sum(result.success for result in results)} successful: without a collision, with at "
        f"least {100.0 * spec.success_coverage:.0f} % of the explorable area covered.",
        f"Computing time of all runs: {seconds / 3600.0:.2f} h of one core.",
        f"Versions: {', '.join(f'{name} {versions[name]}' for name in versions)}; "
        f"{results.provenance.system}, {results.provenance.machine}.",
        f"Digest of the program's source: {results.provenance.program}.",
    ]
    if len(results) < results.planned:
        lines.append(
            f"**{results.planned - len(results)} runs are missing: the same command continues with "
            "them.**"
        )
    return lines


def _ablations(made: Ablations | None, results: Results | None) -> list[str]:
    if made is None or results is None:
        return []
    seconds = sum(result.computing_s for result in results)
    settings = dict.fromkeys((one.change, one.setting) for one in made.changes)
    return [
        "## Ablations",
        "Runs apart from those of the claims, in few conditions: they show what a difference from "
        "the paper does, or where a claim that does not hold fails, and decide no claim. "
        f"{len(results)} of {results.planned} runs, {results.experiment.repetitions} repetitions; "
        f"computing time {seconds / 3600.0:.2f} h of one core. "
        "Baseline runs are the experiment's own where it has them.",
        markdown_table(("change", "setting"), list(settings)),
        *(_printed(table) for table in made.tables(results)),
    ]


def _gaps(results: Results) -> list[str]:
    if not results.unreferenced and all(result.reference is None for result in results):
        return []
    table = gap_table(Study(results))
    if table is None:
        return []
    rows = [[cell.line for cell in row] for row in table.rows]
    return [
        "## Beside a team that knows the map",
        markdown_table(table.columns, rows),
        _bullets(table.notes),
    ]


def _verdicts(claim: Claim, beside: Beside) -> str:
    """Return the verdict, and in brackets those by other quantities and by runs with a change."""
    others = [f"{_plain(heading)}: {verdict}" for heading, verdict in claim.other_verdicts]
    others += [f"{by}: {other.verdict}" for by, other in beside.get(claim.text, ())]
    return f"{claim.verdict} ({'; '.join(others)})" if others else claim.verdict


def _plain(heading: str) -> str:
    """Return a heading without its unit, as it stands in a sentence."""
    title = re.sub(r" \([^()]*\)", "", heading)
    return title[0].lower() + title[1:]


def _claim(claim: Claim, ablations: Ablations | None, beside: Beside) -> str:
    grounds = [*claim.grounds]
    for change, other in beside.get(claim.text, ()):
        verdict = f"by the ablation “{change}”, over all runs, successful or not: {other.verdict}"
        grounds.append("\n  - ".join((verdict, *other.grounds)))
    if claim.verdict == "does not hold" and ablations is not None:
        grounds.append(_why(ablations.asking_why(claim.text)))
    return "\n\n".join(
        (
            f"### {claim.text}",
            f"**{claim.told[0].upper()}{claim.told[1:]}.** Claimed in: {claim.source}.",
            _bullets(grounds),
        )
    )


def _why(asking: Sequence[Ablation]) -> str:
    changes = dict.fromkeys(f"“{one.change}”" for one in asking)
    topics = dict.fromkeys(f"“{one.topic.title}”" for one in asking)
    if not changes:
        return "no ablation asks why it does not hold"
    return f"ablations that ask why: {', '.join(changes)}; see {' and '.join(topics)}"


def _differences(deviations: Sequence[Deviation], made: Ablations | None) -> list[str]:
    """Return the deviations; where ablations were made, by whether these measure them."""
    if made is None:
        return [_bullets(one.text for one in deviations)]
    changes = {one.change for one in made.changes}
    by = [[change for change in one.ablations if change in changes] for one in deviations]
    measured = [
        f"{one.text} Measured by: {', '.join(f'“{change}”' for change in measuring)}."
        for one, measuring in zip(deviations, by, strict=True)
        if measuring
    ]
    others = [one.text for one, measuring in zip(deviations, by, strict=True) if not measuring]
    return [
        "Differences whose effect ablations measure, in the tables below:",
        _bullets(measured),
        "Differences whose effect is not measured:",
        _bullets(others),
    ]


def _printed(table: PrintedTable) -> str:
    parts = (f"### {table.title}", table.note, markdown_table(table.columns, table.rows))
    return "\n\n".join(part for part in parts if part)


def markdown_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown.

    Examples
    --------
    >>> print(markdown_table(("claim", "verdict"), [("It is faster.", "holds")]))
    | claim | verdict |
    | ----- | ------- |
    | It is faster. | holds |
    """
    lines = [columns, ["-" * max(3, len(column)) for column in columns], *rows]
    return "\n".join(
        f"| {' | '.join(field.replace('|', '/') for field in line)} |" for line in lines
    )


def _bullets(lines: Iterable[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)
