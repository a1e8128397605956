"""Whether small errors die out: the discrete loop, linearised at rest."""

from __future__ import annotations

import numpy as np

from trundle.motion import Course
from trundle.se2 import Array
from trundle.simulation.tracking.compiled import Constants, run_plain
from trundle.simulation.tracking.laws import Law
from trundle.simulation.tracking.loops import COLUMNS

_NUDGE = 1e-6  # of pose and twist, far above rounding and far below where the loop bends
# Errors that neither grow nor die (a gain of zero) multiply by 1, and central differences are good
# to about ten digits.
_GROWS = 1 + 1e-7
# Where not even this share of the step is stable, the gains are not.
_SHORT = 1e-4
_HALVINGS = 40


def instability(method: str, law: Law, constants: Constants, dt: float) -> str:
    """Return why the loop of a method with step dt [s] is unstable, or ""."""
    growth = _growth(method, law, constants, dt)
    if growth <= _GROWS:
        return ""
    if _growth(method, law, constants, _SHORT * dt) > _GROWS:
        return "these gains are unstable at any step: small errors grow instead of dying out"
    low, high = _SHORT * dt, dt
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
    resting = constants._replace(wraps=0.0)

    def after(state: Array) -> Array:
        notes = np.full((COLUMNS, 2), np.inf)
        run_plain(method, law, at_rest, resting, np.array([dt]), state, notes)
        return notes[:6, 1]

    nudges = _NUDGE * np.eye(6)
    step = np.stack([(after(d) - after(-d)) / (2 * _NUDGE) for d in nudges], axis=-1)
    if not np.isfinite(step).all():
        return np.inf
    return float(np.abs(np.linalg.eigvals(step)).max())
