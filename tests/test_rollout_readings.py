"""One step, four readers: plain floats, numpy, numba, and a GPU's kernels as numba simulates them.

The plain reading is the yardstick: Python's own arithmetic, robot by robot, written below. The
functions that readers bring along, polynomials and random numbers, are held against mpmath, against
the generator's authors and against the normal distribution.
"""

import importlib.util
import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy import stats

import trundle
from trundle.errors import TrundleError
from trundle.simulation.arithmetic import (
    LARGEST_SQUARE,
    PLAIN,
    array_arithmetic,
    compiled_arithmetic,
)
from trundle.simulation.rollout import arrays, cpu
from trundle.simulation.rollout import cuda as gpu
from trundle.simulation.rollout.intrinsics import read_bits
from trundle.simulation.rollout.loop import Arguments
from trundle.simulation.rollout.motions import Chord, Linear
from trundle.simulation.rollout.random import key_words, make_normals, make_threefry
from trundle.simulation.rollout.recipe import Recipe, make_advance

needs_numba = pytest.mark.skipif(
    importlib.util.find_spec("numba") is None, reason="numba is not installed"
)
needs_numba_cuda = pytest.mark.skipif(
    importlib.util.find_spec("numba_cuda") is None, reason="numba-cuda is not installed"
)
DTYPES = ("float64", "float32")

# After six steps of robots within metres of the origin: some dozens of roundings of numbers below
# 10, each reader in its own order, with polynomials that are as good as a rounding.
ROUNDING = {"float64": 1e-13, "float32": 3e-6}


# ---- the cases, each as a loop takes it ------------------------------------------------------

ROBOTS, STEPS, SEED = 5, 6, 2**100 + 17
DT = 0.1


class Circling:
    """A feedback law that keeps a distance from the origin: the parameters are speed and gain."""

    constants = 2

    def make(self, m, jit):
        """Return (t, pose, constants) -> a twist."""
        sqrt, cos, one = m.sqrt, m.cos, m.number(1.0)
        where, least, most = m.where, m.minimum, m.maximum

        @jit
        def law(t, pose, constants):  # noqa: ARG001
            far = sqrt(pose[0] * pose[0] + pose[1] * pose[1])
            turn = constants[1] * most(least(far - one, one), -one)
            return constants[0] * cos(pose[2]), where(far > one, turn, -turn), turn

        return law


CIRCLING = Circling()


def linear(method, count, spread):
    """Return the motion of a mecanum robot, its constants, and whether each robot has its own."""
    matrix = trundle.Kinematics(trundle.load("mecanum")).W if count == 4 else np.eye(3)
    constants = (DT * matrix * [[1.0], [1.0], [0.5]]).ravel()
    return Linear(count, method), constants * (1 + spread)


