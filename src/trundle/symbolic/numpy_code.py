"""Equations as a numpy function over leading batch axes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sympy.printing.numpy import NumPyPrinter

from trundle.symbolic.code import Function, Group, Output, common, used_symbols


def numpy_source(function: Function) -> str:
    """Return the source of a numpy function; its arguments have leading batch axes.

    >>> import sympy
    >>> x = sympy.Symbol("x")
    >>> y = sympy.Matrix([[x, sympy.sin(x)]])
    >>> print(numpy_source(Function("f", "Return y.", (Group("q", (x,)),), (Output("y", y),))))
    import numpy as np
    <BLANKLINE>
    <BLANKLINE>
    def f(q):
        \"\"\"Return y.
    <BLANKLINE>
        q (..., 1): x
        Returns y (..., 1, 2).
        \"\"\"
        q = np.asarray(q, dtype=np.float64)
        x = q[..., 0]
        y = np.zeros((*q.shape[:-1], 1, 2))
        y[..., 0, 0] = x
        y[..., 0, 1] = np.sin(x)
        return y
    <BLANKLINE>
    """
    parts, reduced = common(function)
    read = used_symbols(parts, reduced)
    names = [each.name for each in function.arguments]
    lines = ["import numpy as np", "", "", f"def {function.name}({', '.join(names)}):"]
    body = _docstring(function)
    for each in function.arguments:
        body.append(f"{each.name} = np.asarray({each.name}, dtype=np.float64)")
        body += [
            f"{symbol} = {each.name}[..., {i}]"
            for i, symbol in enumerate(each.symbols)
            if symbol in read
        ]
    batch = _batch(names)
    if len(names) > 1:
        body.append(f"batch = {batch}")
        batch = "batch"
    body += [f"{symbol} = {_print(value)}" for symbol, value in parts]
    for output, matrix in zip(function.outputs, reduced, strict=True):
        body += _filled(output, matrix, batch)
    body.append(f"return {', '.join(each.name for each in function.outputs)}")
    return "\n".join(lines + [f"    {line}" if line else "" for line in body]) + "\n"


def numpy_function(function: Function) -> Callable[..., Any]:
    """Return the function that the printed source defines.

    >>> import sympy
    >>> x = sympy.Symbol("x")
    >>> y = sympy.Matrix([[x, sympy.sin(x)]])
    >>> f = numpy_function(Function("f", "Return y.", (Group("q", (x,)),), (Output("y", y),)))
    >>> f([[0.0], [1.0]]).shape
    (2, 1, 2)
    """
    space: dict[str, Any] = {}
    exec(compile(numpy_source(function), f"<{function.name}>", "exec"), space)
    made: Callable[..., Any] = space[function.name]
    return made


def _docstring(function: Function) -> list[str]:
    shapes = [
        f"{name} (..., {m.rows})" if vector else f"{name} (..., {m.rows}, {m.cols})"
        for name, m, vector in function.outputs
    ]
    return [
        f'"""{function.summary}',
        "",
        *(_shape(each) for each in function.arguments),
        f"Returns {', '.join(shapes)}.",
        '"""',
    ]


def _filled(output: Output, matrix: Any, batch: str) -> list[str]:
    """Return the lines that fill an output; zeros are there already."""
    name, rows, columns = output.name, matrix.rows, matrix.cols
    size = str(rows) if output.vector else f"{rows}, {columns}"
    at = {
        (i, j): str(i) if output.vector else f"{i}, {j}"
        for i in range(rows)
        for j in range(columns)
        if matrix[i, j] != 0
    }
    lines = [f"{name}[..., {place}] = {_print(matrix[index])}" for index, place in at.items()]
    return [f"{name} = np.zeros((*{batch}, {size}))", *lines]


def _shape(group: Group) -> str:
    names = ", ".join(map(str, group.symbols)) or "none"
    return f"{group.name} (..., {len(group.symbols)}): {names}"


def _batch(names: list[str]) -> str:
    if not names:
        return "()"
    if len(names) == 1:
        return f"{names[0]}.shape[:-1]"
    return f"np.broadcast_shapes({', '.join(f'{name}.shape[:-1]' for name in names)})"


def _print(expression: Any) -> str:
    # math's functions would not take arrays, and numpy's full name makes the lines long.
    return str(NumPyPrinter().doprint(expression)).replace("numpy.", "np.")
