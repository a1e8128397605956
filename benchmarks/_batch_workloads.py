"""What ``batches.py`` compares: workloads, their candidates, and what is required of trundle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from importlib.util import find_spec

import _batch_trundle as ours
import _limits as limits
import _peers_jax as in_jax
import _peers_numpy as in_numpy
import _peers_others as others
from _batch_tasks import FULL, Sizes
from _common import Job

Jobs = dict[str, Callable[[], Job]]

# Both sides compute in doubles, on paths of some metres; in single precision plain sums lose a
# part in 1e7 at each of a hundred steps.
ROUNDING, ROUNDING_SINGLE = 1e-9, 1e-4
# Means over random numbers that are drawn differently: some standard errors of them.
CHANCE, CHANCE_SMOKE, CHANCE_MPPI = 0.02, 0.1, 0.1

OURS = OURS_32, OURS_64 = "trundle, float32", "trundle, float64"
NUMPYS = NUMPY_32, NUMPY_64 = "NumPy, float32", "NumPy, float64"
JAXES = JAX_32, JAX_64 = "JAX, float32", "JAX, float64"
JAX_APART = "JAX, an array for each wheel, float32"
LIMIT_32, LIMIT_64 = "the limit, float32", "the limit, float64"
LOOP, WPIMATH, MUJOCO = "the lectures' loop", "robotpy-wpimath", "MuJoCo's rollout"

TIMES_JAX = 8.0  # required of all workloads of many robots
# Bytes of four wheel speeds, and of a pose, in single precision.
COMMAND, POSE = 16, 12


@dataclass(frozen=True)
class Workload:
    """A task of many robots.

    Attributes:
        title: for tables and the picture.
        jobs: the candidates, trundle's first.
        required: how many times NumPy's rate is required of trundle's candidates.
        share: of the limit's rate that is required of them.
        limit: what the limit is, in words.
        reference: NumPy's candidate that this is meant against.
        double: how far answers in double precision may lie from each other.
        single: the same in single precision.
    """

    title: str
    jobs: Jobs
    required: dict[str, float]
    share: dict[str, float] = field(default_factory=dict)
    limit: str = ""
    reference: str = NUMPY_64
    double: float = ROUNDING
    single: float = ROUNDING_SINGLE

    def key(self, name: str) -> str:
        """Return a candidate's name among those of all workloads."""
        return f"{self.title}: {name}"


def both(candidate: Callable[[Sizes, str], Job], size: Sizes, names: tuple[str, str]) -> Jobs:
    """Return a candidate in single and in double precision."""
    return {name: partial(candidate, size, name.rpartition(" ")[2]) for name in names}


def workloads(size: Sizes) -> list[Workload]:
    """Return the tasks of many robots."""
    makers = (streamed_final, streamed_stored, constant_stored, noisy_final, tracking_final)
    return [make(size, size.robots * size.steps) for make in makers]


def streamed_final(size: Sizes, count: int) -> Workload:
    jobs = both(ours.streamed, size, OURS) | both(in_numpy.streamed, size, NUMPYS)
    jobs |= both(in_jax.streamed, size, JAXES)
    jobs |= {
        JAX_APART: partial(in_jax.streamed, size, "float32", apart=True),
        LOOP: partial(in_numpy.lecture, size),
        WPIMATH: partial(others.wpimath, size),
        MUJOCO: partial(others.mujoco, size),
        LIMIT_32: partial(limits.reading, count, COMMAND),
        LIMIT_64: partial(limits.reading, count, 2 * COMMAND),
    }
    required, share = {OURS_32: 15.0, OURS_64: 8.0}, dict.fromkeys(OURS, 0.40)
    return Workload("streamed commands, final pose", jobs, required, share, "reading")


def streamed_stored(size: Sizes, count: int) -> Workload:
    jobs = {
        OURS_32: partial(ours.streamed, size, "float32", stored=True),
        NUMPY_32: partial(in_numpy.streamed, size, "float32", stored=True),
        NUMPY_64: partial(in_numpy.streamed, size, "float64", stored=True),
        JAX_32: partial(in_jax.streamed, size, "float32", stored=True),
        LIMIT_32: partial(limits.copying, count, COMMAND + POSE),
    }
    return Workload("streamed commands, trajectory stored", jobs, {}, {OURS_32: 0.35}, "copying")


