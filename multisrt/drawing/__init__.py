"""Pictures of worlds and runs, as SVG."""

from multisrt.drawing.environment_svg import environment_svg, save_environment_svg
from multisrt.drawing.tree_svg import save_tree_svg, tree_svg

__all__ = ["environment_svg", "save_environment_svg", "save_tree_svg", "tree_svg"]
