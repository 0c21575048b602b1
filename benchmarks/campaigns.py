"""The results of campaigns, kept as one line each, and the page about all of them.

``python -m benchmarks.campaigns add FILE ...`` adds the missions in files of ``multisrt campaign
run`` to ``docs/results/campaigns.jsonl``, and replaces earlier results of the same program and
seed. ``python -m benchmarks.campaigns page`` writes ``docs/results/campaign.md``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import msgspec

from benchmarks.arguments import help_with, parser_of
from multisrt.campaign.invariants.completeness import BARRED, COMPLETE
from multisrt.campaign.invariants.waiting import NAME as WAITS
from multisrt.campaign.store import CampaignStore, Row
from multisrt.campaign.summary import further, summary
from multisrt.geometry.errors import InvalidInputError, counted
from multisrt.presets.summary import markdown_table
from multisrt.recording import atomic_write

ABOUT: Final = """The results of campaigns, kept as one line each, and the page about all of them.

add   adds the missions in files of multisrt campaign run to docs/results/campaigns.jsonl, and
      replaces earlier results of the same program and seed
page  writes docs/results/campaign.md

Neither executes a run."""

NAME: Final = "benchmarks.campaigns"

ADDING: Final = """
add out/campaign/missions.sqlite
add night.sqlite other.sqlite
""".strip()
"""Examples of the command that adds campaigns."""

EXAMPLES: Final = f"{ADDING}\npage"

ROOT: Final = Path(__file__).parents[1]

KEPT: Final = ROOT / "docs/results/campaigns.jsonl"
"""The results of campaigns, a line each."""

PAGE: Final = ROOT / "docs/results/campaign.md"
"""The page."""

FOUND: Final = ROOT / "tests/multisrt/campaign/found"
"""What campaigns have found, each with a comment that says what it was."""

OF_STALLS: Final = (COMPLETE, BARRED, WAITS)
"""The invariants by which a run that stalled is judged."""


class Totals(msgspec.Struct, frozen=True, kw_only=True):
    """What the missions of a strategy came to, as far as it adds up over campaigns.

    Attributes
    ----------
    missions, refused, repeated, failed : int
        As in `multisrt.campaign.summary.StrategySummary`.
    outcomes : dict of str to int
        Number of missions by how they ended.
    unconfirmed : int
        Number of missions that stalled where an oracle finds that they need not have.
    most_events : int
        Largest number of recorded events.
    longest_s : float
        Longest elapsed time of a run and its judging, in seconds.
    """

    missions: int
    refused: int
    repeated: int
    failed: int
    outcomes: dict[str, int]
    unconfirmed: int
    most_events: int
    longest_s: float


class Campaign(msgspec.Struct, frozen=True, kw_only=True):
    """What a campaign came to.

    Attributes
    ----------
    program : str
        Digest of the program that made it.
    seed : int
        Its seed.
    strategies : dict of str to Totals
        By strategy.
    """

    program: str
    seed: int
    strategies: dict[str, Totals]


def campaign_of(path: Path) -> Campaign:
    """Return what the campaign of a file came to."""
    by_strategy: dict[str, list[Row]] = {}
    with CampaignStore.open(path) as store:
        for row in store.rows():
            by_strategy.setdefault(row.strategy, []).append(row)
        return Campaign(
            program=store.program[:12],
            seed=store.seed,
            strategies={name: _totals(rows) for name, rows in sorted(by_strategy.items())},
        )


def _totals(rows: Sequence[Row]) -> Totals:
    told = summary(rows)[-1]
    return Totals(
        missions=told.missions,
        refused=told.refused,
        repeated=told.repeated,
        failed=told.failed,
        outcomes=dict(sorted(told.outcomes.items())),
        unconfirmed=sum(
            row.outcome == "stalled" and any(v.invariant in OF_STALLS for v in row.violations)
            for row in rows
        ),
        most_events=max(row.events for row in rows),
        longest_s=round(max(row.run_s + row.check_s for row in rows), 1),
    )


def united(totals: Sequence[Totals]) -> Totals:
    """Return what several came to together.

    Examples
    --------
    >>> one = Totals(missions=2, refused=0, repeated=1, failed=0, outcomes={"complete": 2},
    ...              unconfirmed=0, most_events=9, longest_s=1.5)
    >>> united([one, one]).outcomes, united([one, one]).most_events
    ({'complete': 4}, 9)
    """
    outcomes: Counter[str] = Counter()
    for each in totals:
        outcomes.update(each.outcomes)
    return Totals(
        missions=sum(each.missions for each in totals),
        refused=sum(each.refused for each in totals),
        repeated=sum(each.repeated for each in totals),
        failed=sum(each.failed for each in totals),
        outcomes=dict(outcomes),
        unconfirmed=sum(each.unconfirmed for each in totals),
        most_events=max(each.most_events for each in totals),
        longest_s=max(each.longest_s for each in totals),
    )


def kept(path: Path) -> list[Campaign]:
    """Return what was added so far."""
    if not path.is_file():
        return []
    return msgspec.json.Decoder(Campaign).decode_lines(path.read_bytes())


def add(files: Iterable[Path], path: Path) -> list[Campaign]:
    """Add the campaigns of files, and return all."""
    found = {(each.program, each.seed): each for each in kept(path)}
    for file in files:
        campaign = campaign_of(file)
        found[campaign.program, campaign.seed] = campaign
    with atomic_write(path) as out:
        out.write(msgspec.json.Encoder().encode_lines(list(found.values())))
    return list(found.values())


def page(campaigns: Sequence[Campaign]) -> str:
    """Return the page of the documentation.

    Parameters
    ----------
    campaigns : sequence of Campaign
        What was added so far, at least one.

    Returns
    -------
    str
        Markdown.
    """
    by_strategy: dict[str, list[Totals]] = {}
    for campaign in campaigns:
        for name, totals in campaign.strategies.items():
            by_strategy.setdefault(name, []).append(totals)
    every = united([totals for found in by_strategy.values() for totals in found])
    rows = [_told(f"`{name}`", united(found)) for name, found in sorted(by_strategy.items())]
    programs = len({campaign.program for campaign in campaigns})
    found = found_before()
    of_program = [said for said in found if not said.startswith(OF_CHECKS)]
    of_checks = [said.removeprefix(OF_CHECKS) for said in found if said.startswith(OF_CHECKS)]
    failed = "none of them" if not every.failed else f"{every.failed:,} of them"
    made = counted(every.missions, "mission")
    parts = (
        "# Results of campaigns",
        f"[Campaigns](../campaign.md) executed {made}, drawn from all worlds, teams, radios, "
        f"faults, strategies and options. In {failed} a check reported a violation; some of these "
        "reports were [errors of the checks](#what-was-found). "
        f"{further(every.repeated, every.refused)}. A repeated mission fails unless its recording "
        f"is identical, byte for byte. {_of_the_last(campaigns)}",
        markdown_table(COLUMNS, [*rows, _told("all", every)]),
        "- *Complete*: no robot left frontier that it could reach. Robots without room beside "
        "their start end at once, and so does `informed` where all is in sight from there; both "
        "are drawn on purpose. How much was covered is not checked here.\n"
        "- *Stalled*: the run ended with frontier left, because robots died, were boxed in, "
        "could not agree, or returned home in time. *Not confirmed*: stalled runs in which, "
        "according to an oracle that knows the map, a robot had a free path or waited for longer "
        "than its limits.\n"
        "- *Out of time*: the randomly drawn time limit ended the run. Where it is longer than the "
        "sum of the limits of all waits, it is checked that no robot stood still for longer than "
        "that.\n"
        "- *Failed*: missions in which a check reported a violation. They are in the column of "
        "their outcome, too, unless the run raised an error, hung, or could not be drawn (*not "
        "drawn*).\n"
        "- *Most events*: the largest number of events in a recording. *Slowest*: the elapsed time "
        "of a run and its checks, on a machine with other load.",
        "## The campaigns",
        f"{counted(len(campaigns), 'campaign')} by {counted(programs, 'version')} of the program, "
        "in the order in which they were executed; *program* is the digest of its source. When a "
        "defect is found, it is fixed and a new campaign is started, so the sum of the failures is "
        "not the failure rate of the present version. Campaigns with other seeds, by versions "
        "that were still being worked on, are not counted.",
        markdown_table(("program", "seed", "missions", "failed"), map(_of_campaign, campaigns)),
        "## What was found",
        f"{counted(len(of_program), 'defect')} of the program, and below them "
        f"{len(of_checks)} of the checks, found by campaigns and by experiments. Several failures "
        "may have one cause. The run that showed each is now a test.",
        _listed(of_program),
        "Defects of the checks, which reported runs that were correct:",
        _listed(of_checks),
        "`python -m benchmarks.campaigns add FILE` adds the missions in a file written by "
        "`multisrt campaign run`; `python -m benchmarks.campaigns page` writes this page.",
    )
    return "\n\n".join(parts) + "\n"


def _of_the_last(campaigns: Sequence[Campaign]) -> str:
    """Return what the latest version came to, with a bound on how often it fails."""
    last = [one for one in campaigns if one.program == campaigns[-1].program]
    whole = united([totals for one in last for totals in one.strategies.values()])
    by_it = f"The latest version executed {counted(whole.missions, 'mission')}"
    if whole.failed:
        return f"{by_it}, of which {whole.failed:,} failed."
    # None of n fails with a probability of (1 - p)^n.
    bound = 1.0 - 0.05 ** (1.0 / whole.missions)
    return (
        f"{by_it}, none of which failed: with a confidence of 95 %, fewer than one in "
        f"{1.0 / bound:,.0f} fails."
    )


def _listed(said: Iterable[str]) -> str:
    return "\n".join(f"- {one[:1].upper()}{one[1:]}" for one in said)


COLUMNS: Final = (
    *("strategy", "missions", "complete", "stalled", "not confirmed", "out of time", "failed"),
    *("most events", "slowest (s)"),
)


def _told(name: str, totals: Totals) -> tuple[str, ...]:
    outcomes = (totals.outcomes.get(name, 0) for name in ("complete", "stalled", "out_of_time"))
    complete, stalled, out_of_time = (f"{number:,}" for number in outcomes)
    return (
        *(name, f"{totals.missions:,}", complete, stalled, f"{totals.unconfirmed:,}", out_of_time),
        *(f"{totals.failed:,}", f"{totals.most_events:,}", f"{totals.longest_s:.0f}"),
    )


def _of_campaign(campaign: Campaign) -> tuple[str, ...]:
    whole = united(list(campaign.strategies.values()))
    return (
        *(f"`{campaign.program}`", str(campaign.seed)),
        *(f"{whole.missions:,}", f"{whole.failed:,}"),
    )


OF_CHECKS: Final = "Check: "
"""How the first line begins of a run that was correct and that a check reported."""


def found_before() -> list[str]:
    """Return what campaigns have found, in a sentence each."""
    return [_first_line(path).removeprefix("# ") for path in sorted(FOUND.glob("*.toml"))]


def _first_line(path: Path) -> str:
    line = path.read_text(encoding="utf-8").partition("\n")[0]
    if not line.startswith("# "):
        raise InvalidInputError(f"{path}: its first line is no comment that says what was found")
    return line


def main(arguments: Sequence[str] | None = None) -> None:
    """Add campaigns, or write the page."""
    parser = parser_of(NAME, ABOUT, EXAMPLES)
    commands = parser.add_subparsers(dest="command", required=True)
    about = "add the missions in files to the results"
    adding = commands.add_parser("add", help=about, **help_with(NAME, f"A{about[1:]}.", ADDING))
    adding.add_argument(
        "files", type=Path, nargs="+", metavar="FILE", help="file written by multisrt campaign run"
    )
    about = f"write {PAGE.relative_to(ROOT)}"
    commands.add_parser("page", help=about, **help_with(NAME, f"W{about[1:]}.", "page"))
    named = parser.parse_args(arguments)
    try:
        campaigns = add(named.files, KEPT) if named.command == "add" else kept(KEPT)
        if named.command == "page":
            if not campaigns:
                raise InvalidInputError(
                    "no campaign was added yet: add the missions of a file by "
                    "'python -m benchmarks.campaigns add FILE'"
                )
            with atomic_write(PAGE) as out:
                out.write(page(campaigns).encode())
    except InvalidInputError as error:
        parser.exit(2, f"{error}\n")
    whole = united([totals for one in campaigns for totals in one.strategies.values()])
    made = f"{counted(whole.missions, 'mission')} of {counted(len(campaigns), 'campaign')}"
    print(f"{made}, {whole.failed:,} failed")


if __name__ == "__main__":
    main()
