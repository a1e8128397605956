"""What rollouts refuse, and what they say: every message in the user's words, before any work."""

import dataclasses
import functools
import importlib.util
import math
from typing import Any

import numpy as np
import pytest

import trundle
from trundle import Constant, Every, Policy, Stream, Tracking, compile_rollout, load, motion
from trundle.control import PD, Kanayama
from trundle.errors import OffCentreError, ShapeError, TrundleError
from trundle.simulation.rollout import memory

needs_numba = pytest.mark.skipif(
    importlib.util.find_spec("numba") is None, reason="numba is not installed"
)

DIFFERENTIAL, MECANUM, ACKERMANN = load("differential"), load("mecanum"), load("ackermann")
TWO = Constant([1.0, 2.0])
FOUR_ROBOTS = Constant(np.ones((4, 2)))


def refused(
    message: str, *args: Any, error: type[TrundleError] = TrundleError, **given: Any
) -> None:
    """Check that a rollout of a differential robot is refused with a message."""
    robot, commands = args if len(args) == 2 else (DIFFERENTIAL, *(args or (TWO,)))
    given = {"dt": 0.1, "device": "numpy"} | given
    if not isinstance(commands, Stream) and "steps" not in given:
        given["steps"] = 3
    with pytest.raises(error, match=message) as caught:
        trundle.rollout(robot, commands, **given)
    assert "\n" not in str(caught.value)


# ---- commands --------------------------------------------------------------------------------

NO_NUMBERS = ("abc", object(), {}, [[1, 2], [3]], np.array(["a"]), 1j * np.ones(2), [True, False])


@pytest.mark.parametrize("given", NO_NUMBERS, ids=lambda given: type(given).__name__)
def test_what_is_no_array_of_numbers(given):
    for made in (Constant, Stream, Stream.wheels_first):
        with pytest.raises(ShapeError, match="wheel_speeds must be an array of numbers, got"):
            made(given)
        with pytest.raises(ShapeError, match="twist must be an array of numbers, got"):
            made(twist=given)
    with pytest.raises(ShapeError, match="sigma must be an array of numbers"):
        TWO.with_noise(given, seed=1)
    with pytest.raises(ShapeError, match="parameters must be an array of numbers"):
        Policy(straight, parameters=given)
    refused("pose must be an array of numbers", pose=given)
    refused("radius must be an array of numbers", parameters={"radius": given})
    refused("out must be an array of float64 with shape", out=given)


@pytest.mark.parametrize("given", [[[1.0, 2.0]], np.ones(2), None, Constant, 5, "differential"])
def test_commands_must_say_what_they_are(given):
    refused(r"Constant\(...\) for each robot's own, Stream\(...\)", given)


def test_a_robot_must_be_one():
    refused(r"a Robot is needed, such as trundle.load\('omni3'\)", "differential", TWO)


def test_either_wheel_speeds_or_twists():
    for given in ({}, {"wheel_speeds": [1, 2], "twist": [1, 2, 3]}):
        with pytest.raises(TrundleError, match="give either wheel_speeds or twist"):
            Constant(**given)
    with pytest.raises(TrundleError, match="steering follows from the twist: leave it out"):
        Stream(twist=np.ones((2, 3)), steering=np.ones((2, 2)))


@pytest.mark.parametrize(
    ("made", "shape", "message"),
    [
        (Constant, (), r"shape \(N, k\) or \(k,\), got \(\)"),
        (Constant, (2, 3, 2), r"shape \(N, k\) or \(k,\), got \(2, 3, 2\)"),
        (Stream, (2,), r"shape \(T, N, k\) or \(T, k\), got \(2,\)"),
        (Stream, (2, 2, 2, 2), r"shape \(T, N, k\) or \(T, k\)"),
        (Stream.wheels_first, (3, 2), r"shape \(T, k, N\), got \(3, 2\)"),
    ],
)
def test_shapes_of_commands(made, shape, message):
    with pytest.raises(ShapeError, match=message):
        made(np.zeros(shape))


