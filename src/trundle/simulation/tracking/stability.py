"""Whether small errors die out: the discrete loop, linearised at rest."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from trundle.motion import Course
from trundle.se2 import Array
from trundle.simulation.tracking.compiled import Constants, run_plain
from trundle.simulation.tracking.laws import Law
from trundle.simulation.tracking.loops import COLUMNS

_NUDGE = 1e-4  # of pose and twist, far above rounding and far below where the loop bends
# Errors that neither grow nor die (a gain of zero) multiply by 1, and central differences of this
# loop are good to about twelve digits.
_GROWS = 1 + 1e-10
# Where a step so much shorter is unstable too, its length is not to blame.
_SHORTER = 0.01
_HALVINGS = 40


@lru_cache(maxsize=256)
def instability(method: str, law: Law, constants: Constants, dt: float) -> str:
    """Return why the loop of a method with step dt [s] is unstable, or ""."""
    growth = _growth(method, law, constants, dt)
    if growth <= _GROWS:
        return ""
    free = constants._replace(acting=0)
    if constants.hindered and _growth(method, law, free, dt) <= _GROWS:
        return (
            f"dt = {dt:g} s is too long for the wheels' friction: Coulomb friction changes sign "
            "within 0.01 rad/s, and so fast a change needs a shorter step"
        )
    low, high = _SHORTER * dt, dt
    if _growth(method, law, constants, low) > _GROWS:
        return (
            f"these gains are unstable at any step: small errors grow, {growth:.6g} times in a "
            f"step of {dt:g} s, and with steps of {low:g} s too; raise kd"
        )
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _growth(method, law, constants, middle) > _GROWS:
            high = middle
        else:
            low = middle
    return (
        f"dt = {dt:g} s is too long for these gains: a step of method {method!r} multiplies small "
        f"errors by up to {growth:.3g}; they die out with dt below {low:.2g} s"
    )


def _growth(method: str, law: Law, constants: Constants, dt: float) -> float:
    """Return the largest magnitude of the eigenvalues of one step, at rest on the reference."""
    at_rest = Course(*(np.zeros((3, 3)) for _ in range(3)))
    resting = constants._replace(wraps=False)

    def after(state: Array) -> Array:
        notes = np.full((COLUMNS, 2), np.inf)
        made = run_plain(method, law, at_rest, resting, np.array([dt]), state, notes)
        return notes[:6, 1] if made else np.full(6, np.inf)

    ends = [(after(d), after(-d)) for d in _NUDGE * np.eye(6)]
    if not np.isfinite(ends).all():
        return np.inf
    step = np.stack([(end - other) / (2 * _NUDGE) for end, other in ends], axis=-1)
    return float(np.abs(np.linalg.eigvals(step)).max())
