"""How autodoc shows structures and type aliases of the package.

The fields of structures are described in the section Attributes of their docstrings, so they are
no members of their own; long defaults are left out of signatures. ``.. alias:: NAME`` documents a
union of types by its members.
"""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from typing import Any, get_args

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FIELDS = ("_tuplegetter", "member_descriptor")
"""Types of the descriptors that are fields: of named tuples, and of classes with slots."""

MAX_DEFAULT = 24
"""Maximum length of a default value that a signature shows."""

Docs = list[str]


class Alias(SphinxDirective):
    """Documents a union of types."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the description of the alias, with its members."""
        module, _, name = self.arguments[0].rpartition(".")
        value = getattr(import_module(module), name)
        members = ", ".join(map(_name_of, get_args(value)))
        lines = [
            f".. py:currentmodule:: {module}",
            "",
            f".. py:type:: {name}",
            "",
            *(f"   {line}" for line in self.content),
            "",
            f"   One of {members}.",
        ]
        return self.parse_text_to_nodes(StringList(lines, source=str(self.get_source_info()[0])))


def _name_of(member: Any) -> str:
    if member is type(None):
        return "None"
    inner = get_args(member)
    if inner:
        return f"a tuple of `{inner[0].__name__}`"
    return f"`{member.__name__}`"


class _Shown:
    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def short_signature(
    _app: Sphinx, what: str, _name: str, obj: Any, _options: Any, signature: str, _result: str
) -> tuple[str, str] | None:
    """Leave long defaults out of the signature of a class or function."""
    if what not in ("class", "function") or not signature:
        return None
    if getattr(obj, "_is_protocol", False):
        return "", ""
    try:
        found = inspect.signature(obj)
    except (TypeError, ValueError):
        return None
    parameters = [
        p.replace(annotation=p.empty, default=p.default if p.default is p.empty else _short(p))
        for p in found.parameters.values()
    ]
    return str(found.replace(parameters=parameters, return_annotation=found.empty)), ""


def _short(parameter: inspect.Parameter) -> object:
    text = repr(parameter.default)
    return _Shown("…") if len(text) > MAX_DEFAULT or text.startswith("<") else _Shown(text)


def is_field(_app: Sphinx, _what: str, _name: str, member: object, skip: bool, _: Any) -> bool:
    """Leave out members that are fields."""
    return skip or type(member).__name__ in FIELDS


_kept: dict[str, Docs] = {}


def keep(_app: Sphinx, what: str, name: str, _obj: Any, _options: Any, lines: Docs) -> None:
    """Remember the docstring of a property as it is."""
    if what in ("property", "attribute", "data"):
        _kept[name] = list(lines)


def restore(_app: Sphinx, _what: str, name: str, _obj: Any, _options: Any, lines: Docs) -> None:
    """Undo what napoleon has made of "words: more words", which it takes for a type."""
    before = _kept.pop(name, None)
    if before is not None and not any(re.fullmatch(r"-{3,}", line) for line in before):
        lines[:] = before


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.add_directive("alias", Alias)
    app.connect("autodoc-process-signature", short_signature)
    app.connect("autodoc-skip-member", is_field)
    app.connect("autodoc-process-docstring", keep, priority=400)
    app.connect("autodoc-process-docstring", restore, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
