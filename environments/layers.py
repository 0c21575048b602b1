"""Layers of a drawing: which of them were read as what, and which were left out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

MAX_NAMES: Final = 5
"""Number of layers that are listed by name, for each thing that they were read as."""

MAX_NAME_LENGTH: Final = 40
"""Number of characters of a layer's name that are kept."""


class Layer(NamedTuple):
    """A layer, class or identifier of a drawing.

    Attributes
    ----------
    name : str
        Its name; empty for shapes that are in no layer.
    read_as : str
        What it was read as, in the plural, such as ``"walls"``; empty if it was left out.
    shapes : int
        Number of shapes that it draws.
    """

    name: str
    read_as: str
    shapes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Layers:
    """Layers of a drawing that was read by the names of its layers.

    Attributes
    ----------
    layers : tuple of Layer
        The layers, in the order of the drawing.
    bounds_space : bool
        Whether one of them is read as walls or free space.
    remedy : str
        How layers are named to be read.

    Examples
    --------
    >>> found = [Layer("Layer 1", "", 3), Layer("Furniture", "obstacles", 2)]
    >>> layers = Layers(layers=tuple(found), bounds_space=False, remedy="name them walls")
    >>> print(layers)
    layers read: Furniture (obstacles); left out: Layer 1 (3 shapes); name them walls
    >>> layers.left_out[0].name
    'Layer 1'
    >>> layers.problem
    'no layer is read as walls or free space, and Layer 1 (3 shapes) is left out: name them walls'
    """

    layers: tuple[Layer, ...]
    bounds_space: bool
    remedy: str

    @property
    def left_out(self) -> tuple[Layer, ...]:
        """The layers that were left out, since their names say nothing about space."""
        return tuple(layer for layer in self.layers if not layer.read_as)

    @property
    def problem(self) -> str:
        """That no layer read bounds free space, and the remedy; empty if one does."""
        if self.bounds_space or not self.left_out:
            return ""
        return (
            f"no layer is read as walls or free space, and {left_out_names(self)} "
            f"{'is' if len(self.left_out) == 1 else 'are'} left out: {self.remedy}"
        )

    def __str__(self) -> str:
        """Return what was read and what was left out as text on one line."""
        uses = dict.fromkeys(layer.read_as for layer in self.layers if layer.read_as)
        read = ", ".join(
            f"{_listed([one.name for one in self.layers if one.read_as == use])} ({use})"
            for use in uses
        )
        if not self.left_out:
            return f"layers read: {read}"
        return f"layers read: {read}; left out: {left_out_names(self)}; {self.remedy}"


def left_out_names(layers: Layers) -> str:
    """Return the layers that were left out, with their numbers of shapes.

    Examples
    --------
    >>> found = Layers(layers=(Layer("", "", 1),), bounds_space=True, remedy="")
    >>> left_out_names(found)
    'what is in no layer (1 shape)'
    """
    return _listed(
        [
            f"{one.name or 'what is in no layer'} ({one.shapes} shape{'s' * (one.shapes > 1)})"
            for one in layers.left_out
        ]
    )


def counted_layers(shapes: Iterable[tuple[str, str]]) -> tuple[Layer, ...]:
    """Return the layers of the shapes of a drawing, in the order of the drawing.

    Parameters
    ----------
    shapes : iterable of (name, read_as)
        For each shape the name of its layer, and what it was read as.

    Examples
    --------
    >>> counted_layers([("A-WALL", "walls"), ("Text", ""), ("A-WALL", "walls")])
    (Layer(name='A-WALL', read_as='walls', shapes=2), Layer(name='Text', read_as='', shapes=1))
    """
    counts: dict[tuple[str, str], int] = {}
    for name, read_as in shapes:
        key = (name[:MAX_NAME_LENGTH], read_as)
        counts[key] = counts.get(key, 0) + 1
    return tuple(Layer(*key, count) for key, count in counts.items())


def _listed(names: Sequence[str]) -> str:
    more = len(names) - MAX_NAMES
    text = ", ".join(names[:MAX_NAMES])
    return f"{text} and {more} other{'s' * (more > 1)}" if more > 0 else text