@pytest.mark.parametrize(
    "commands", [Constant(np.ones(3)), Stream(np.ones((5, 2, 3))), Constant([]), Stream([[]])]
)
def test_a_command_has_a_value_for_each_wheel(commands):
    refused(
        r"wheel_speeds of robot 'differential' must have 2 values for each robot, the speeds of "
        r"left, right, got",
        commands, error=ShapeError,
    )  # fmt: skip


def test_a_twist_has_three_values():
    refused(
        r"twist of robot .* 3 values for each robot, \(u, v, r\), got 2", Constant(twist=[1, 2])
    )


@pytest.mark.parametrize("commands", [Constant(np.ones((0, 2))), Stream(np.ones((3, 0, 2)))])
def test_commands_of_no_robot(commands):
    refused("commands has 0 robots", commands, error=ShapeError)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_commands_that_are_no_numbers(bad, dtype):
    place = "value 0 of robot 1 in step 0 is "
    speeds = [[1.0, 2.0], [bad, 1.0]]
    for steps in (3, 100):  # long ones are taken to chords beforehand
        refused("must be finite numbers", Constant(speeds), steps=steps, dtype=dtype)
    refused(place, Constant(speeds), dtype=dtype)
    refused("value 0 of robot 0 in step 1", Stream(speeds), dtype=dtype)
    refused("finite", Constant(twist=[0.0, 0.0, bad]), dtype=dtype)
    speeds = np.ones(len(ACKERMANN.driven))
    refused(
        "steering must be finite numbers", ACKERMANN, Constant(speeds, steering=[bad, 0.0]),
        dtype=dtype,
    )  # fmt: skip
    refused("finite", ACKERMANN, Constant(bad * speeds, steering=[0.0, 0.0]), dtype=dtype)


def test_commands_that_a_float_cannot_hold():
    refused("finite", Constant([1e40, 1.0]), dtype="float32")
    refused("outgrew every number", Constant([1e308, -1e308]), dt=1e10)


@needs_numba
def test_commands_that_are_no_numbers_compiled():
    refused("value 0 of robot 0 in step 1 is nan", Stream([[1, 2], [math.nan, 1]]), device="cpu")
    prepared = compile_rollout(DIFFERENTIAL, Stream([[1.0, 2.0], [1.0, 1.0]]), dt=0.1)
    with pytest.raises(TrundleError, match="value 1 of robot 0 in step 0 is inf"):
        prepared([[1.0, math.inf], [1.0, 1.0]])


# ---- steering and driving --------------------------------------------------------------------


def test_steering_beside_the_speeds():
    speeds = np.ones(len(ACKERMANN.driven))
    names = ", ".join(wheel.name for wheel in ACKERMANN.steered)
    refused(f"give steering, the angles of {names}", ACKERMANN, Constant(speeds))
    refused(
        r"must have 2 angles for each robot, got 3", ACKERMANN, Constant(speeds, steering=[0] * 3)
    )
    refused("does not steer: leave out steering", Constant([1.0, 2.0], steering=[0.0]))
    refused(
        "do not go with steering", ACKERMANN,
        Constant(np.ones((2, len(speeds))), steering=np.zeros((3, 2))),
    )  # fmt: skip
    refused(
        "do not go with steering", ACKERMANN,
        Stream(np.ones((4, len(speeds))), steering=np.zeros((3, 2))),
    )  # fmt: skip


def test_steering_without_a_common_centre():
    steering = np.zeros((3, 5, 2))
    steering[2, 3] = 0.3, -0.3
    refused(
        "share no instantaneous centre", ACKERMANN,
        Stream(np.ones((3, 5, len(ACKERMANN.driven))), steering=steering), error=OffCentreError,
    )  # fmt: skip


def test_more_than_one_motion_at_given_angles():
    robot = load("omni_steer")
    speeds = np.ones(len(robot.driven))
    refused(r"take twists of it, Constant\(twist=...\)", robot, Constant(speeds, steering=[0.0]))


