"""Wheel torques for a force on the body, by virtual work."""

from __future__ import annotations

import sympy

from trundle.robot import RollingWheel
from trundle.symbolic.document.case import LONG, Case
from trundle.symbolic.document.parts import Law, Section, Step
from trundle.symbolic.document.reduced_dynamics import reduced_dynamics
from trundle.symbolic.tidy import length

_LETTERS = (
    r"In this section $\tau_{w}$ are the torques of the wheels, and $\tau$ without it is the force "
    r"on the body in the inertial frame; $R$, $N$ and $\omega$ are the radii, the allowed twists "
    "and the wheel speeds of the kinematics again."
)


def wheel_torques(case: Case) -> Section:
    """Return how wheel torques and the force on the body go together."""
    made = case.made
    steps = [
        Step("Letters", _LETTERS),
        Step(
            "The force in the body frame",
            r"The power of a force does not depend on the frame: $\tau^{T} \dot{q} = "
            r"F_{B}^{T} \zeta$ with $\dot{q} = J(\psi)\, \zeta$, so that",
            (Law(r"F_{B} = J(\psi)^{T} \tau"),),
        ),
    ]
    if not made.A.rows or not made.K.cols:
        steps.append(Step("Wheel torques", "No driven wheel pushes the robot: there are none."))
        return Section("Wheel torques", tuple(steps))
    steps += [*_work(case), _torques(case), *_beyond(case), *reduced_dynamics(case)]
    return Section("Wheel torques", tuple(steps))


def _work(case: Case) -> list[Step]:
    made = case.made
    text = (
        r"The wheels' power is that of the force: $\tau_{w}^{T} \omega = F_{B}^{T} \zeta$. With "
        r"$\omega = R^{-1} A\, \zeta$ for every twist"
    )
    if made.N.cols == 3:
        laws = (Law(r"F_{B} = \left(R^{-1} A\right)^{T} \tau_{w}"),)
        return [Step("Virtual work", f"{text}:", laws, detail=True)]
    law = Law(r"N^{T} F_{B} = \left(R^{-1} A N\right)^{T} \tau_{w}")
    project = Step(
        "Virtual work",
        f"{text} that is allowed, $\\zeta = N z$; across those the ground holds the robot by side "
        "forces that do no work. So project first:",
        (law,),
        detail=True,
    )
    inner = (made.R.inv() * (made.A * made.N if made.undriven.cols else made.AK)).T
    if length(inner) > LONG:
        return [project]
    formula = case.shown(r"\left(R^{-1} A N\right)^{T}", inner)
    return [project, Step("For this robot", "", (formula,), detail=True)]


def _torques(case: Case) -> Step:
    made = case.made
    text = "Of all torques that give the force, those of least norm where the wheels are alike:"
    if made.A.rows == made.K.cols:
        text = "As many wheels as motions: there is one answer."
    if made.undriven.cols:
        text += " A force along the motions that nothing drives cannot be given."
    turned = sympy.Matrix(made.W.T)
    shown = case.factored("W^{T}", turned)
    if length(turned) > LONG:
        shown = case.plain("W^{T}", shown.numbers)
    return Step("Wheel torques", text, (Law(r"\tau_{w} = W^{T} F_{B}"), shown))


def _beyond(case: Case) -> list[Step]:
    """Return what the motors give beside the force on the body."""
    wheels = [each for each in case.robot.wheels if isinstance(each, RollingWheel)]
    text = "The formulas here leave out the wheels' spin, friction and motors."
    laws = []
    if any(_resists(each) for each in wheels):
        text += (
            r" This robot's description has spin inertia $J$ or friction: the motors give that "
            "too, and wheels without a motor take theirs from the body."
        )
        laws.append(
            Law(r"\tau_{w} = W^{T} F_{B} + J \dot{\omega} + \text{friction}\left(\omega\right)")
        )
    if any(each.motor is not None for each in wheels):
        text += (
            r" Where a wheel has a motor, with voltage $U$, current $i$, resistance $R_{m}$, "
            r"constants $k_{t}$ and $k_{e}$ and gear $n_{g}$:"
        )
        laws.append(Law(r"U = R_{m} i + k_{e} n_{g} \omega, \quad \tau_{w} = n_{g} k_{t} i"))
    return [Step("What is left out", text, tuple(laws))]


def _resists(wheel: RollingWheel) -> bool:
    by_motor = wheel.motor is not None and wheel.motor.friction_torque > 0
    return by_motor or bool(wheel.spin_inertia or wheel.viscous_friction or wheel.coulomb_friction)
