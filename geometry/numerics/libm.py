"""Elementary functions of arrays whose results are the same on every processor.

Those of numpy are chosen when it is imported: on a processor with AVX-512 they are other ones, of
which some results differ in the last bit, and with them whole runs. Those here call the C library
number by number, as the module `math` and kernels do. Its results are the same on all processors
with FMA (since 2013). Products of matrices are not those of BLAS, which has other code for each
kind of processor, too. Sums, products and quotients of numbers, square roots and `numpy.hypot` are
the same everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.kernel import kernel


def cos(angles: ArrayLike) -> FloatArray:
    """Return the cosines of angles in radians, in an array of their shape.

    Examples
    --------
    >>> cos([0.0, math.pi]).tolist()
    [1.0, -1.0]
    """
    return _of_one(_cos, angles)


def sin(angles: ArrayLike) -> FloatArray:
    """Return the sines of angles in radians, in an array of their shape.

    Examples
    --------
    >>> sin([0.0, math.pi / 2.0]).tolist()
    [0.0, 1.0]
    """
    return _of_one(_sin, angles)


def tan(angles: ArrayLike) -> FloatArray:
    """Return the tangents of angles in radians, in an array of their shape.

    Examples
    --------
    >>> tan([0.0]).tolist()
    [0.0]
    """
    return _of_one(_tan, angles)


def arcsin(values: ArrayLike) -> FloatArray:
    """Return the angles from -pi/2 to pi/2 with given sines, in an array of their shape.

    Examples
    --------
    >>> arcsin([0.0]).tolist()
    [0.0]
    """
    return _of_one(_arcsin, values)


def arctan2(y: ArrayLike, x: ArrayLike) -> FloatArray:
    """Return the angles from -pi to pi of directions, in an array of the broadcast shape.

    Examples
    --------
    >>> arctan2([0.0, 1.0], [1.0, 0.0]).tolist() == [0.0, math.pi / 2.0]
    True
    """
    return _of_two(_arctan2, y, x)


def power(bases: ArrayLike, exponents: ArrayLike) -> FloatArray:
    """Return powers, in an array of the broadcast shape.

    Examples
    --------
    >>> power([1.0, 2.0], -2.0).tolist()
    [1.0, 0.25]
    """
    return _of_two(_power, bases, exponents)


def sinc(angles: ArrayLike) -> FloatArray:
    """Return ``sin(x) / x`` for angles x in radians, 1 at 0; `numpy.sinc` takes x / pi.

    Examples
    --------
    >>> sinc([0.0, math.pi / 2.0]).tolist() == [1.0, 2.0 / math.pi]
    True
    """
    given = np.asarray(angles, np.float64)
    divisors = np.where(given == 0.0, 1.0, given)
    found: FloatArray = np.where(given == 0.0, 1.0, sin(given) / divisors)
    return found


def product(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the product of two small matrices, ``(n, k)`` and ``(k, m)``.

    Examples
    --------
    >>> product(np.array([[1.0, 2.0]]), np.array([[3.0], [4.0]])).tolist()
    [[11.0]]
    """
    return _product(np.asarray(one, np.float64, "C"), np.asarray(other, np.float64, "C"))


def _of_one(function: Callable[[FloatArray], FloatArray], values: ArrayLike) -> FloatArray:
    # Not `ascontiguousarray`, which makes a row of a single number.
    given = np.asarray(values, np.float64, order="C")
    return function(given.reshape(-1)).reshape(given.shape)


def _of_two(
    function: Callable[[FloatArray, FloatArray], FloatArray], one: ArrayLike, other: ArrayLike
) -> FloatArray:
    shape = np.broadcast(one, other).shape
    y, x = np.empty(shape), np.empty(shape)
    y[...], x[...] = one, other
    return function(y.reshape(-1), x.reshape(-1)).reshape(shape)


@kernel
def _cos(values: FloatArray) -> FloatArray:
    found = np.empty_like(values)
    for k in range(len(values)):
        found[k] = math.cos(values[k])
    return found


@kernel
def _sin(values: FloatArray) -> FloatArray:
    found = np.empty_like(values)
    for k in range(len(values)):
        found[k] = math.sin(values[k])
    return found


@kernel
def _tan(values: FloatArray) -> FloatArray:
    found = np.empty_like(values)
    for k in range(len(values)):
        found[k] = math.tan(values[k])
    return found


@kernel
def _arcsin(values: FloatArray) -> FloatArray:
    found = np.empty_like(values)
    for k in range(len(values)):
        found[k] = math.asin(values[k])
    return found


@kernel
def _arctan2(y: FloatArray, x: FloatArray) -> FloatArray:
    found = np.empty_like(y)
    for k in range(len(y)):
        found[k] = math.atan2(y[k], x[k])
    return found


@kernel
def _power(bases: FloatArray, exponents: FloatArray) -> FloatArray:
    found = np.empty_like(bases)
    for k in range(len(bases)):
        found[k] = bases[k] ** exponents[k]
    return found


@kernel
def _product(one: FloatArray, other: FloatArray) -> FloatArray:
    found = np.zeros((len(one), other.shape[1]))
    for i in range(len(one)):
        for j in range(other.shape[1]):
            for k in range(len(other)):
                found[i, j] += one[i, k] * other[k, j]
    return found