def test_too_few_driven_wheels():
    omni = undriven(MECANUM, 1, 2, 3)
    refused("too few driven wheels: nothing drives", omni, Constant([1.0]))
    refused("too few driven wheels: nothing drives", omni, Constant(twist=[1.0, 0.0, 0.0]))
    refused("has no driven wheel", undriven(omni, 0), Constant([1.0]))


def undriven(robot: trundle.Robot, *places: int) -> trundle.Robot:
    wheels = [
        dataclasses.replace(wheel, driven=wheel.driven and i not in places)
        for i, wheel in enumerate(robot.wheels)
    ]
    return dataclasses.replace(robot, wheels=tuple(wheels))


# ---- time, method, type, device, save --------------------------------------------------------


@pytest.mark.parametrize("dt", [0, -0.1, math.nan, math.inf, "x", None, True, 1j, [0.1]])
def test_a_step_is_positive(dt):
    refused("dt must be a positive number of seconds", dt=dt)


@pytest.mark.parametrize("steps", [-1, 1.5, "x", True, 2.0, [3], math.nan])
def test_steps_are_counted(steps):
    refused("steps must be a whole number from 0 on", steps=steps)


def test_steps_that_are_missing_or_do_not_match():
    refused("give steps: these commands do not tell how long", steps=None)
    refused("steps is 4, and the commands have rows for 3", Stream(np.ones((3, 2))), steps=4)
    refused("steps is 4, and the commands have rows for 1", Stream(np.ones((1, 2))), steps=4)


@pytest.mark.parametrize("wrong", ["Exact", "midpoint", None, 3, [], {}])
def test_unknown_methods_types_devices_and_ways_to_save(wrong):
    refused("method must be one of exact, euler, rk4, got", method=wrong)
    refused("dtype must be 'float64' or 'float32', got", dtype=wrong)
    refused("device must be one of auto, numpy, cpu, cuda, got", device=wrong)
    refused(r"save must be 'final', 'trajectory', Every\(k\)", save=wrong)


def test_what_looks_like_a_choice():
    refused("dtype must be", dtype=np.dtype("float32"))
    refused("save must be", save=np.array(["final"]))
    refused("save must be", save=Every)


@pytest.mark.parametrize("steps", [0, -1, 1.5, "x", True, None])
def test_every_counts_steps(steps):
    with pytest.raises(TrundleError, match="Every needs a whole number of steps from 1 on"):
        Every(steps)
    assert Every(np.int64(2)).rows(4) == 3


def test_a_gpu_that_is_not_there():
    try:
        from numba import cuda

        if cuda.is_available():
            pytest.skip("there is a GPU")
    except ImportError:
        pass
    refused("device 'cuda' (needs an NVIDIA GPU|compiles its loops with numba-cuda)", device="cuda")


# ---- starts, out and memory ------------------------------------------------------------------


def test_shapes_of_starts():
    refused("pose has 5 robots|commands has 4 robots", FOUR_ROBOTS, pose=np.zeros((5, 3)))
    refused("pose must have 3 values on the last axis", pose=np.zeros(4))
    refused(r"pose must be \(3,\), or \(N, 3\)", pose=np.zeros((2, 2, 3)))
    refused(r"of at least one robot, got \(0, 3\)", pose=np.zeros((0, 3)))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_starts_are_finite(bad):
    refused("pose must be finite numbers", pose=[0.0, bad, 0.0])
    prepared = compile_rollout(DIFFERENTIAL, TWO, dt=0.1, steps=2, device="numpy")
    with pytest.raises(ShapeError, match="pose must be finite numbers"):
        prepared(pose=[0.0, bad, 0.0])


def read_only() -> Any:
    out = np.zeros((3, 4))
    out.flags.writeable = False
    return out


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (np.zeros((4, 3)), r"float64 with shape \(3, 4\), got float64 \(4, 3\)"),
        (np.zeros((3, 4), np.float32), r"float64 with shape \(3, 4\), got float32"),
        (np.zeros((3, 4), int), "got int64"),
        (np.zeros((3, 4), ">f8"), "got >f8"),
        (np.zeros((3, 4), order="F"), "contiguous in C order, and writeable"),
        (np.zeros((3, 8))[:, ::2], "contiguous in C order, and writeable"),
        (read_only(), "contiguous in C order, and writeable"),
        ([[0.0] * 4] * 3, r"got \[\[0.0"),
    ],
)
def test_out_must_fit(out, message):
    refused(message, FOUR_ROBOTS, out=out, error=ShapeError)


