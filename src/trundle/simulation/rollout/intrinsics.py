"""What compiled code needs and Python has no word for, as instructions of the compiler's own."""

from __future__ import annotations

from typing import Any, NamedTuple

from trundle.simulation.arithmetic import Function

# Bytes that memory is read and written in at once.
LINE = 64


def read_bits() -> Function:
    """Return the compiled function that reads a number's bits as an integer, and back."""
    from numba import types
    from numba.extending import intrinsic

    read_as = {
        types.float32: types.int32,
        types.float64: types.int64,
        types.int32: types.float32,
        types.int64: types.float64,
    }

    @intrinsic  # type: ignore[untyped-decorator]
    def bits(_: Any, value: Any) -> Any:
        to = read_as[value]

        def generate(context: Any, builder: Any, __: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], context.get_value_type(to))

        return to(value), generate

    made: Function = bits
    return made


def choices() -> tuple[Function, Function, Function]:
    """Return the compiled functions (condition, yes, no), (a, b) -> the smaller, -> the larger.

    They are made of instructions that choose. Of Python's ``yes if condition else no`` the compiler
    makes branches where several have the same condition, and then no vectors. As in numpy, what
    meets a number that is none is none.
    """
    from numba import types
    from numba.extending import intrinsic

    def common(typing: Any, a: Any, b: Any) -> Any:
        """Return the type of both; a whole number does not widen a float."""
        if isinstance(a, types.Float) and not isinstance(b, types.Float):
            return a
        if isinstance(b, types.Float) and not isinstance(a, types.Float):
            return b
        return typing.unify_types(a, b)

    @intrinsic  # type: ignore[untyped-decorator]
    def where(typing: Any, condition: Any, yes: Any, no: Any) -> Any:
        to = common(typing, yes, no)

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            given = zip(arguments, signature.args, (types.boolean, to, to), strict=True)
            chosen, *both = (context.cast(builder, each, of, into) for each, of, into in given)
            return builder.select(chosen, *both)

        return to(condition, yes, no), generate

    def extreme(sign: str) -> Any:
        @intrinsic  # type: ignore[untyped-decorator]
        def choose(typing: Any, a: Any, b: Any) -> Any:
            to = common(typing, a, b)

            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                given = zip(arguments, signature.args, strict=True)
                first, second = (context.cast(builder, each, of, to) for each, of in given)
                if isinstance(to, types.Integer):
                    return builder.select(builder.icmp_signed(sign, first, second), first, second)
                none = builder.fcmp_unordered("uno", first, first)
                taken = builder.or_(builder.fcmp_ordered(sign, first, second), none)
                return builder.select(taken, first, second)

            return to(a, b), generate

        return choose

    return where, extreme("<"), extreme(">")


class Streaming(NamedTuple):
    """Compiled functions that write past the caches: memory needs not be read before.

    Attributes:
        address: (array) -> where it begins.
        put_line: (array, i, source, j): write a line of source, from its number j on, to the array,
            from its number i on, where a line of memory must begin. Both are contiguous, and
            counted through all their axes. A line that is not written whole takes long.
        finish: () -> None: what was written is seen by other threads.
    """

    address: Function
    put_line: Function
    finish: Function


def streaming() -> Streaming:
    """Return the functions that write past the caches."""
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba import types
    from numba.extending import intrinsic

    # Bytes of the widest vector that is written at once; narrower machines split it.
    wide = 32

    def data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
        return context.make_array(kind)(context, builder, array).data

    @intrinsic  # type: ignore[untyped-decorator]
    def address(_: Any, array: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            begins = data(context, builder, signature.args[0], given[0])
            return builder.ptrtoint(begins, context.get_value_type(types.intp))

        return types.intp(array), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def put_line(_: Any, array: Any, i: Any, source: Any, j: Any) -> Any:  # noqa: ARG001
        def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            number = context.get_value_type(array.dtype)
            size = context.get_abi_sizeof(number)
            vector = ir.VectorType(number, wide // size).as_pointer()

            def line_at(k: int) -> Any:
                begins = data(context, builder, signature.args[k], given[k])
                return builder.bitcast(builder.gep(begins, [given[k + 1]]), vector)

            to, of = line_at(0), line_at(2)
            flag = builder.module.add_metadata([ir.Constant(ir.IntType(32), 1)])
            for k in range(LINE // wide):
                at = [ir.Constant(ir.IntType(32), k)]
                values = builder.load(builder.gep(of, at), align=size)
                put = builder.store(values, builder.gep(to, at), align=wide)
                put.set_metadata("nontemporal", flag)
            return context.get_dummy_value()

        return types.none(array, types.intp, source, types.intp), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def finish(_: Any) -> Any:
        def generate(context: Any, builder: Any, *__: Any) -> Any:
            builder.fence("seq_cst")
            return context.get_dummy_value()

        return types.none(), generate

    return Streaming(address, put_line, finish)
