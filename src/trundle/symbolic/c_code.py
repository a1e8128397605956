"""Equations as a C99 function."""

from __future__ import annotations

from typing import Any

import sympy
from sympy.codegen.rewriting import create_expand_pow_optimization
from sympy.printing.c import C99CodePrinter

from trundle.symbolic.code import Function, common, used_symbols

_WIDTH = 80
# A double has 17 digits; strict C99 has no name for pi.
_PI = sympy.Float(sympy.pi, 17)


def c_source(function: Function) -> str:
    """Return the source of a C99 function; outputs are filled row by row.

    >>> x = sympy.Symbol("x")
    >>> from trundle.symbolic import Function, Group, Output
    >>> y = sympy.Matrix([[x**2, sympy.sin(x)]])
    >>> print(c_source(Function("f", "Compute y.", (Group("q", (x,)),), (Output("y", y),))))
    #include <math.h>
    <BLANKLINE>
    /* Compute y.
     * q[1]: x
     * y[2]: 1 row, 2 columns, row by row
     */
    void f(const double q[1], double y[2])
    {
        const double x = q[0];
        y[0] = x*x;
        y[1] = sin(x);
    }
    <BLANKLINE>
    """
    parts, reduced = common(function)
    read = used_symbols(parts, reduced)
    lines = ["#include <math.h>", "", *_comment(function), _signature(function), "{"]
    for each in function.arguments:
        taken = [(i, symbol) for i, symbol in enumerate(each.symbols) if symbol in read]
        lines += [f"    const double {symbol} = {each.name}[{i}];" for i, symbol in taken]
        if not taken:
            lines.append(f"    (void){each.name};")
    lines += [f"    const double {symbol} = {_print(value)};" for symbol, value in parts]
    for output, matrix in zip(function.outputs, reduced, strict=True):
        lines += [f"    {output.name}[{i}] = {_print(entry)};" for i, entry in enumerate(matrix)]
    return "\n".join([*lines, "}"]) + "\n"


def _signature(function: Function) -> str:
    # An array of no length is not C: such an argument has one entry that is not read.
    into = [f"const double {each.name}[{len(each.symbols) or 1}]" for each in function.arguments]
    out = [f"double {each.name}[{len(each.matrix) or 1}]" for each in function.outputs]
    line = f"void {function.name}({', '.join(into + out)})"
    if len(line) <= _WIDTH:
        return line
    return f"void {function.name}(\n    " + ",\n    ".join(into + out) + ")"


def _comment(function: Function) -> list[str]:
    lines = [f"/* {function.summary}"]
    lines += [
        f" * {each.name}[{len(each.symbols)}]: {', '.join(map(str, each.symbols))}"
        for each in function.arguments
    ]
    for name, matrix, _ in function.outputs:
        shape = ", ".join(
            f"{count} {word}{'s' * (count != 1)}"
            for count, word in ((matrix.rows, "row"), (matrix.cols, "column"))
        )
        lines.append(f" * {name}[{len(matrix)}]: {shape}, row by row")
    return [*lines, " */"]


def _print(expression: Any) -> str:
    plain = create_expand_pow_optimization(3)(expression.subs(sympy.pi, _PI))
    # Without macros: M_SQRT2 and its like are not in C99.
    return str(C99CodePrinter({"math_macros": {}}).doprint(plain))
