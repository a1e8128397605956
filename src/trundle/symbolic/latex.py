"""Expressions as LaTeX."""

from __future__ import annotations

from typing import Any

import sympy


def to_latex(expression: Any) -> str:
    r"""Return an expression or a matrix as LaTeX, without dollar signs.

    Names ending in ``dot`` get a dot, and what follows ``_`` is an index.

    >>> to_latex(sympy.Symbol("psidot") / sympy.Symbol("x_bc"))
    '\\frac{\\dot{\\psi}}{x_{bc}}'
    """
    return str(sympy.latex(expression, mat_delim="[", mat_str="matrix"))
