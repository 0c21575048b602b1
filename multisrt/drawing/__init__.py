"""Pictures of worlds and runs, as SVG and on axes of matplotlib."""

from multisrt.drawing.environment_svg import (
    environment_svg,
    plot_environment,
    save_environment_svg,
)
from multisrt.drawing.layers import LAYERS, PICTURES
from multisrt.drawing.map_check_svg import map_check_svg, save_map_check_svg
from multisrt.drawing.tree_svg import plot_run, save_tree_svg, tree_svg

__all__ = [
    "LAYERS",
    "PICTURES",
    "environment_svg",
    "map_check_svg",
    "plot_environment",
    "plot_run",
    "save_environment_svg",
    "save_map_check_svg",
    "save_tree_svg",
    "tree_svg",
]
