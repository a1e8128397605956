"""Normal numbers that depend on seed, robot and step alone, in the arithmetic of every reader.

No generator is carried along: the numbers of any robot at any step are a function of a counter, so
that they are the same on any number of threads and on every device.

Source: the function Threefry4x32 with 13 rounds, Salmon, Moraes, Dror and Shaw, "Parallel random
numbers: as easy as 1, 2, 3", Proceedings of SC11, 2011; Box and Muller, "A note on the generation
of random normal deviates", Annals of Mathematical Statistics 29(2), 1958.
"""

from __future__ import annotations

import math
from typing import Any

from trundle.simulation.arithmetic import Arithmetic, Function, Jit

Words = tuple[Any, Any, Any, Any]

_PARITY = 0x1BD11BDA  # as Threefry names it, of 32-bit words
_ROTATIONS = ((10, 26), (11, 21), (13, 27), (23, 5), (6, 20), (17, 11), (25, 10), (18, 20))
_ROUNDS = 13
# Normals are made of the upper 24 bits of a word, as many as a float holds exactly.
_UNIT = 2.0**-24


def key_words(seed: int) -> tuple[int, ...]:
    """Return the five key words of a seed: its 128 lowest bits and their parity."""
    words = [(seed >> shift) & 0xFFFFFFFF for shift in (0, 32, 64, 96)]
    return (*words, words[0] ^ words[1] ^ words[2] ^ words[3] ^ _PARITY)


def make_threefry(word: Function, jit: Jit, rounds: int = _ROUNDS) -> Function:
    """Return (key, counter) -> four words of 32 random bits.

    Args:
        word: keeps the lowest 32 bits.
        jit: the compiler.
        rounds: how many.

    >>> bits = make_threefry(lambda n: n & 0xFFFFFFFF, lambda function: function)
    >>> [f"{word:08x}" for word in bits(key_words(0), (0, 0, 0, 0))]  # the authors' first vector
    ['531c7e4f', '39491ee5', '2c855a92', '3d6abf9a']
    """

    @jit
    def mix(a: Any, b: Any, left: int, right: int) -> tuple[Any, Any]:
        total = word(a + b)
        return total, word((b << left) | (b >> right)) ^ total

    def one_round(number: int) -> Function:
        left, also = _ROTATIONS[number % 8]
        right, too = 32 - left, 32 - also

        def even(x: Words) -> Words:
            a, b = mix(x[0], x[1], left, right)
            c, d = mix(x[2], x[3], also, too)
            return a, b, c, d

        def odd(x: Words) -> Words:
            a, d = mix(x[0], x[3], left, right)
            c, b = mix(x[2], x[1], also, too)
            return a, b, c, d

        return jit(odd if number % 2 else even)

    def injection(number: int) -> Function:
        k0, k1, k2, k3 = ((number + i) % 5 for i in range(4))

        def inject(key: Any, x: Words) -> Words:
            return (
                word(x[0] + key[k0]),
                word(x[1] + key[k1]),
                word(x[2] + key[k2]),
                word(word(x[3] + key[k3]) + number),
            )

        return jit(inject)

    def from_round(number: int) -> Function:
        """Return the function of this round and all after it; keys enter before every fourth."""
        mixed = one_round(number)
        later = jit(lambda key, x: x) if number + 1 == rounds else from_round(number + 1)  # noqa: ARG005
        if number % 4:
            return jit(lambda key, x: later(key, mixed(x)))
        inject = injection(number // 4)
        return jit(lambda key, x: later(key, mixed(inject(key, x))))

    all_rounds = from_round(0)
    if rounds % 4:
        return all_rounds
    last = injection(rounds // 4)
    return jit(lambda key, x: last(key, all_rounds(key, x)))


def make_words(count: int, m: Arithmetic, jit: Jit) -> Function:
    """Return (key, robot, t) -> so many words of 32 random bits, four at a time.

    Args:
        count: how many words.
        m: elementary functions.
        jit: the compiler.
    """
    threefry, word = make_threefry(m.word, jit), m.word

    def from_block(block: int) -> Function:
        def four(key: Any, robot: Any, t: Any) -> Any:
            return threefry(key, (word(robot), word(t), word(block), word(0)))

        four = jit(four)
        if 4 * (block + 1) >= count:
            return four
        later = from_block(block + 1)
        return jit(lambda key, robot, t: four(key, robot, t) + later(key, robot, t))

    return from_block(0)


def make_normals_of(count: int, m: Arithmetic, jit: Jit) -> Function:
    """Return (words) -> as many independent standard normals.

    The arguments are those of ``make_words``.
    """
    upper, sin, cos, log, sqrt = m.upper, m.sin, m.cos, m.log, m.sqrt
    unit, half, turn, minus_two = (m.number(x) for x in (_UNIT, 0.5, 2 * math.pi * _UNIT, -2.0))

    @jit
    def pair(first: Any, second: Any) -> tuple[Any, Any]:
        radius = sqrt(minus_two * log((upper(first) + half) * unit))
        angle = upper(second) * turn
        return radius * cos(angle), radius * sin(angle)

    def from_word(number: int) -> Function:
        also = number + 1
        if number + 2 >= count:
            return jit(lambda words: pair(words[number], words[also]))
        later = from_word(number + 2)
        return jit(lambda words: pair(words[number], words[also]) + later(words))

    return from_word(0)


def make_normals(count: int, m: Arithmetic, jit: Jit) -> Function:
    """Return (key, robot, t) -> so many independent standard normals.

    The arguments are those of ``make_words``.
    """
    words, normals_of = make_words(count, m, jit), make_normals_of(count, m, jit)
    return jit(lambda key, robot, t: normals_of(words(key, robot, t)))