def test_out_for_a_trajectory():
    message = r"float32 with shape \(2, 3, 4\), got float32 \(3, 4\)"
    out = np.zeros((3, 4), np.float32)
    refused(message, FOUR_ROBOTS, out=out, save=Every(2), dtype="float32", error=ShapeError)


def test_more_memory_than_there_is(monkeypatch):
    monkeypatch.setattr(memory, "available_memory", lambda: 10**9)
    size = r"would take 96\.0 GB of memory, and 1\.0 GB are available: keep Every\(k\) steps"
    refused(size, steps=4 * 10**9, save="trajectory")
    refused(r"32\.0 GB", steps=4 * 10**9, save=Every(3))
    refused("steps must be at most", steps=10**13)


def test_memory_is_asked_for_before_it_is_taken(monkeypatch):
    monkeypatch.setattr(memory, "available_memory", lambda: 10_000)
    refused(r"would take 24\.0 kB of memory, and 10\.0 kB are available", steps=1000,
            save="trajectory")  # fmt: skip
    trundle.rollout(
        DIFFERENTIAL, TWO, dt=0.1, steps=1000, save="trajectory", device="numpy",
        out=np.empty((1001, 3, 1)),
    )  # fmt: skip


def test_sizes_in_words():
    assert memory.in_words(1_500_000_000) == "1.5 GB"
    assert memory.in_words(999) == "999 bytes"


# ---- noise -----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [-1, 1.5, "x", None, True])
def test_seeds_are_whole_numbers(seed):
    with pytest.raises(TrundleError, match="seed must be a whole number from 0 on"):
        TWO.with_noise(0.1, seed=seed)
    prepared = compile_rollout(
        DIFFERENTIAL, TWO.with_noise(0.1, seed=1), dt=0.1, steps=2, device="numpy"
    )
    if seed is not None:  # which is the first one's
        with pytest.raises(TrundleError, match="seed must be a whole number from 0 on"):
            prepared(seed=seed)


def test_sigma_is_a_spread():
    with pytest.raises(TrundleError, match=r"sigma must not be negative, got -0\.1"):
        TWO.with_noise([0.1, -0.1], seed=1)
    for bad in (math.nan, math.inf):
        with pytest.raises(ShapeError, match="sigma must be finite numbers"):
            TWO.with_noise(bad, seed=1)
    refused(r"sigma must be one number, \(2,\) or \(N, 2\)", TWO.with_noise([1, 2, 3], seed=1))
    refused("sigma has 5", FOUR_ROBOTS.with_noise(np.ones((5, 2)), seed=1))


# ---- what robots differ in -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"raduis": [0.1]}, "no wheel has such a number: did you mean 'radius'"),
        ({"wheel_base": [0.1]}, "did you mean 'wheelbase'"),
        ({"lefd.radius": [0.1]}, "no wheel is called 'lefd': did you mean 'left'"),
        ({"left.name": [0.1]}, "parameter 'left.name': no wheel has such a number"),
        ({"": [0.1]}, "parameter '': no wheel has such a number"),
        ({3: [0.1]}, "parameters have names such as 'radius', got 3"),
        ({"radius": [0.1, -0.05]}, "wheel 'left': radius must be positive, got -0.05 m"),
        ({"radius": [0.0]}, "radius must be positive, got 0 m"),
        ({"radius": [math.nan]}, "radius must be finite numbers"),
        ({"radius": 0.1}, r"parameter 'radius' must have shape \(N,\), got \(\)"),
        ({"radius": [[0.1]]}, r"parameter 'radius' must have shape \(N,\), got \(1, 1\)"),
        ({"radius": []}, r"parameter 'radius' must have shape \(N,\), got \(0,\)"),
        ({"track": [0.4, 0.0]}, "parameter 'track' must be positive, got 0 m"),
        ({"radius": [1, 2], "track": [1, 2, 3]}, "'radius' has 2 robots, and 'track' has 3"),
        ({"com": [0.1, 0.2]}, r"parameter 'com' must have shape \(N, 2\)"),
        ({"com": [[1, 2, 3]]}, "com must have 2 values on the last axis"),
        ({"mass": [-1.0]}, "mass must be positive, got -1 kg"),
        ([("radius", [0.1])], "parameters must be a dictionary such as"),
        ("radius", "parameters must be a dictionary such as"),
    ],
)  # fmt: skip
def test_parameters_that_do_not_fit(given, message):
    refused(message, parameters=given)


