"""The base class of all parts of a spec."""

from __future__ import annotations

import msgspec

Scalar = bool | int | float | str


class Part(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """A part of a spec: immutable, with no unknown fields."""
