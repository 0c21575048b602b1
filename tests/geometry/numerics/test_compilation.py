"""Reports on kernels that are compiled, in a cache of their own."""

import ast
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

COUNTED = """
import numpy as np
from multisrt.geometry.numerics.compilation import watch_compilation
counts, pauses = [], []
with watch_compilation(lambda *count: counts.append(count), lambda: pauses.append(counts[-1])):
    from multisrt.geometry.regions.edge_index import EdgeIndex, no_edge_within
    walls = EdgeIndex(np.array([[0.0, 0.0, 1.0, 0.0]]), 1.0)
    assert no_edge_within(0.5, 0.3, 0.6, 0.3, 0.2, walls.grid)
    within = list(counts)
    no_edge_within(0.5, 0.3, 0.6, 0.3, 0.2, walls.grid)
assert within == counts
# Kernels that others call are compiled within those: fewer pauses than kernels.
assert bool(pauses) == bool(counts) and len(pauses) <= len(counts) // 2
assert pauses[-1:] == counts[-1:]
print(counts)
"""


def counted(cache: Path) -> list[tuple[int, int]]:
    done = subprocess.run(
        [sys.executable, "-c", COUNTED],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    found: list[tuple[int, int]] = ast.literal_eval(done.stdout)
    return found


@pytest.mark.slow
def test_kernels_are_counted_in_a_fresh_cache_and_then_not(tmp_path):
    counts = counted(tmp_path)
    dones = [done for done, _ in counts]
    assert dones[0] == 0
    assert dones == sorted(dones)
    assert {b - a for a, b in pairwise(dones)} <= {0, 1}
    # One report before and one after each compilation.
    assert len(counts) == 2 * dones[-1] > 4
    assert all(done <= about for done, about in counts)
    assert counts[0][1] > 1
    assert counted(tmp_path) == []
    # One of them is missing again; it is about half of a run's.
    (removed,) = tmp_path.rglob("*.no_edge_within-*.nbi")
    removed.unlink()
    assert [done for done, _ in counted(tmp_path)] == [0, 1]
