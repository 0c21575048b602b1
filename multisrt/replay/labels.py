"""Labels that tell the runs of a page apart."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.replay.packing import Packed


def with_labels(runs: Sequence[Packed]) -> list[Packed]:
    """Return packed runs whose labels differ.

    Parameters
    ----------
    runs : sequence of dict
        Packed runs, with a `title` and `conditions`.

    Returns
    -------
    list of dict
        The runs with a `label`: the title, and for runs with equal titles the conditions in
        which they differ, or the numbers of the runs if that does not tell them apart.
    """
    labels: list[str] = []
    for run in runs:
        same = [other["conditions"] for other in runs if other["title"] == run["title"]]
        own = [p for p in run["conditions"] if not all(p in other for other in same)]
        labels.append(", ".join([run["title"], *own]))
    return [
        run | {"label": f"{label}, run {k + 1}" if labels.count(label) > 1 else label}
        for k, (run, label) in enumerate(zip(runs, labels, strict=True))
    ]
