"""Motion: trajectories, each a curve in the plane and a heading along it."""

from trundle.motion.closed import circle, ellipse, figure_eight, lissajous
from trundle.motion.course import AnyTrajectory, Course, length, sample
from trundle.motion.headings import Profile, Spin, profile, spin
from trundle.motion.points import cubic_via, line, quintic, via
from trundle.motion.stretched import stretched
from trundle.motion.table import from_csv
from trundle.motion.trajectory import Trajectory
from trundle.motion.waypoints import waypoints

__all__ = [
    "AnyTrajectory",
    "Course",
    "Profile",
    "Spin",
    "Trajectory",
    "circle",
    "cubic_via",
    "ellipse",
    "figure_eight",
    "from_csv",
    "length",
    "line",
    "lissajous",
    "profile",
    "quintic",
    "sample",
    "spin",
    "stretched",
    "via",
    "waypoints",
]
