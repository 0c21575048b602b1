"""Reading of pictures: layers, texts and lines of SVG."""

import re
import xml.etree.ElementTree as ET

import numpy as np

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


def layers(svg: str) -> dict[str, ET.Element]:
    """Return the layers of a picture by their labels."""
    return {
        group.get(INKSCAPE + "label", ""): group
        for group in ET.fromstring(svg).iter(SVG + "g")
        if group.get(INKSCAPE + "groupmode") == "layer"
    }


def texts(svg: str) -> list[str]:
    """Return all texts of a picture, in order."""
    return [element.text or "" for element in ET.fromstring(svg).iter(SVG + "text")]


def lines(path: str) -> list[np.ndarray]:
    """Return the points of each line in path data of straight lines."""
    found = []
    for piece in re.findall(r"M([^Mz]*)z?", path):
        first, *rest = piece.split("l")
        values = [np.array(re.findall(r"-?[\d.]+", part), float) for part in (first, *rest)]
        found.append(np.concatenate(values).reshape(-1, 2).cumsum(axis=0))
    return found


def paths(layer: ET.Element) -> str:
    """Return the path data of a layer."""
    return "".join(path.get("d", "") for path in layer.iter(SVG + "path"))


def on_page(svg: str, x: float, y: float) -> tuple[float, float]:
    """Return the position on the page of a place of the map, in user units."""
    transform = layers(svg)["map"].get("transform", "")
    right, down = map(float, re.findall(r"translate\((\S+) (\S+)\) scale\(1 -1\)", transform)[0])
    return right + x, down - y
