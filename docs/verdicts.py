"""Write which claims hold into docs/results/README.md: ``python docs/verdicts.py``.

The verdicts are read from the pages of the papers beside it, so that the summary cannot disagree
with them; a test holds that it is what this writes.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import NamedTuple

SUMMARY = Path(__file__).resolve().parent / "results" / "README.md"
PAPERS = {
    "multi-srt": "Multi-SRT",
    "sbx-r": "SBX-R",
    "minpos": "MinPos",
    "alvarez": "Álvarez's rules",
}
BEGIN, END = "<!-- verdicts: written by docs/verdicts.py -->", "<!-- end of verdicts -->"
EARLIER = "Made by an earlier version of this experiment"

HEADS = {
    "does not hold": "Does not hold",
    "inconclusive": "Inconclusive",
    "not tested": "Not tested",
    "holds": "Holds",
}

MAX_NAMED = 3
"""Upper bound of the claims of a paper that are named where they are inconclusive."""


class Judged(NamedTuple):
    """A claim, its verdict, and other verdicts with what they are by: ``"no support: holds"``."""

    text: str
    verdict: str
    others: tuple[str, ...] = ()

    @property
    def told(self) -> str:
        """The claim, followed by other verdicts that differ from its own."""
        differing = [other for other in self.others if not other.endswith(f": {self.verdict}")]
        return f"{self.text.rstrip('.')} ({'; '.join(differing)})." if differing else self.text


def main() -> None:
    """Write the summary anew, and print whether it has changed."""
    before = SUMMARY.read_text(encoding="utf-8")
    try:
        after = replaced(before, SUMMARY.parent)
    except ValueError as error:
        sys.exit(str(error))
    if after != before:
        SUMMARY.write_text(after, encoding="utf-8")
    print(f"{SUMMARY}: {'unchanged' if after == before else 'written'}")


def replaced(text: str, results: Path) -> str:
    """Return the text of the summary with the verdicts of today's pages.

    Parameters
    ----------
    text : str
        The text so far, with both marks.
    results : Path
        Folder of the pages.

    Raises
    ------
    ValueError
        If there are no marks, or a page has no claims.
    """
    head, begin, rest = text.partition(BEGIN)
    _, end, tail = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{SUMMARY}: it needs the lines {BEGIN} and {END}, in this order")
    return f"{head}{BEGIN}\n\n{verdicts(results)}\n\n{END}{tail}"


def verdicts(results: Path) -> str:
    """Return the verdicts of all pages in Markdown."""
    lines = []
    for name, title in PAPERS.items():
        page = (results / f"{name}.md").read_text(encoding="utf-8")
        try:
            claims = claims_of(page)
        except ValueError as error:
            raise ValueError(f"{results / name}.md: {error}") from None
        lines += _paper(f"[{title}]({name}.md)", claims, is_earlier=EARLIER in page)
    return "\n".join(lines)


def claims_of(page: str) -> list[Judged]:
    """Return the claims of a page with their verdicts, in its order."""
    found = re.search(r"^## Claims\n\n\| claim \| verdict \|.*\n\|.*\n((?:\|.*\n)+)", page, re.M)
    if found is None:
        raise ValueError("there is no table of claims")
    claims = []
    for line in found.group(1).splitlines():
        text, verdict, *_ = (cell.strip() for cell in line.strip("|").split("|"))
        verdict, _, others = verdict.partition(" (")
        by = [other for other in others.rstrip(")").split("; ") if ": " in other]
        claims.append(Judged(text, verdict, tuple(by)))
    return claims


def _paper(link: str, claims: list[Judged], *, is_earlier: bool) -> list[str]:
    holding = sum(claim.verdict == "holds" for claim in claims)
    verb = "holds" if holding == 1 else "hold"
    whose = f"{link}, by an earlier version of the experiment" if is_earlier else link
    lines = [f"- **{whose}: {holding} of {len(claims)} claims {verb}.**"]
    for verdict, head in HEADS.items():
        texts = [claim.told for claim in claims if claim.verdict == verdict]
        is_short = verdict in ("holds", "does not hold") or len(texts) <= MAX_NAMED
        if texts:
            lines.append(
                f"  - *{head}:* {' '.join(texts) if is_short else f'{len(texts)} claims.'}"
            )
    return lines


if __name__ == "__main__":
    main()
