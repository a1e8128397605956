"""The step under jax.jit, jax.grad and jax.vmap, as it is: jax is one more reader of it."""

import numpy as np
import pytest

import trundle
from trundle import se2
from trundle.se2 import make_sinc
from trundle.simulation.arithmetic import PLAIN
from trundle.simulation.rollout.motions import Linear
from trundle.simulation.rollout.random import key_words, make_normals
from trundle.simulation.rollout.recipe import Recipe, make_advance

jax = pytest.importorskip("jax", reason="jax is not installed")
jnp = pytest.importorskip("jax.numpy")

# Some dozens of roundings of numbers below 10.
ROUNDING = 1e-13
# Central differences of width 1e-5 leave its square times a third derivative, and roundings over
# the width.
WIDTH, DIFFERENCES = 1e-5, 1e-8

JAX = PLAIN._replace(
    sin=jnp.sin,
    cos=jnp.cos,
    near_cos=jnp.cos,
    sinc=make_sinc(jnp.sin, jnp.sqrt, se2.NEVER_ZERO),
    log=jnp.log,
    sqrt=jnp.sqrt,
    word=jnp.uint32,
    upper=lambda n: (n >> 8).astype(float),
)


@pytest.fixture(autouse=True)
def _doubles():
    """Let jax compute in doubles, in these tests only."""
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


# ---- one step --------------------------------------------------------------------------------


def step_of(pose, increment):
    return jnp.stack(se2.make_step(jnp.sin, jnp.cos)(*pose, *increment))


def moves(count):
    rng = np.random.default_rng(2)
    return rng.normal(0.0, 1.0, (count, 3)), rng.normal(0.0, 1.0, (count, 3))


