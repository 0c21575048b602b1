"""Elementary functions: those of the C library, and no others in what decides or measures."""

import ast
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import multisrt
from multisrt.geometry.numerics import libm

angles = st.floats(-1e3, 1e3)
ONE = {libm.cos: math.cos, libm.sin: math.sin, libm.tan: math.tan}


@given(st.lists(angles))
@pytest.mark.parametrize("function", ONE, ids=lambda f: f.__name__)
def test_functions_are_those_of_the_module_math(function, values):
    assert function(values).tolist() == [ONE[function](value) for value in values]


@given(st.lists(st.tuples(angles, angles)))
def test_directions_are_those_of_the_module_math(pairs):
    y, x = np.array(pairs).reshape(-1, 2).T
    assert libm.arctan2(y, x).tolist() == [math.atan2(*pair) for pair in pairs]


@given(st.lists(st.floats(-1.0, 1.0)), st.floats(-5.0, 5.0))
def test_arcs_and_powers_are_those_of_the_module_math(values, exponent):
    assert libm.arcsin(values).tolist() == [math.asin(value) for value in values]
    bases = np.abs(values) + 0.1
    assert libm.power(bases, exponent).tolist() == [base**exponent for base in bases.tolist()]


def test_results_have_the_broadcast_shape():
    assert libm.cos(np.zeros((2, 3))).shape == (2, 3)
    assert libm.cos(0.0).shape == ()
    assert libm.arctan2(np.zeros((2, 1)), np.ones(3)).shape == (2, 3)
    assert libm.power(10.0, [1.0, 2.0]).tolist() == [10.0, 100.0]
    # Parts of arrays, in any order of their numbers.
    table = np.arange(6.0).reshape(2, 3)
    assert libm.sin(table.T[::-1]).tolist() == np.sin(table.T[::-1]).tolist()


def test_sinc_is_smooth_at_zero():
    assert libm.sinc([0.0, 1e-9]).tolist() == [1.0, 1.0]
    assert libm.sinc(0.5) == pytest.approx(math.sin(0.5) / 0.5)


@given(st.integers(1, 4), st.integers(1, 3), st.integers(1, 4))
def test_products_are_those_of_matrices(n, k, m):
    rng = np.random.default_rng(n + 10 * k + 100 * m)
    one, other = rng.uniform(-1, 1, (n, k)), rng.uniform(-1, 1, (k, m))
    assert libm.product(one, other) == pytest.approx(one @ other)


ROOT = Path(multisrt.__file__).parent
HERE = Path(libm.__file__).resolve()
# The last bit is of no account in pictures, tables of statistics, estimates of time and judgements.
EXEMPT = (
    *("drawing", "replay", "exporting", "reporting"),
    *("statistics", "presets", "experiments", "campaign", "testing"),
)
OWN_PRODUCTS = ("stage.py",)  # of poses
OF_NUMPY = {
    *("sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh"),
    *("exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "cbrt", "power", "float_power"),
    *("sinc", "dot", "matmul", "inner", "vdot", "convolve", "corrcoef"),
}


def functions_of_numpy(source: str) -> Iterator[str]:
    """Yield uses of functions of numpy that differ from processor to processor, but in kernels."""
    tree = ast.parse(source)
    kernels: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and any(
            "kernel" in ast.unparse(each) for each in node.decorator_list
        ):
            kernels.update(range(node.lineno, (node.end_lineno or 0) + 1))
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            yield f"line {node.lineno}: @"
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id == "np"
            and node.attr in OF_NUMPY
            and node.lineno not in kernels
        ):
            yield f"line {node.lineno}: np.{node.attr}"


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("x = np.cos(y)", ["line 1: np.cos"]),
        ("@kernel\ndef f(y):\n    return np.cos(y)", []),
        ("x = np.sqrt(y)", []),
        ("x = y @ z", ["line 1: @"]),
    ],
)
def test_uses_are_found(source, found):
    assert list(functions_of_numpy(source)) == found


def test_nothing_that_decides_or_measures_depends_on_the_processor():
    found: dict[str, Any] = {}
    for file in sorted(
        file
        for folder in (ROOT, *(ROOT / name for name in ("geometry", "planners", "environments")))
        for file in folder.resolve().rglob("*.py")
    ):
        inside = file.relative_to(ROOT.resolve()).parts[0] if ROOT in file.parents else ""
        uses = list(functions_of_numpy(file.read_text()))
        is_exempt = inside in EXEMPT or file == HERE or file.name in OWN_PRODUCTS
        if uses and not is_exempt:
            found[str(file)] = uses
    assert not found, "use multisrt.geometry.numerics.libm"
