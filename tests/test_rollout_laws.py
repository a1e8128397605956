"""Laws that users write: whole numbers beside floats, numbers that are none, what they read."""

import importlib.util
import math

import numpy as np
import pytest

import trundle
from trundle import Policy, Stream, TrundleError, compile_rollout, load, rollout

needs_numba = pytest.mark.skipif(
    importlib.util.find_spec("numba") is None, reason="numba is not installed"
)
DEVICES = ["numpy", pytest.param("cpu", marks=needs_numba)]
# One step of one second straight on, in single precision, of numbers below ten.
ROUNDING = 1e-5
GAIN = 1.0


def go(law, device, **given):
    policy = Policy(law, output="twist", **given)
    made = rollout(load("mecanum"), policy, dt=1.0, steps=1, dtype="float32", device=device)
    return made.pose[0]


def whole_numbers(_t, _pose, parameters):
    (q,) = parameters
    first = np.maximum(1, q) - 2 * np.minimum(2, q) + np.where(q > 9, 0, q)
    return first + math.log(2) * q, np.where(q > 0, -1, 0.5) + np.hypot(3, q), 0


@pytest.mark.parametrize("device", DEVICES)
def test_whole_numbers_beside_floats_are_not_cut_off(device):
    q = 1.7
    wanted = q - 2 * q + q + 0.6931471805599453 * q, -1 + (9 + q * q) ** 0.5, 0.0
    assert go(whole_numbers, device, parameters=[q]) == pytest.approx(wanted, abs=ROUNDING)


@pytest.mark.parametrize("device", DEVICES)
def test_a_law_that_gives_no_number_is_told(device):
    with pytest.raises(TrundleError, match="gave no number"):
        go(lambda _t, _pose, _parameters: (np.minimum(math.nan, 1.0), 0.0, 0.0), device)


def by_a_global(_t, _pose, _parameters):
    return GAIN, 0.0, 0.0


@pytest.mark.parametrize("device", DEVICES)
def test_what_a_law_reads_may_change_between_rollouts(device, monkeypatch):
    assert go(by_a_global, device)[0] == 1.0
    monkeypatch.setitem(globals(), "GAIN", 5.0)
    assert go(by_a_global, device)[0] == 5.0


@needs_numba
def test_a_wide_turn_begins_again_where_the_poses_were_though_out_lies_there():
    turning = np.array([[[-1.0, 1.0, -1.0, 1.0]]] * 3)
    run = compile_rollout(load("mecanum"), Stream(turning), dt=0.1, save="trajectory")
    first = run()
    start = first.pose[-1].copy()
    fast = 400 * turning
    got = run(fast, pose=first.pose[-1], out=first.buffer).pose[-1, 0]
    speed = trundle.Kinematics(load("mecanum")).forward(fast[0, 0])[2]
    assert got[2] == pytest.approx(start[0, 2] + 0.3 * speed, abs=1e-9)
