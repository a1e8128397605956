"""The elementary functions that the step is written in, as each of its readers has them.

Plain Python reads ``math``, arrays read numpy, a GPU reads its own ``math``. Compiled code for the
processor reads polynomials of its own: the compiler makes vectors of them, which it cannot make of
calls into a library of scalar functions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from trundle.se2 import NEVER_ZERO, make_sinc

Function = Callable[..., Any]
Jit = Callable[[Function], Function]


def as_is(given: Any) -> Any:
    """Return what is given: the compiler of the readers that have none."""
    return given


class Arithmetic(NamedTuple):
    """Elementary functions, and the type that constants need: a double would widen a float."""

    sin: Function
    cos: Function
    sinc: Function  # sin(x) / x, 1 at 0; like the next for less than half a turn, if not `wide`
    near_cos: Function
    log: Function
    sqrt: Function
    floor: Function
    minimum: Function
    maximum: Function
    where: Function
    number: Callable[[float], Any]
    word: Callable[[Any], Any]  # the lowest 32 bits
    upper: Callable[[Any], Any]  # of a word, its 24 highest bits as a number
    whole: Callable[[Any], Any] = int  # the whole number towards 0, to look up a table


def _choose(condition: bool, yes: Any, no: Any) -> Any:
    return yes if condition else no


PLAIN = Arithmetic(
    sin=math.sin,
    cos=math.cos,
    sinc=make_sinc(math.sin, math.sqrt, NEVER_ZERO),
    near_cos=math.cos,
    log=math.log,
    sqrt=math.sqrt,
    floor=math.floor,
    minimum=min,
    maximum=max,
    where=_choose,
    number=float,
    word=lambda n: n & 0xFFFFFFFF,
    upper=lambda n: float(n >> 8),
)


def _as_whole(values: Any) -> Any:
    # What is no number becomes some index: readers keep it inside of their table.
    with np.errstate(invalid="ignore"):
        return np.asarray(values).astype(np.int64)


@cache
def array_arithmetic(dtype: str) -> Arithmetic:
    """Return numpy's functions, for "float32" or "float64"."""
    number = np.dtype(dtype).type
    return Arithmetic(
        sin=np.sin,
        cos=np.cos,
        sinc=make_sinc(np.sin, np.sqrt, number(NEVER_ZERO)),
        near_cos=np.cos,
        log=np.log,
        sqrt=np.sqrt,
        floor=np.floor,
        minimum=np.minimum,
        maximum=np.maximum,
        where=np.where,
        number=number,
        word=np.uint32,
        upper=lambda n: number(n >> np.uint32(8)),
        whole=_as_whole,
    )


def gpu_arithmetic(dtype: str, jit: Jit) -> Arithmetic:
    """Return a GPU's functions: its ``math``, which is read in the type of the argument.

    Args:
        dtype: "float32" or "float64".
        jit: the compiler.
    """
    number, eight = np.dtype(dtype).type, np.uint32(8)
    return PLAIN._replace(
        sinc=jit(make_sinc(math.sin, math.sqrt, number(NEVER_ZERO))),
        where=jit(_choose),
        number=number,
        word=np.uint32,
        upper=jit(lambda n: number(np.int32(n >> eight))),
        whole=np.int32,
    )


# ---- polynomials -----------------------------------------------------------------------------

# Coefficients in z = r^2 of (sin r - r) / r^3 and (cos r - 1 + z / 2) / z^2, from interpolation at
# Chebyshev's nodes over |r| <= pi / 2 with 40 digits: within 3e-8 and 1e-16 of sine and cosine.
_SINE = {
    "float32": (-0.16666665963818398, 0.008333242134826181, -0.00019822739452096719,
                2.6347562734513209e-6),
    "float64": (-0.16666666666666667, 0.00833333333333331587, -0.000198412698412549737,
                2.75573192191632094e-6, -2.5052107616993126e-8, 1.60589773122658935e-10,
                -7.64397029047077159e-13, 2.73144468808580615e-15),
}  # fmt: skip
_COSINE = {
    "float32": (0.0416666660783040407, -0.0013888812551020005, 0.0000247860824093171392,
                -2.65460648129033593e-7),
    "float64": (0.0416666666666666563, -0.0013888888888884767, 0.0000248015872989135379,
                -2.75573185733635871e-7, 2.08766815586426512e-9, -1.14662522508138767e-11,
                4.64643582789925693e-14),
}  # fmt: skip
# What the number pi lacks of pi: taken off too, it keeps the remainder exact where products and
# sums are rounded together; where not, the error is that of rounding the angle itself.
_PI_REST = {"float32": -8.742278000372475e-8, "float64": 1.2246467991473532e-16}
# Added and taken off again, it rounds to a whole number, whose last bits are those of the sum.
_ROUNDER = {"float32": 1.5 * 2.0**23, "float64": 1.5 * 2.0**52}
# Up to this square of half a step's turn, just short of (pi / 2)^2, sinc is one polynomial.
LARGEST_SQUARE = 2.46

