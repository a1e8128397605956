"""Pictures and animations of robots and runs; loads matplotlib."""

from trundle.view.cloud import plot_cloud
from trundle.view.comparison import plot_comparison
from trundle.view.ends import Ends, ends_of
from trundle.view.eta import plot_eta
from trundle.view.feasibility import plot_feasibility
from trundle.view.files import save
from trundle.view.film import animate
from trundle.view.layout import plot_layout
from trundle.view.path import plot_path
from trundle.view.reachable import plot_reachable
from trundle.view.tracking import plot_tracking
from trundle.view.trajectory import plot_trajectory

__all__ = [
    "Ends",
    "animate",
    "ends_of",
    "plot_cloud",
    "plot_comparison",
    "plot_eta",
    "plot_feasibility",
    "plot_layout",
    "plot_path",
    "plot_reachable",
    "plot_tracking",
    "plot_trajectory",
    "save",
]
