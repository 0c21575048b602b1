"""What kernels are compiled for: those that borrow their arrays make none."""

import ast
from glob import glob
from pathlib import Path

import numba
import numpy as np
import pytest

from multisrt.geometry.kernel import borrowing_kernel

PACKAGE = Path(__file__).parents[2] / "multisrt"

SCALAR = {
    "abs", "bool", "float", "int", "len", "max", "min", "range", "unsigned",
    "np.ceil", "np.cos", "np.floor", "np.hypot", "np.iinfo", "np.sin", "np.uint8",
}  # fmt: skip


def kernels() -> dict[str, list[tuple[Path, ast.FunctionDef, str]]]:
    found: dict[str, list[tuple[Path, ast.FunctionDef, str]]] = {}
    for path in map(Path, sorted(glob(f"{PACKAGE}/**/*.py", recursive=True))):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef) and node.decorator_list:
                kind = ast.unparse(node.decorator_list[0])
                if kind.endswith("kernel"):
                    found.setdefault(node.name, []).append((path, node, kind))
    return found


def makes_no_arrays(node: ast.FunctionDef, kind: str) -> bool:
    return kind in ("borrowing_kernel", "inlined_kernel") or "Array" not in ast.unparse(node.args)


def test_borrowing_kernels_call_only_what_makes_no_arrays():
    # Numba refuses most of the rest, but some only where nobody has compiled it before.
    known, borrowing = kernels(), 0
    for path, kernel, kind in (each for same in known.values() for each in same):
        if kind not in ("borrowing_kernel", "inlined_kernel"):
            continue
        borrowing += kind == "borrowing_kernel"
        assert "Array" not in ast.unparse(kernel.returns), f"{path.name}: {kernel.name}"
        for call in (node for node in ast.walk(kernel) if isinstance(node, ast.Call)):
            name = ast.unparse(call.func)
            ours = name in known and all(makes_no_arrays(n, k) for _, n, k in known[name])
            assert ours or name in SCALAR or name.startswith("math."), (
                f"{path.name}: {kernel.name} calls {name}"
            )
    assert borrowing > 40


def test_a_borrowing_kernel_that_makes_an_array_is_refused():
    @borrowing_kernel
    def makes(values):
        return np.empty(values.shape[0]).shape[0]

    with pytest.raises((numba.core.errors.NumbaError, RuntimeError)):
        makes(np.zeros(3))
