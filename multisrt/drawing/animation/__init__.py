"""Animations of runs: as SVG that moves by itself, and as MP4 and GIF.

One `scene.Scene` says what is shown when. `moving_svg` writes it as a document, `painter` draws its
pictures, and `video` makes films of them.
"""

from multisrt.drawing.animation.saving import FORMATS, animation_svg, save_animation

__all__ = ["FORMATS", "animation_svg", "save_animation"]
