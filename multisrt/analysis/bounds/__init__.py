"""Times below which no team can have seen a share of a world: theorems, with their proofs."""

from multisrt.analysis.bounds.lower_bounds import AREA_ERROR, LowerBounds, lower_bounds

__all__ = ["AREA_ERROR", "LowerBounds", "lower_bounds"]
