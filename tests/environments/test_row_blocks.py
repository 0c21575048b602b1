import hypothesis.strategies as st
import numpy as np
from hypothesis import given

from multisrt.environments.formats.row_blocks import BLOCK_CELLS, row_blocks


@given(st.integers(0, 3_000_000), st.integers(0, 3_000_000))
def test_blocks_cover_every_row_once_and_are_neither_large_nor_many(rows, columns):
    if rows * columns > 200 * BLOCK_CELLS:
        columns = 1
    blocks = list(row_blocks((rows, columns)))
    edges = [0, *(block.stop for block in blocks)]
    assert [block.start for block in blocks] == edges[:-1]
    assert edges[-1] == rows
    sizes = np.diff(edges)
    assert (sizes > 0).all()
    assert ((sizes * columns <= BLOCK_CELLS) | (sizes == 1)).all()
    assert len(blocks) <= 2 * rows * columns / BLOCK_CELLS + 1 or columns == 0