def test_parameters_of_another_number_of_robots():
    refused(
        "what the robots differ in has 2 robots, and commands has 4|has 4", FOUR_ROBOTS,
        parameters={"radius": [0.1, 0.2]}, error=ShapeError,
    )  # fmt: skip


# ---- policies --------------------------------------------------------------------------------


def straight(t, pose, parameters):  # noqa: ARG001
    return 1.0, 1.0


def one_number(t, pose, parameters):  # noqa: ARG001
    return (1.0,)


def no_tuple(t, pose, parameters):  # noqa: ARG001
    return 1.0


def a_list(t, pose, parameters):  # noqa: ARG001
    return [1.0, 2.0]


def words(t, pose, parameters):  # noqa: ARG001
    return "fast", "slow"


def nothing(t, pose, parameters):
    pass


def complex_numbers(t, pose, parameters):  # noqa: ARG001
    return 1j, 1.0


def unknown_name(t, pose, parameters):  # noqa: ARG001
    return gain * pose[0], 1.0  # noqa: F821


def three_parameters(t, pose, parameters):  # noqa: ARG001
    a, b, _ = parameters
    return a, b


def tired(t, pose, parameters):  # noqa: ARG001
    if t > 0.15:
        raise ValueError("that is enough")
    return 1.0, 1.0


def roots(t, pose, parameters):  # noqa: ARG001
    return math.sqrt(pose[0] - 1.0), 1.0


class Method:
    def step(self, t, pose, parameters):
        return 1.0, 1.0

    def __call__(self, t, pose, parameters):
        return self.step(t, pose, parameters)


@pytest.mark.parametrize(
    "step",
    [5, None, "x", Method, Method(), Method().step, functools.partial(straight, t=0.0), math.sin],
    ids=lambda each: type(each).__name__,
)
def test_a_policy_is_a_plain_function(step):
    with pytest.raises(TrundleError, match=r"a plain Python function \(t, pose, parameters\)"):
        Policy(step)


def test_a_policy_takes_three_arguments():
    for step in (lambda _: 1.0, lambda _, __: 1.0, lambda _, __, ___, ____: 1.0):
        with pytest.raises(TrundleError, match=r"<lambda> must take \(t, pose, parameters\)"):
            Policy(step)


def test_a_policy_s_output_and_parameters():
    with pytest.raises(TrundleError, match="output must be 'wheel_speeds' or 'twist', got 'speed'"):
        Policy(straight, output="speed")
    with pytest.raises(ShapeError, match=r"parameters must be \(k,\) or \(N, k\)"):
        Policy(straight, parameters=np.zeros((1, 2, 3)))
    law = Policy(straight, parameters=np.zeros((3, 2)))
    refused("the law's parameters has 3 robots|pose has 4", law, pose=np.zeros((4, 3)))


WRONG = [
    (one_number, "policy 'one_number' must return a tuple of 2 numbers, got"),
    (no_tuple, "policy 'no_tuple' must return a tuple of 2 numbers, got"),
    (a_list, "policy 'a_list' must return a tuple of 2 numbers, got"),
    (words, "policy 'words' must return a tuple of 2 numbers, got"),
    (nothing, "policy 'nothing' must return a tuple of 2 numbers, got"),
    (complex_numbers, "policy 'complex_numbers' must return a tuple of 2 numbers, got"),
    (unknown_name, "policy 'unknown_name'.*name 'gain' is not defined"),
    (three_parameters, "policy 'three_parameters'.*(wrong tuple length|not enough values)"),
]


