"""XML from untrusted sources as a tree of bounded size, without entities and references."""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from xml.parsers import expat

from multisrt.environments.formats.files import read_text
from multisrt.geometry.errors import MapFormatError

MAX_XML_BYTES: Final = 32 * 2**20
"""Upper bound of the size of XML files, in bytes (32 MiB)."""

MAX_ELEMENTS: Final = 200_000
"""Upper bound of the number of elements."""

MAX_DEPTH: Final = 100
"""Upper bound of the nesting of elements."""


@dataclass(slots=True)
class Element:
    """An element of an XML document.

    Attributes
    ----------
    name : str
        Its name without namespace.
    namespace : str
        The URI of its namespace; empty if it has none.
    attributes : dict of str to str
        Values by name; the name of an attribute in a namespace is the URI, a space and the name.
    line : int
        The line on which it begins.
    children : list of Element
        Elements in it.
    text : str
        Text in it, outside its children.
    """

    name: str
    namespace: str
    attributes: dict[str, str]
    line: int
    children: list["Element"] = field(default_factory=list)
    text: str = ""


def read_xml(path: Path) -> Element:
    """Return the root of an XML file.

    Parameters
    ----------
    path : Path
        A file in UTF-8 of at most 32 MiB and 200,000 elements, nested at most 100 deep. It may
        name a document type, which is not opened, but not declare one.

    Raises
    ------
    MapFormatError
        If the file is missing, too large or not well-formed, or declares entities or anything
        else.

    Examples
    --------
    >>> from pathlib import Path
    >>> Path("plan.xml").write_text("<plan><wall/></plan>")
    20
    >>> read_xml(Path("plan.xml")).children[0].name
    'wall'
    """
    text = read_text(path, max_bytes=MAX_XML_BYTES)
    builder = _Builder(path)
    try:
        builder.parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        raise MapFormatError(
            f"{path}, line {error.lineno} is not well-formed XML: "
            f"{expat.ErrorString(error.code)}; save the file again"
        ) from error
    assert builder.root is not None
    return builder.root


def root_name(text: str) -> str:
    """Return the name of the root element with which a text begins; empty if it is not XML.

    Examples
    --------
    >>> root_name("<?xml version='1.0'?> <!-- a plan --> <svg:svg width='1'>")
    'svg'
    """
    at = 0
    while found := _BEFORE_ROOT.match(text, at):
        at = found.end()
    root = _ROOT.match(text, at)
    return root.group(1) if root else ""


_BEFORE_ROOT: Final = re.compile(
    r"\s+|<\?[^>]*>|<!--(?:[^-]|-[^-])*-->|<!DOCTYPE[^>\[]*(?:\[[^\]]*\]\s*)?>"
)
_ROOT: Final = re.compile(r"<(?:[\w.-]+:)?([\w.-]+)[\s/>]")


class _Builder:
    """Parser callbacks that build the tree."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.root: Element | None = None
        self._open: list[Element] = []
        self._texts: list[list[str]] = []
        self._count = 0
        parser = expat.ParserCreate("utf-8", " ")
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._data
        parser.StartDoctypeDeclHandler = self._document_type
        parser.EntityDeclHandler = self._entity
        parser.ExternalEntityRefHandler = self._reference
        self.parser = parser

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        self._count += 1
        if self._count > MAX_ELEMENTS:
            raise MapFormatError(
                f"{self.path} has more than {MAX_ELEMENTS:,} elements; simplify the drawing"
            )
        if len(self._open) >= MAX_DEPTH:
            raise MapFormatError(
                f"{self.path}, line {line}: elements are nested more than {MAX_DEPTH} deep; "
                "ungroup them"
            )
        namespace, _, local = name.rpartition(" ")
        element = Element(local, namespace, attributes, line)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)
        self._texts.append([])

    def _end(self, name: str) -> None:
        self._open.pop().text = "".join(self._texts.pop())

    def _data(self, data: str) -> None:
        if self._texts:
            self._texts[-1].append(data)

    def _document_type(
        self, name: str, system: str | None, public: str | None, declares: bool
    ) -> None:
        if declares:
            self._refuse("declarations in its document type")

    def _entity(self, *declaration: object) -> None:
        self._refuse("a declaration of an entity")

    def _reference(self, *reference: object) -> int:
        self._refuse("a reference to another file")
        return 0

    def _refuse(self, what: str) -> None:
        raise MapFormatError(
            f"{self.path}, line {self.parser.CurrentLineNumber} has {what}, which is not read; "
            "save the file without it (as plain SVG, if it is a drawing)"
        )