def cases():
    """Return {name: (recipe, arguments)}, the same in every process."""
    rng = np.random.default_rng(11)
    speeds = rng.normal(0.0, 40.0, (STEPS, 4, ROBOTS))
    tolerances = rng.normal(0.0, 0.01, (12, ROBOTS))
    poses = rng.normal(0.0, 1.0, (3, ROBOTS))
    found = {}

    def add(name, recipe, commands, shared=(), own=(), every=0):
        for dtype in DTYPES:
            made = replace(recipe, dtype=dtype, keeps=every > 0)
            state = np.zeros((made.state, ROBOTS), dtype)
            state[:3] = poses
            given = Arguments(
                first=0,
                steps=STEPS,
                commands=np.array(commands, dtype),
                moving=int(len(commands) > 1),
                shared=np.array(shared, dtype),
                own=np.array(own, dtype).reshape(-1, ROBOTS),
                table=np.zeros(0, dtype),
                key=np.array(key_words(SEED), np.uint32),
                state=state,
                every=every,
                out=np.full((STEPS // every + 1 if every else 0, 3, ROBOTS), -1.0, dtype),
                sums=np.zeros((1, 0, 13)),
                summed=0,
            )
            found[f"{name}-{dtype}"] = made, given

    for method in ("exact", "euler", "rk4"):
        motion, constants = linear(method, 4, 0.0)
        add(method, Recipe("", 4, 4, (False,) * 12, motion), speeds, constants, every=1)
    add("constant", Recipe("", 3, 3, (), Chord()), speeds[:1, :3] * 0.01, every=2)
    motion, constants = linear("exact", 4, 0.0)
    add("common", Recipe("", 4, 4, (False,) * 12, motion, common=True), speeds[:, :, :1], constants)
    own = constants[:, None] * (1 + tolerances)
    sigma = np.array([0.1, 0.2, 0.3, 0.4])
    noisy = Recipe("", 4, 4, (False,) * 4 + (True,) * 12, motion, noisy=True)
    add("noisy", noisy, speeds[:1], sigma, own, every=4)
    motion, constants = linear("euler", 3, 0.0)
    add(
        "policy",
        Recipe("", 0, 3, (True, False) + (False,) * 9, motion, law=CIRCLING),
        np.zeros((1, 0, 1)),
        np.concatenate([[2.0], constants]),
        rng.uniform(0.5, 1.0, (1, ROBOTS)),
        every=1,
    )
    return found


CASES = cases()
each_case = pytest.mark.parametrize("name", CASES)


def as_is(function):
    return function


def plain(recipe, given):
    """Advance one robot after the other in Python's floats."""
    advance = make_advance(recipe, PLAIN, as_is)
    normals = make_normals(recipe.noise, PLAIN, as_is) if recipe.noisy else None
    for i in range(given.state.shape[1]):
        shared, own = iter(given.shared.tolist()), iter(given.own[:, i].tolist())
        constants = tuple(next(own) if each else next(shared) for each in recipe.own)
        state = tuple(given.state[:, i].tolist())
        for t in range(given.first, given.first + given.steps):
            row = given.commands[t * given.moving]
            command = tuple(row[:, min(i, row.shape[1] - 1)].tolist())
            noise = normals([int(word) for word in given.key], i, t) if normals else ()
            state, _ = advance(t, state, command, noise, constants, None)
            if given.every and (t + 1) % given.every == 0:
                given.out[(t + 1) // given.every, :, i] = state[:3]
        given.state[:, i] = state
    return False


def outcome(run, name, **changes):
    """Return the final poses and the poses that are kept, of one reader."""
    recipe, given = CASES[name]
    given = given._replace(state=given.state.copy(), out=given.out.copy(), **changes)
    run(recipe, given)
    return given.state[:3], given.out


def assert_agree(got, name):
    wanted = outcome(plain, name)
    tolerance = ROUNDING[CASES[name][0].dtype]
    for mine, theirs in zip(got, wanted, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=tolerance)


# ---- the readers agree -----------------------------------------------------------------------


def test_the_plain_reading_is_the_step_of_the_package():
    _, given = CASES["exact-float64"]
    final, kept = outcome(plain, "exact-float64")
    rows = given.shared.reshape(3, 4) * [[1.0], [1.0], [2.0]]
    for i in range(ROBOTS):
        pose = tuple(given.state[:3, i])
        for t in range(STEPS):
            pose = trundle.se2.step(*pose, *(rows @ given.commands[t, :, i]))
            np.testing.assert_allclose(kept[t + 1, :, i], pose, rtol=0, atol=ROUNDING["float64"])
        np.testing.assert_array_equal(final[:, i], kept[-1, :, i])


def test_the_cases_can_tell_methods_and_noise_apart():
    exact, euler, rk4 = (outcome(plain, f"{name}-float64")[0] for name in ("exact", "euler", "rk4"))
    assert np.abs(exact - euler).max() > 1e-2
    # The classical method's local error is of fifth order: 0.2 rad per step leave little.
    assert 1e-7 < np.abs(exact - rk4).max() < 1e-2
    recipe, given = CASES["noisy-float64"]
    still = given._replace(state=given.state.copy(), out=given.out.copy(), key=given.key + 1)
    plain(recipe, still)
    assert np.abs(still.state[:3] - outcome(plain, "noisy-float64")[0]).max() > 1e-3


@each_case
def test_numpy_agrees(name):
    assert_agree(outcome(arrays.run, name), name)


# Compiling takes seconds: each method, source of commands and type once.
COMPILED = ["exact-float64", "rk4-float32", "constant-float32", "noisy-float32", "policy-float64"]


@needs_numba
@pytest.mark.parametrize("name", COMPILED)
def test_numba_agrees(name):
    assert_agree(outcome(lambda recipe, given: cpu.make_run(recipe)(given), name), name)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Return what the kernels for a GPU give: numba must simulate from its first import on."""
    path = tmp_path_factory.mktemp("simulated") / "outcomes.npz"
    run_simulated("write_simulated", path)
    with np.load(path) as file:
        return dict(file)


def run_simulated(function, *args):
    """Run a function of this file in a process in which numba simulates a GPU."""
    here = Path(__file__)
    paths = [str(here.parent), str(Path(trundle.__file__).parents[1])]
    code = f"import {here.stem} as tests; tests.{function}(*{[str(arg) for arg in args]!r})"
    run = subprocess.run(
        # The words of the random numbers wrap around, which numpy's scalars remark on.
        [sys.executable, "-W", "error", "-W", "ignore:overflow:RuntimeWarning", "-c", code],
        env=os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, run.stderr


def write_simulated(path):
    gpu.check()
    found = {}
    for name in CASES:
        found[f"{name} final"], found[f"{name} kept"] = outcome(gpu.run, name)
    np.savez(path, **found)


@needs_numba_cuda
@each_case
def test_the_kernel_for_a_gpu_agrees(simulated, name):
    assert_agree((simulated[f"{name} final"], simulated[f"{name} kept"]), name)


@needs_numba_cuda
def test_the_kernel_in_slices_and_kept_on_the_device():
    run_simulated("check_slices")


def check_slices():
    """In pieces of two steps, from the host or the device, the same numbers come out."""
    from numba import cuda

    for name in ("exact-float64", "noisy-float64", "policy-float64"):
        recipe, given = CASES[name]
        final, kept = outcome(gpu.run, name)
        gpu._AT_ONCE = 2 * max(given.commands[0].nbytes, 3 * 8 * ROBOTS)
        got = outcome(gpu.run, name)
        np.testing.assert_array_equal(got[0], final)
        np.testing.assert_array_equal(got[1], kept)
        # What PreparedRollout does, to hear an interrupt: some steps, and then the others.
        begun = given._replace(state=given.state.copy(), out=given.out.copy())
        gpu.run(recipe, begun._replace(steps=3))
        gpu.run(recipe, begun._replace(first=3, steps=STEPS - 3))
        np.testing.assert_array_equal(begun.state[:3], final)
        np.testing.assert_array_equal(begun.out, kept)
        there = cuda.to_device(given.out)
        begun = given._replace(state=given.state.copy(), out=there)
        gpu.run(recipe, begun)
        np.testing.assert_array_equal(begun.state[:3], final)
        np.testing.assert_array_equal(there.copy_to_host(), kept)
        np.testing.assert_array_equal(given.out, -1.0)  # nothing came to the host
        gpu._AT_ONCE = 2**28


@needs_numba_cuda
def test_a_user_s_rollout_on_the_gpu_and_its_trajectories_kept_there():
    run_simulated("check_rollout")


def check_rollout():
    from numba import cuda

    robot, speeds = trundle.load("mecanum"), trundle.Constant(np.arange(20.0).reshape(5, 4) / 5)
    given = {"dt": 0.1, "steps": 3, "save": "trajectory"}
    wanted = trundle.rollout(robot, speeds, **given, device="numpy")
    np.testing.assert_allclose(
        trundle.rollout(robot, speeds, **given, device="cuda").pose, wanted.pose, atol=1e-12
    )
    there = cuda.to_device(np.zeros((4, 3, 5)))
    kept = trundle.rollout(robot, speeds, **given, device="cuda", out=there)
    np.testing.assert_allclose(kept.pose.copy_to_host(), wanted.buffer, atol=1e-12)
    np.testing.assert_allclose(kept.final, wanted.final, atol=1e-12)
    with pytest.raises(TrundleError, match="out must be an array of float64"):
        trundle.rollout(robot, speeds, **given, device="cuda", out=cuda.to_device(np.zeros(4)))


@needs_numba_cuda
def test_too_little_memory_on_the_gpu_is_said_before_it_is_taken():
    run_simulated("check_memory")


def check_memory():
    from numba import cuda

    cuda.current_context().__class__.get_memory_info = lambda _: (1000, 2000)
    with pytest.raises(TrundleError, match=r"kB of the GPU's memory, and 1\.0 kB are free"):
        outcome(gpu.run, "exact-float64")


# ---- the kernel compiled for a GPU that is not there -----------------------------------------

# What CUDA's own sine does in doubles for angles beyond 1e5: it begins with an integer, so that no
# float is widened.
OF_LARGE_ANGLES = {".f64", "cvt.rn.f64.s64", "mul.f64", "cvt.rn.f32.f64"}


def ptx_of(recipe):
    """Return a kernel's assembly for a data centre's GPU."""
    from numba import cuda, types

    number, whole = getattr(types, recipe.dtype), types.int64
    one, two, three = (types.Array(number, ndim, "C") for ndim in (1, 2, 3))
    key = types.Array(types.uint32, 1, "C")
    signature = (
        *(whole, whole, three, whole, one, two, one, key, two, whole, whole, three),
    )  # fmt: skip
    try:
        ptx, _ = cuda.compile_ptx(gpu.make_kernel(recipe), signature, cc=(8, 0))
    except Exception as error:
        # Each release raises its own errors where libraries of CUDA are missing.
        if re.search(r"nvvm|nvrtc|libdevice", str(error), re.IGNORECASE):
            pytest.skip(f"CUDA's compiler is not installed: {str(error).splitlines()[0]}")
        raise
    return ptx


def doubles_in(ptx):
    return set(re.findall(r"[\w.]*\.f64[\w.]*", ptx))


@needs_numba_cuda
@pytest.mark.parametrize("name", ["exact", "constant", "noisy"])
def test_no_double_slows_a_kernel_of_floats(name):
    ptx = ptx_of(CASES[f"{name}-float32"][0])
    assert ".visible .entry" in ptx
    assert doubles_in(ptx) <= OF_LARGE_ANGLES
    # One thread's work is one piece: nothing is called, and no 64-bit remainder is taken.
    assert not re.search(r"\b(call|rem\.\w64|div\.\w64)\b", ptx)


class Widening(Circling):
    """A law with a literal, which is a double."""

    def make(self, m, jit):
        return jit(lambda t, pose, constants: (constants[0] * 0.3, pose[2], pose[2]))  # noqa: ARG005


@needs_numba_cuda
def test_doubles_would_be_seen():
    recipe = replace(CASES["policy-float32"][0], law=Widening())
    assert not doubles_in(ptx_of(recipe)) <= OF_LARGE_ANGLES


# ---- polynomials -----------------------------------------------------------------------------


def bits_of_arrays(values):
    """Return numbers as the integers that have their bits, and back."""
    kinds = {"f4": np.int32, "f8": np.int64, "i4": np.float32, "i8": np.float64}
    return values.view(kinds[values.dtype.str[1:]])


def in_numpy(dtype, wide=True):
    return compiled_arithmetic(dtype, as_is, bits_of_arrays, wide)


def spread(dtype, largest):
    """Return angles of both signs, evenly and by magnitude, and the hard ones beside k pi / 2."""
    rng = np.random.default_rng(5)
    quarters = np.arange(-200, 201) * (math.pi / 2)
    return np.concatenate(
        [
            rng.uniform(-math.pi, math.pi, 400),
            rng.choice([-1, 1], 400) * 10 ** rng.uniform(-12, math.log10(largest), 400),
            quarters[np.abs(quarters) <= largest],
        ]
    ).astype(dtype)


def truth(function, values):
    with mpmath.workdps(40):
        return [function(mpmath.mpf(float(value))) for value in values]


def error(got, wanted):
    assert np.isfinite(got).all()
    return np.array([float(abs(float(g) - w)) for g, w in zip(got, wanted, strict=True)])


# Headings of a thousand turns and more; from 1e7 rad on a float tells no direction.
LARGEST_ANGLE = {"float64": 1e9, "float32": 1e5}


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine_are_right_to_the_rounding_of_their_angle(name, dtype):
    x = spread(dtype, LARGEST_ANGLE[dtype])
    with np.errstate(over="ignore"):
        got = getattr(in_numpy(dtype), name)(x)
    assert got.dtype == dtype
    # One rounding of the angle, and two of the value, which is at most 1.
    allowed = np.finfo(dtype).eps * (1 + np.abs(x.astype(float)))
    assert (error(got, truth(getattr(mpmath, name), x)) <= allowed).all()
    assert np.abs(got).max() <= 1 + 2 * np.finfo(dtype).eps


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("wide", [False, True])
def test_sinc_is_right_and_one_at_zero(dtype, wide):
    largest = 1e4 if wide else math.sqrt(LARGEST_SQUARE)
    x = spread(dtype, largest)
    x = np.append(x[np.abs(x) <= largest], [0.0, -0.0]).astype(dtype)
    with np.errstate(over="ignore", under="ignore"):
        got = in_numpy(dtype, wide).sinc(x)
    wanted = truth(lambda v: mpmath.sin(v) / v if v else mpmath.mpf(1), x)
    # An angle's rounding, divided by the angle, and some of a value that is at most 1.
    assert (error(got, wanted) <= 4 * np.finfo(dtype).eps).all()
    assert got[-2:].tolist() == [1.0, 1.0]


@pytest.mark.parametrize("dtype", DTYPES)
def test_logarithm_is_right_over_all_magnitudes(dtype):
    info = np.finfo(dtype)
    powers = np.linspace(math.log2(info.tiny), math.log2(info.max) - 1e-3, 800)
    x = np.concatenate([2.0**powers, 1 + np.linspace(-0.4, 0.6, 801), [2.0**-25, 0.5]])
    x = x.astype(dtype)
    with np.errstate(over="ignore"):
        got = in_numpy(dtype).log(x)
    wanted = truth(mpmath.log, x)
    scale = np.maximum([float(abs(value)) for value in wanted], info.eps)
    # Relative, also beside 1, where the logarithm vanishes; some roundings.
    assert (error(got, wanted) / scale).max() <= 4 * info.eps


@needs_numba
@pytest.mark.parametrize("dtype", DTYPES)
def test_compiled_functions_are_those_that_numpy_reads(dtype):
    import numba

    def part(function):
        return numba.njit(inline="always", fastmath=cpu.FAST, error_model="numpy")(function)

    m = compiled_arithmetic(dtype, part, read_bits(), wide=True)
    sin, cos, sinc, log = m.sin, m.cos, m.sinc, m.log

    @numba.njit(error_model="numpy")
    def all_of(x, out):
        for i in range(len(x)):
            out[0, i], out[1, i], out[2, i] = sin(x[i]), cos(x[i]), sinc(x[i])
            out[3, i] = log(abs(x[i]))

    x = spread(dtype, 1e3)
    x = x[x != 0]
    got = np.empty((4, len(x)), dtype)
    all_of(x, got)
    m, eps = array_arithmetic(dtype), np.finfo(dtype).eps
    for mine, name in zip(got, ("sin", "cos", "sinc", "log"), strict=True):
        wanted = getattr(m, name)(abs(x) if name == "log" else x)
        scale = 1 + np.abs(x if name in ("sin", "cos") else wanted)
        np.testing.assert_array_less(np.abs(mine - wanted), 4 * eps * scale, err_msg=name)


# ---- random numbers --------------------------------------------------------------------------

# Salmon et al., the known answers that come with their library, for threefry4x32 with 13 rounds.
KNOWN_ANSWERS = [
    ("00000000 " * 4, "00000000 " * 4, "531c7e4f 39491ee5 2c855a92 3d6abf9a"),
    ("ffffffff " * 4, "ffffffff " * 4, "c4189358 1c9cc83a d5881c67 6a0a89e0"),
    (
        "243f6a88 85a308d3 13198a2e 03707344",
        "a4093822 299f31d0 082efa98 ec4e6c89",
        "4aa71d8f 734738c2 431fc6a8 ae6debf1",
    ),
]


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN_ANSWERS)
def test_threefry_gives_its_authors_answers(counter, key, answer):
    counter, key, answer = ([int(word, 16) for word in t.split()] for t in (counter, key, answer))
    words = key_words(sum(word << 32 * i for i, word in enumerate(key)))
    assert list(make_threefry(PLAIN.word, as_is)(words, counter)) == answer
    wrapped = [np.array([word], np.uint32) for word in counter]
    of_arrays = make_threefry(np.uint32, as_is)(np.array(words, np.uint32), wrapped)
    assert [int(word[0]) for word in of_arrays] == answer


def normal_numbers(robots, steps, seed=3, dtype="float64", count=4):
    """Return (steps, count, robots) numbers, as numpy reads them."""
    normals = make_normals(count, array_arithmetic(dtype), as_is)
    key, who = np.array(key_words(seed), np.uint32), np.arange(robots, dtype=np.uint32)
    with np.errstate(over="ignore"):
        return np.array([normals(key, who, t) for t in range(steps)])


SAMPLE = normal_numbers(2500, 100)


def test_noise_is_normal():
    values = SAMPLE.ravel()
    # A million numbers: the moments' own deviations are 1 / sqrt(N) times 1, sqrt 2, sqrt 6 ...
    sigma = 1 / math.sqrt(len(values))
    assert abs(values.mean()) < 4 * sigma
    assert abs(values.var() - 1) < 4 * math.sqrt(2) * sigma
    assert abs(stats.skew(values)) < 4 * math.sqrt(6) * sigma
    assert abs(stats.kurtosis(values)) < 4 * math.sqrt(24) * sigma
    for column in SAMPLE.swapaxes(0, 1):
        # One of a hundred sound generators would fail; the seed is fixed.
        assert stats.kstest(column.ravel(), "norm").pvalue > 0.01


def test_noise_has_its_tails():
    values = np.abs(SAMPLE.ravel())
    for far in (2.0, 3.0, 4.0):
        expected = len(values) * 2 * stats.norm.sf(far)
        assert abs((values > far).sum() - expected) < 4 * math.sqrt(expected)
    # Of 24 bits, the farthest there can be.
    assert values.max() < math.sqrt(50 * math.log(2))


@pytest.mark.parametrize("axis", range(3), ids=["step", "wheel", "robot"])
@pytest.mark.parametrize("power", [1, 2])
def test_noise_of_neighbours_is_independent(axis, power):
    values = np.moveaxis(SAMPLE, axis, 0) ** power
    values = (values - values.mean()) / values.std()
    for lag in (1, 2, 3):
        product = values[lag:] * values[:-lag]
        assert abs(product.mean()) < 4 / math.sqrt(product.size)


def test_noise_of_two_seeds_is_independent():
    other = normal_numbers(2500, 100, seed=4)
    assert abs((SAMPLE * other).mean()) < 4 / math.sqrt(SAMPLE.size)
    assert len(np.unique(np.append(SAMPLE[:, :, :99], other[:, :, :99]))) == 2 * 100 * 4 * 99


def test_noise_of_floats_is_that_of_doubles():
    floats = normal_numbers(2500, 100, dtype="float32")
    assert floats.dtype == np.float32
    # A rounding of the radius' square weighs most where the radius is small: 1e-7 / 1e-3.
    np.testing.assert_allclose(floats, SAMPLE, rtol=0, atol=1e-4)
    assert np.abs(floats - SAMPLE).mean() < 1e-6


def test_a_robot_steers_eight_wheels_with_eight_numbers():
    eight = normal_numbers(50, 3, count=8)
    np.testing.assert_array_equal(eight[:, :4], normal_numbers(50, 3))
    assert np.abs(np.corrcoef(eight.swapaxes(0, 1).reshape(8, -1)) - np.eye(8)).max() < 0.4


@needs_numba
def test_noise_is_the_same_on_any_number_of_threads():
    import numba

    recipe, given = CASES["noisy-float32"]
    recipe = replace(recipe, keeps=False)
    count, most = 5000, numba.get_num_threads()
    wide = given._replace(
        steps=20,
        commands=np.tile(given.commands[:, :, :1], count),
        own=np.tile(given.own[:, :1], count),
        every=0,
    )
    finals = []
    for threads in (1, most, 1):
        numba.set_num_threads(threads)
        state = np.zeros((recipe.state, count), np.float32)
        cpu.make_run(recipe)(wide._replace(state=state))
        finals.append(state)
    numba.set_num_threads(most)
    np.testing.assert_array_equal(finals[0], finals[1])
    np.testing.assert_array_equal(finals[0], finals[2])
    assert len(np.unique(finals[0][0])) > count // 2  # each robot has noise of its own


# ---- what is missing is said -----------------------------------------------------------------


def test_missing_numba_cuda_is_said(monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "numba_cuda" else found(name)
    )
    with pytest.raises(TrundleError, match=r"pip install 'trundle\[gpu\]'"):
        gpu.check()


@needs_numba_cuda
def test_a_missing_gpu_is_said():
    from numba import cuda

    if cuda.is_available():
        pytest.skip("there is a GPU")
    with pytest.raises(TrundleError, match=r"needs an NVIDIA GPU with its driver: \w+"):
        gpu.check()


@needs_numba_cuda
def test_the_kernel_agrees_on_a_gpu():
    from numba import cuda

    if not cuda.is_available():
        pytest.skip("there is no GPU")
    for name in CASES:
        assert_agree(outcome(gpu.run, name), name)