@pytest.mark.parametrize("device", ["numpy", pytest.param("cpu", marks=needs_numba)])
@pytest.mark.parametrize(("step", "message"), WRONG, ids=[step.__name__ for step, _ in WRONG])
def test_policies_that_cannot_be_used(device, step, message):
    refused(message, Policy(step), device=device, pose=np.ones((2, 3)))


@pytest.mark.parametrize("device", ["numpy", pytest.param("cpu", marks=needs_numba)])
def test_policies_that_fail_on_the_way(device):
    refused("policy.* ValueError: that is enough", Policy(tired), device=device)


@pytest.mark.parametrize("device", ["numpy", pytest.param("cpu", marks=needs_numba)])
def test_policies_that_give_no_numbers(device):
    refused("or its law gave no number", Policy(roots), device=device)


# ---- the prepared call -----------------------------------------------------------------------


def test_what_a_prepared_call_refuses():
    prepared = compile_rollout(DIFFERENTIAL, FOUR_ROBOTS, dt=0.1, steps=2, device="numpy")
    with pytest.raises(ShapeError, match="must have the shape of the first ones: got"):
        prepared(np.ones((5, 2)))
    with pytest.raises(ShapeError, match=r"constant commands must have shape"):
        prepared(np.ones((2, 4, 2)))
    with pytest.raises(ShapeError, match="commands must be an array of numbers"):
        prepared("fast")
    with pytest.raises(ShapeError, match=r"pose must be of 4 robots, got \(5, 3\)"):
        prepared(pose=np.zeros((5, 3)))
    with pytest.raises(TrundleError, match="neither a law nor a reducer takes parameters"):
        prepared(parameters=[1.0])
    law = compile_rollout(
        DIFFERENTIAL, Policy(straight, parameters=[1.0]), dt=0.1, steps=2, device="numpy"
    )
    with pytest.raises(ShapeError, match="parameters must have the shape of the first"):
        law(parameters=[1.0, 2.0])
    with pytest.raises(TrundleError, match="only wheel speeds or twists that were given"):
        law(np.ones((4, 2)))


# ---- tracking --------------------------------------------------------------------------------

CIRCLE = motion.circle(radius=3.0, rate=0.1)
LAW = PD([9, 9, 1], [9, 9, 1])


def test_controllers_that_rollouts_cannot_compile():
    for given in (Kanayama(1.0, 1.0, 1.0), None, "PD", [], [LAW, 5]):
        with pytest.raises(TrundleError, match="controller must be one that rollouts can compile"):
            Tracking(CIRCLE, given)


def test_what_tracking_refuses():
    omni = load("omni3").with_body(mass=30.0, inertia=0.5, com=(0.0, 0.0))
    refused("give steps: a trajectory is sampled at every step", omni, Tracking(CIRCLE, LAW),
            steps=None)  # fmt: skip
    refused("leave out 'euler'", omni, Tracking(CIRCLE, LAW), method="euler")
    with pytest.raises(TrundleError, match="takes no noise"):
        Tracking(CIRCLE, LAW).with_noise(0.1, seed=1)
    refused("steers: rollouts by the dynamics", ACKERMANN, Tracking(CIRCLE, LAW))
    refused(
        r"desired numbers must be \(T, 9\) or \(T, N, 9\)", omni, Tracking(np.ones((4, 3)), LAW)
    )
    refused("steps is 3, and the commands have rows for 4", omni, Tracking(np.ones((4, 9)), LAW))
    bad = np.ones((3, 9))
    bad[1, 4] = math.nan
    refused("desired numbers must be finite", omni, Tracking(bad, LAW))
    two, five = [LAW, LAW], np.zeros((5, 3))
    refused(r"has \d robots, and .* has \d", omni, Tracking(CIRCLE, two), pose=five)
