"""The closed loop by scipy's adaptive integrator."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from trundle.errors import TrundleError
from trundle.motion import Course
from trundle.se2 import Array
from trundle.simulation.tracking.compiled import Constants
from trundle.simulation.tracking.laws import Law, make_evaluate
from trundle.simulation.tracking.loops import ENDLESS

# Ten digits: what is compared with the other methods has errors far above.
_RELATIVE, _ABSOLUTE = 1e-10, 1e-12
_TIMES_PER_STEP = 10


def run_adaptive(
    law: Law,
    desired: Callable[[float], Course],
    constants: Constants,
    t: Array,
    start: Array,
    notes: Array,
) -> int:
    """Run a closed loop and return how many steps it made.

    The method is DOP853 of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I,
    2nd edition, 1993, section II.5. No step is longer than ten of the times, so that no feature of
    the reference is stepped over.

    Args:
        law: the control law.
        desired: the reference at one time.
        constants: of law, body and wheels.
        t: (T + 1,) times [s].
        start: (6,) pose and twist.
        notes: (18, T + 1), to be filled.
    """
    from scipy.integrate import solve_ivp

    evaluate = make_evaluate(law, constants.hindered, lambda function: function)

    def at(time: float, state: Array) -> Any:
        flat = (each.ravel().tolist() for each in desired(time))
        c, s = math.cos(state[2]), math.sin(state[2])
        u, v = state[3], state[4]
        rate = c * u - s * v, s * u + c * v
        return *evaluate(*flat, 0, 1, *constants, *state.tolist(), *rate, c, s), c, s

    def slope(time: float, state: Array) -> list[float]:
        a_u, a_v, a_r, *_, c, s = at(time, state)
        u, v, r = state[3:]
        return [c * u - s * v, s * u + c * v, r, a_u, a_v, a_r]

    def lost(_: float, state: Array) -> float:
        return ENDLESS - float(np.abs(state[3:]).sum())

    lost.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (t[0], t[-1]), start, method="DOP853", t_eval=t, rtol=_RELATIVE, atol=_ABSOLUTE,
        events=lost, max_step=_TIMES_PER_STEP * float(np.diff(t).max()),
    )  # fmt: skip
    if found.status < 0:
        raise TrundleError(
            f"the adaptive method gave up at t = {found.t[-1] if len(found.t) else t[0]:.4g} s "
            f"({found.message}); take a method with fixed steps, or smaller gains"
        )
    for k, state in enumerate(found.y.T):
        _, _, _, X, Y, Z, *error, c, s = at(float(t[k]), state)
        notes[:15, k] = (*state, X, Y, Z, c * X - s * Y, s * X + c * Y, Z, *error)
    made = found.y.shape[1]
    steps = 0.5 * np.diff(t[:made]) * (found.y[3:, 1:] + found.y[3:, :-1])
    notes[15:, :made] = np.hstack([np.zeros((3, 1)), np.cumsum(steps, axis=1)])
    return int(made) - 1