def test_jit_and_vmap_give_the_step():
    poses, increments = moves(20)
    got = jax.jit(jax.vmap(step_of))(poses, increments)
    for mine, pose, increment in zip(got, poses, increments, strict=True):
        np.testing.assert_allclose(mine, se2.step(*pose, *increment), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("argument", [0, 1], ids=["pose", "increment"])
def test_the_derivatives_of_the_step_are_those_of_differences(argument):
    given = moves(10)
    got = jax.jit(jax.vmap(jax.jacobian(step_of, argument)))(*given)
    for i, width in enumerate(np.eye(3) * WIDTH):
        ahead, behind = (
            np.array([se2.step(*pair[0], *pair[1]) for pair in changed(given, argument, change)])
            for change in (width, -width)
        )
        wanted = (ahead - behind) / (2 * WIDTH)
        np.testing.assert_allclose(got[:, :, i], wanted, rtol=0, atol=DIFFERENCES)


def changed(given, argument, change):
    """Return pairs of pose and increment, one of the two changed."""
    both = list(given)
    both[argument] = both[argument] + change
    return zip(*both, strict=True)


def test_the_derivatives_where_a_robot_goes_straight_on_are_known():
    pose, (dx, dy) = np.array([0.3, -0.2, 0.7]), (0.4, -0.1)
    got = jax.jit(jax.jacobian(step_of, 1))(pose, np.array([dx, dy, 0.0]))
    c, s = np.cos(pose[2]), np.sin(pose[2])
    # By hand: the increment is turned by psi, and with it half of dpsi turns it further.
    wanted = [
        [c, -s, (-s * dx - c * dy) / 2],
        [s, c, (c * dx - s * dy) / 2],
        [0, 0, 1],
    ]
    np.testing.assert_allclose(got, wanted, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_the_gradient_at_no_turn_is_that_of_differences(dtype):
    def far_of(dpsi, step):
        x, y, _ = step(0.0, 0.0, 0.7, 0.4, -0.1, dpsi)
        return x + 2.0 * y

    step = se2.make_step(jnp.sin, jnp.cos)
    got = jax.grad(lambda dpsi: far_of(dpsi, step))(jnp.zeros((), dtype))
    assert got.dtype == dtype
    wanted = (far_of(WIDTH, se2.step) - far_of(-WIDTH, se2.step)) / (2 * WIDTH)
    tolerance = {"float32": 4 * 2.0**-24, "float64": DIFFERENCES}[dtype]  # roundings below 1
    np.testing.assert_allclose(got, wanted, rtol=0, atol=tolerance)


# ---- a whole rollout -------------------------------------------------------------------------

ROBOT, DT, STEPS = trundle.load("mecanum"), 0.1, 8
RADIUS = ROBOT.wheels[0].radius
MATRIX = trundle.Kinematics(ROBOT).W
RECIPE = Recipe("float64", 4, 4, (False,) * 12, Linear(4, "exact"))


def final(speeds, radius):
    """Return the final pose of wheel speeds (T, 4); the radius scales what they move."""
    advance = make_advance(RECIPE, JAX, lambda function: function)
    scale = DT * MATRIX / RADIUS * np.array([[1.0], [1.0], [0.5]])
    constants = tuple((radius * scale).ravel())

    def one_step(state, row):
        moved, _ = advance(0, state, tuple(row), (), constants, None)
        return moved, None

    start = (jnp.zeros(()),) * 3
    return jnp.stack(jax.lax.scan(one_step, start, speeds)[0])


def far(speeds, radius):
    """Return how far from the origin a robot ends."""
    x, y, _ = final(speeds, radius)
    return jnp.hypot(x, y)


def rolled_out(speeds):
    """Return final poses (N, 3) of wheel speeds (N, T, 4), by the package's own loops."""
    stream = trundle.Stream(np.swapaxes(speeds, 0, 1))
    return trundle.rollout(ROBOT, stream, dt=DT, device="numpy").pose


def some_speeds(kind):
    if kind == "straight":
        return np.full((STEPS, 4), 10.0)
    return np.random.default_rng(4).normal(10.0, 10.0, (STEPS, 4))


def test_scan_and_vmap_give_the_rollout():
    speeds = np.stack([some_speeds("winding") * k for k in (0.5, 1.0, 2.0)])
    got = jax.jit(jax.vmap(final, (0, None)))(speeds, RADIUS)
    np.testing.assert_allclose(got, rolled_out(speeds), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("kind", ["winding", "straight"])
def test_gradients_through_a_rollout_are_those_of_differences(kind):
    speeds = some_speeds(kind)
    of_speeds, of_radius = jax.jit(jax.grad(far, (0, 1)))(speeds, RADIUS)
    # Each robot has one speed changed; the last ones all, as another radius would.
    changes = np.eye(speeds.size).reshape(-1, *speeds.shape) * WIDTH
    changes = np.concatenate([changes, speeds[None] * WIDTH / RADIUS])
    ahead, behind = (np.hypot(*rolled_out(speeds + sign * changes).T[:2]) for sign in (1, -1))
    wanted = (ahead - behind) / (2 * WIDTH)
    np.testing.assert_allclose(of_speeds.ravel(), wanted[:-1], rtol=0, atol=DIFFERENCES)
    np.testing.assert_allclose(of_radius, wanted[-1], rtol=1e-6)
    assert abs(of_radius) > 1.0
    if kind == "straight":  # by hand: as far as the radius times the angle that the wheels turn
        np.testing.assert_allclose(of_radius, 10.0 * DT * STEPS, rtol=1e-12)


def test_noise_in_jax_is_the_noise_of_the_loops():
    key = np.array(key_words(7), np.uint32)
    normals = make_normals(4, JAX, lambda function: function)
    got = jax.jit(jax.vmap(normals, (None, 0, None)))(key, np.arange(3), 5)
    still = trundle.Constant(twist=np.zeros((3, 3))).with_noise(1.0, seed=7)
    omni = trundle.load("omni3")
    first = trundle.rollout(omni, still, dt=1.0, steps=5, device="numpy", save="trajectory").pose
    after = trundle.rollout(omni, still, dt=1.0, steps=6, device="numpy").pose
    # The sixth step's turn is its third random number, with a standard deviation of 1 rad/s.
    turned = after[:, 2] - first[-1, :, 2]
    np.testing.assert_allclose(got[2], turned, rtol=0, atol=ROUNDING)
