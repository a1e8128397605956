"""Pictures and animations of robots and runs; loads matplotlib."""

from trundle.view.eta import plot_eta
from trundle.view.files import save
from trundle.view.film import animate
from trundle.view.layout import plot_layout
from trundle.view.path import plot_path
from trundle.view.reachable import plot_reachable

__all__ = ["animate", "plot_eta", "plot_layout", "plot_path", "plot_reachable", "save"]