# Coefficients of 2 artanh(t) / t in t^2, for t of at most (sqrt 2 - 1) / (sqrt 2 + 1).
_LOGARITHM = {
    "float32": tuple(2.0 / (2 * k + 1) for k in range(5)),
    "float64": tuple(2.0 / (2 * k + 1) for k in range(11)),
}


def number_and_integer(dtype: str) -> tuple[Any, Any]:
    """Return the type of the numbers, and that of integers with as many bits."""
    types = {"float32": (np.float32, np.int32), "float64": (np.float64, np.int64)}
    return types[dtype]


def polynomial(coefficients: tuple[Any, ...], jit: Jit) -> Function:
    """Return the function of z of a polynomial: its even part, and z times its odd part."""
    first = coefficients[0]
    if len(coefficients) == 1:
        return jit(lambda z: first)  # noqa: ARG005
    even = polynomial(coefficients[::2], jit)
    odd = polynomial(coefficients[1::2], jit)
    return jit(lambda z: even(z * z) + z * odd(z * z))


def compiled_arithmetic(
    dtype: str,
    jit: Jit,
    bits: Function,
    wide: bool,
    choices: tuple[Function, Function, Function] = (_choose, min, max),
) -> Arithmetic:
    """Return functions that vectorise, for "float32" or "float64".

    Args:
        dtype: the type of the numbers.
        jit: the compiler.
        bits: compiled function that reads a number's bits as an integer, and back.
        wide: whether sinc must be right for arguments whose square is above ``LARGEST_SQUARE``.
        choices: functions (condition, yes, no), (a, b) -> the smaller, (a, b) -> the larger; such
            that never become branches, if there are.
    """
    where, minimum, maximum = choices
    number, integer = number_and_integer(dtype)
    sine_terms = polynomial(tuple(map(number, _SINE[dtype])), jit)
    cosine_terms = polynomial(tuple(map(number, _COSINE[dtype])), jit)
    one, half, per_pi = number(1), number(0.5), number(1 / math.pi)
    pi, rest, rounder = number(math.pi), number(_PI_REST[dtype]), number(_ROUNDER[dtype])
    to_sign = integer(8 * number(0).itemsize - 1)

    @jit
    def reduce(x: Any) -> Any:
        """X = k pi + r: the sign bit of (-1)^k, and r."""
        shifted = x * per_pi + rounder
        k = shifted - rounder
        return integer(bits(shifted) << to_sign), (x - k * pi) - k * rest

    @jit
    def sin(x: Any) -> Any:
        sign, r = reduce(number(x))
        z = r * r
        return bits(integer(bits(r + r * z * sine_terms(z)) ^ sign))

    @jit
    def cos(x: Any) -> Any:
        sign, r = reduce(number(x))
        z = r * r
        return bits(integer(bits(one - z * half + z * z * cosine_terms(z)) ^ sign))

    @jit
    def near_cos(x: Any) -> Any:
        z = x * x
        return one - z * half + z * z * cosine_terms(z)

    @jit
    def near_sinc(x: Any) -> Any:
        z = x * x
        return one + z * sine_terms(z)

    return Arithmetic(
        sin=sin,
        cos=cos,
        sinc=jit(make_sinc(sin, np.sqrt, number(NEVER_ZERO))) if wide else near_sinc,
        near_cos=cos if wide else near_cos,
        log=_logarithm(dtype, jit, bits),
        sqrt=math.sqrt,
        floor=np.floor,
        minimum=minimum,
        maximum=maximum,
        where=jit(where) if where is _choose else where,
        number=number,
        word=np.uint32,
        upper=jit(lambda n: number(np.int32(n >> 8))),
        whole=np.int32,
    )


def _logarithm(dtype: str, jit: Jit, bits: Function) -> Function:
    """Return the natural logarithm of positive normal numbers: of the exponent, of the rest."""
    number, integer = number_and_integer(dtype)
    terms = polynomial(tuple(map(number, _LOGARITHM[dtype])), jit)
    mantissa = integer({"float32": 23, "float64": 52}[dtype])
    one, log_2 = number(1), number(math.log(2.0))
    # Exponents are taken so that what is left lies between 1 / sqrt(2) and sqrt(2).
    least = integer(np.array(math.sqrt(0.5), dtype=dtype).view(integer))

    @jit
    def log(x: Any) -> Any:
        exponent = integer(integer(bits(x) - least) >> mantissa)
        m = bits(integer(bits(x) - integer(exponent << mantissa)))
        t = (m - one) / (m + one)
        return number(exponent) * log_2 + t * terms(t * t)

    return log
