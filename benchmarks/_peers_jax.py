"""The peers in JAX on the processor: jit(vmap(scan)).

Commands lie in one array (T, N, 4), as users have them. XLA reads four arrays (T, N), one for each
wheel, nearly twice as fast, and (T, 4, N) more slowly: the first is a candidate of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from _batch_tasks import (
    MPPI_DT,
    MPPI_SIGMA,
    SIGMA,
    TEMPERATURE,
    Numbers,
    Sizes,
    circle_table,
    constant_speeds,
    exact_step,
    few,
    first_plan,
    increments,
    spread,
    stage_cost,
    starts,
    streamed_speeds,
    tracking_step,
)
from _common import Job
from _peers_numpy import mean_plan


def libraries(dtype: str) -> tuple[Any, Any]:
    """Return jax and jax.numpy; doubles must be asked for."""
    import jax

    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_enable_x64", dtype == "float64")
    return jax, jax.numpy


def rows(jnp: Any, values: Numbers) -> tuple[Any, ...]:
    return tuple(jnp.asarray(np.ascontiguousarray(values[..., k, :])) for k in range(4))


def twist(speeds: Any) -> Any:
    """Return dx, dy and half of dpsi of a step from four wheel speeds."""
    return [sum(float(a) * w for a, w in zip(row, speeds, strict=True)) for row in increments()]


def timed(jax: Any, function: Any, *inputs: Any) -> tuple[str, dict[str, object], Any]:
    """Return statement, names and result of a call that waits until all is computed."""
    names = {"call": function, "inputs": inputs, "wait": jax.block_until_ready}
    return "wait(call(*inputs))", names, function(*inputs)


def streamed(size: Sizes, dtype: str, stored: bool = False, apart: bool = False) -> Job:
    """Return streamed commands; apart, an array for each wheel."""
    jax, jnp = libraries(dtype)

    def one(speeds: Any) -> Any:
        def step(pose: Any, now: Any) -> Any:
            new = exact_step(jnp, *pose, *twist(now if apart else [now[k] for k in range(4)]))
            return new, (new if stored else None)

        zero = jnp.zeros((), dtype)
        return jax.lax.scan(step, (zero, zero, zero), speeds)

    call = jax.jit(jax.vmap(one, in_axes=1, out_axes=(0, 1)))
    speeds = streamed_speeds(size, dtype)
    if apart:
        given = rows(jnp, speeds)
    else:
        given = jnp.asarray(np.ascontiguousarray(speeds.transpose(0, 2, 1)))
    statement, names, (final, _) = timed(jax, call, given)
    return Job(statement, names, few(size, *final), size.steps * size.robots)


def constant(size: Sizes, dtype: str) -> Job:
    jax, jnp = libraries(dtype)

    def one(speeds: Any) -> Any:
        increment = twist(speeds)

        def step(pose: Any, _: None) -> Any:
            new = exact_step(jnp, *pose, *increment)
            return new, new

        zero = jnp.zeros((), dtype)
        return jax.lax.scan(step, (zero, zero, zero), None, length=size.steps)

    call = jax.jit(jax.vmap(one, out_axes=(0, 1)))
    speeds = rows(jnp, constant_speeds(size).astype(dtype))
    statement, names, (final, _) = timed(jax, call, speeds)
    return Job(statement, names, few(size, *final), size.steps * size.robots)


def noisy(size: Sizes, dtype: str) -> Job:
    """Return noise for all robots at once in every step: a key for each robot takes longer."""
    jax, jnp = libraries(dtype)

    def run(speeds: Any, key: Any) -> Any:
        def step(pose: Any, key: Any) -> Any:
            noise = jax.random.normal(key, (4, size.robots), dtype)
            moved = [w + SIGMA * e for w, e in zip(speeds, noise, strict=True)]
            return exact_step(jnp, *pose, *twist(moved)), None

        zero = jnp.zeros(size.robots, dtype)
        return jax.lax.scan(step, (zero, zero, zero), jax.random.split(key, size.steps))[0]

    speeds = rows(jnp, constant_speeds(size).astype(dtype))
    statement, names, final = timed(jax, jax.jit(run), speeds, jax.random.PRNGKey(0))
    return Job(statement, names, spread(*final), size.steps * size.robots)


def computed_torque(size: Sizes, dtype: str) -> Job:
    jax, jnp = libraries(dtype)
    table = jnp.asarray(circle_table(size.steps), dtype)

    def one(start: Any) -> Any:
        def step(state: Any, desired: Any) -> Any:
            return tracking_step(jnp, state, desired), None

        zero = jnp.zeros((), dtype)
        return jax.lax.scan(step, (*start, zero, zero, zero), table)[0][:3]

    start = tuple(jnp.asarray(each, dtype) for each in starts(size))
    statement, names, final = timed(jax, jax.jit(jax.vmap(one)), start)
    return Job(statement, names, few(size, *final), size.steps * size.robots)


def mppi(size: Sizes) -> Job:
    jax, jnp = libraries("float32")

    def update(plan: Any, key: Any) -> Any:
        noise = MPPI_SIGMA * jax.random.normal(key, (size.horizon, 3, size.samples))

        def step(state: Any, now: Any) -> Any:
            x, y, psi, cost = state
            (u, v, r), (e_u, e_v, e_r) = now
            u, v, r = u + e_u, v + e_v, r + e_r
            pose = exact_step(jnp, x, y, psi, MPPI_DT * u, MPPI_DT * v, (0.5 * MPPI_DT) * r)
            return (*pose, cost + stage_cost(jnp, *pose[:2], u, v, r)), None

        zero = jnp.zeros(size.samples)
        cost = jax.lax.scan(step, (zero,) * 4, (plan, noise))[0][3]
        cost = cost + TEMPERATURE / MPPI_SIGMA**2 * jnp.einsum("ti,tik->k", plan, noise)
        weights = jax.nn.softmax(-cost / TEMPERATURE)
        return plan + noise @ weights

    call, split, plan = jax.jit(update), jax.jit(jax.random.split), jnp.asarray(first_plan(size))
    key = [jax.random.PRNGKey(0)]

    def tick() -> Numbers:
        key[0], now = split(key[0])
        return np.asarray(call(plan, now))

    return Job("tick()", {"tick": tick}, mean_plan(size, tick))
