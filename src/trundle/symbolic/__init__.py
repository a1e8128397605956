"""Derivations in symbols: chains, robots, documents and printed code. Loading it loads sympy."""

from trundle.symbolic.base import planar_base, planar_links
from trundle.symbolic.brackets import Found, Integrability, bracket, integrability
from trundle.symbolic.c_code import c_source
from trundle.symbolic.chain import Joints, Link, joints, pose, table, transforms
from trundle.symbolic.code import Function, Group, Output
from trundle.symbolic.document import (
    TOPICS,
    Document,
    code,
    document,
    functions,
    render_html,
    render_latex,
    render_text,
)
from trundle.symbolic.equations import Derived, Equations, Named
from trundle.symbolic.lagrange import Lagrangian, christoffel, lagrange, rate_of
from trundle.symbolic.latex import to_latex
from trundle.symbolic.newton_euler import newton_euler
from trundle.symbolic.numpy_code import numpy_function, numpy_source
from trundle.symbolic.pseudo_inverse import PseudoInverse, pseudo_inverse
from trundle.symbolic.quantities import Quantity
from trundle.symbolic.robot import SymbolicRobot, example_angles, generic_angles, symbolic_robot
from trundle.symbolic.spaces import numbers

__all__ = [
    "TOPICS",
    "Derived",
    "Document",
    "Equations",
    "Found",
    "Function",
    "Group",
    "Integrability",
    "Joints",
    "Lagrangian",
    "Link",
    "Named",
    "Output",
    "PseudoInverse",
    "Quantity",
    "SymbolicRobot",
    "bracket",
    "c_source",
    "christoffel",
    "code",
    "document",
    "example_angles",
    "functions",
    "generic_angles",
    "integrability",
    "joints",
    "lagrange",
    "newton_euler",
    "numbers",
    "numpy_function",
    "numpy_source",
    "planar_base",
    "planar_links",
    "pose",
    "pseudo_inverse",
    "rate_of",
    "render_html",
    "render_latex",
    "render_text",
    "symbolic_robot",
    "table",
    "to_latex",
    "transforms",
]