def constant_stored(size: Sizes, count: int) -> Workload:
    jobs = both(ours.constant, size, OURS) | both(in_numpy.constant, size, NUMPYS)
    jobs |= both(in_jax.constant, size, JAXES)
    jobs |= {
        LIMIT_32: partial(limits.writing, count, POSE),
        LIMIT_64: partial(limits.writing, count, 2 * POSE),
    }
    required, share = {OURS_32: 30.0, OURS_64: 15.0}, dict.fromkeys(OURS, 0.45)
    return Workload("constant commands, trajectory stored", jobs, required, share, "writing")


def noisy_final(size: Sizes, _: int) -> Workload:
    jobs = {OURS_32: partial(ours.noisy, size, "float32")}
    jobs |= both(in_numpy.noisy, size, NUMPYS)
    jobs |= {JAX_32: partial(in_jax.noisy, size, "float32")}
    chance = CHANCE if size is FULL else CHANCE_SMOKE
    return Workload(
        "noise in the commands, final pose", jobs, {OURS_32: 20.0},
        double=chance, single=chance,
    )  # fmt: skip


def tracking_final(size: Sizes, _: int) -> Workload:
    jobs = both(ours.computed_torque, size, OURS)
    jobs |= both(in_numpy.computed_torque, size, NUMPYS)
    jobs |= both(in_jax.computed_torque, size, JAXES)
    jobs |= {LOOP: partial(in_numpy.lecture_torque, size)}
    return Workload("computed torque, final pose", jobs, {OURS_32: 90.0, OURS_64: 45.0})


# ---- one at a time ---------------------------------------------------------------------------

TRUNDLE, PLAIN, NUMPY, JAX = "trundle", "trundle, plain floats", "NumPy", "JAX"


@dataclass(frozen=True)
class Single:
    """A task whose time is what counts.

    Attributes:
        title: for the table.
        unit: of the time, and how many of them are a second.
        jobs: the candidates.
        reference: the candidate that ratios are taken to.
        ratio: what is required of trundle's time at most, in parts of the reference's.
        seconds: what is required of trundle's time itself.
        tolerance: how far answers may lie from each other.
    """

    title: str
    unit: tuple[str, float]
    jobs: Jobs
    reference: str
    ratio: float | None
    seconds: float | None
    tolerance: float

    def key(self, name: str) -> str:
        """Return a candidate's name among those of all tasks."""
        return f"{self.title}: {name}"


def singles(size: Sizes) -> list[Single]:
    """Return the tasks of one robot, and of one tick."""
    tick: Jobs = {TRUNDLE: partial(ours.mppi, size)}
    tick |= {NUMPY: partial(in_numpy.mppi, size), JAX: partial(in_jax.mppi, size)}
    call: Jobs = {TRUNDLE: ours.prepared_call, PLAIN: ours.plain_call}
    feedback: Jobs = {TRUNDLE: partial(ours.feedback, size), LOOP: partial(in_numpy.feedback, size)}
    micro, nano = ("µs", 1e6), ("ns", 1e9)
    return [
        Single(f"a tick of MPPI, {size.samples:,} samples of {size.horizon} steps", micro, tick,
               NUMPY, 1 / 10, None, CHANCE_MPPI),
        Single("a prepared call: one robot, one step", micro, call, TRUNDLE, None, 5e-6, ROUNDING),
        Single("a step of one robot by feedback", nano, feedback, LOOP, 1 / 150, None, ROUNDING),
    ]  # fmt: skip


def chosen(jobs: Jobs, smoke: bool) -> Jobs:
    """Return the candidates whose libraries are here; in a smoke run those that are needed."""
    absent = [
        start
        for start, module in (("JAX", "jax"), (WPIMATH, "wpimath"), (MUJOCO, "mujoco"))
        if find_spec(module) is None
    ]
    absent += [OURS_64, JAX_64, LIMIT_64] if smoke else []
    return {name: job for name, job in jobs.items() if not name.startswith(tuple(absent))}
