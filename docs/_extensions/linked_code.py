"""Link code in pages and docstrings to the API: `Run` or `ms.explore` needs no markup.

Pages stay plain Markdown, and docstrings plain text. What is written as code becomes a link if it
names one documented object: by its full name, by the end of it (``Run.why``), or by the last word
alone if that is a class, a function with an underscore, or ends with ``()``. A full name that does
not exist is an error. In the type of a parameter ("Footprint or None") every word that names a
documented class becomes a link. An *emphasised* term of the glossary links there.
"""

from __future__ import annotations

import re
from importlib import import_module

from docutils import nodes
from sphinx.addnodes import desc_signature, pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

PACKAGE = "multisrt"
SHORT = "ms"
"""The name under which examples import the package."""

NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*(\(\))?")
CLASS = re.compile(r"[A-Z]\w*[a-z]\w*")
IN_TYPE = re.compile(r"\b(?:[a-z]\w*\.)*[A-Z]\w*[a-z]\w*\b")
WORDS = re.compile(r"[a-z]+_\w+")
LINKED = {"class", "exception", "function", "method", "property", "type"}

logger = logging.getLogger(__name__)


class CodeLinks(SphinxPostTransform):
    """Turns code that names documented objects into links."""

    default_priority = 5

    def run(self, **_: object) -> None:
        """Link the code of one page."""
        for literal in list(self.document.findall(nodes.literal)):
            text = literal.astext()
            if NAME.fullmatch(text) and not _is_linked(literal):
                link = self.link(text, literal.deepcopy(), _object_around(literal))
                if link is not None:
                    literal.replace_self(link)
                elif text.startswith(f"{PACKAGE}.") and not exists(text):
                    logger.warning("there is no %s", text, location=literal, type="linked_code")
        for name in list(self.document.findall(nodes.emphasis)):
            if isinstance(name.parent, nodes.paragraph) and _is_type(name):
                name.replace_self(nodes.emphasis("", "", *self.linked_words(name.astext())))
            elif not _is_linked(name):
                self.link_term(name)

    def link_term(self, name: nodes.emphasis) -> None:
        """Make a link of a term of the glossary."""
        text = name.astext()
        for term in (text, text.lower()):
            page, anchor = self.env.domains.standard_domain.objects.get(("term", term), ("", ""))
            if page and page != self.env.docname:
                here = self.env.docname
                link = make_refnode(self.app.builder, here, page, anchor, name.deepcopy(), term)
                name.replace_self(link)
                return

    def link(self, text: str, shown: nodes.TextElement, around: str) -> nodes.reference | None:
        """Return a link to the object that a text names; None if there is none, or it is here."""
        found = find(self.env, text)
        if found is None or found[0] == around:
            return None
        name, page, anchor = found
        return make_refnode(self.app.builder, self.env.docname, page, anchor, shown, name)

    def linked_words(self, text: str) -> list[nodes.Node]:
        """Return the type of a parameter, with links."""
        parts: list[nodes.Node] = []
        end = 0
        for match in IN_TYPE.finditer(text):
            link = self.link(match[0], nodes.inline("", match[0]), "")
            if link is not None:
                parts += [nodes.Text(text[end : match.start()]), link]
                end = match.end()
        return [*parts, nodes.Text(text[end:])]


def find(env: BuildEnvironment, text: str) -> tuple[str, str, str] | None:
    """Return full name, page and anchor of the one object that a text names; else None."""
    called = text.endswith("()")
    text = text.removesuffix("()")
    if text.startswith(f"{SHORT}."):
        text = f"{PACKAGE}{text.removeprefix(SHORT)}"
    kinds = {"function"} if WORDS.fullmatch(text) and not called else LINKED
    if not (called or "." in text or CLASS.fullmatch(text) or kinds != LINKED):
        return None
    objects = env.domains.python_domain.objects
    if text in objects:
        names = [text]
    else:
        names = [
            name
            for name, entry in objects.items()
            if name.endswith(f".{text}") and entry.objtype in kinds and not entry.aliased
        ]
    owner = text.rpartition(".")[0]
    if not names and CLASS.fullmatch(owner.rpartition(".")[2]):
        return find(env, owner)  # a field, which its class describes
    if len(names) != 1:
        return None
    entry = objects[names[0]]
    return names[0], entry.docname, entry.node_id


def exists(name: str) -> bool:
    """Whether a full name is a module, or something in one."""
    parts = name.removesuffix("()").split(".")
    for end in range(len(parts), 0, -1):
        try:
            found: object = import_module(".".join(parts[:end]))
            for part in parts[end:]:
                found = getattr(found, part)
        except (ImportError, AttributeError):
            continue
        return True
    return False


def _is_linked(node: nodes.Node) -> bool:
    return any(
        isinstance(n, nodes.reference | pending_xref | nodes.title) for n in _ancestors(node)
    )


def _is_type(node: nodes.Node) -> bool:
    # Types are emphasised in the lists of parameters, and nothing else is.
    return any(isinstance(n, nodes.field) for n in _ancestors(node))


def _object_around(node: nodes.Node) -> str:
    for ancestor in _ancestors(node):
        if ancestor.children and isinstance(ancestor.children[0], desc_signature):
            ids = ancestor.children[0].get("ids")
            return ids[0] if ids else ""
    return ""


def _ancestors(node: nodes.Node) -> list[nodes.Element]:
    found = []
    parent = node.parent
    while parent is not None:
        found.append(parent)
        parent = parent.parent
    return found


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.add_post_transform(CodeLinks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
