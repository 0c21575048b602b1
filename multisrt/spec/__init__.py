"""The complete description of a run: equal specs give equal recordings, byte for byte."""

from multisrt.spec.base import BaseSpec
from multisrt.spec.environments import (
    CatalogEnvironment,
    EnvironmentSpec,
    FileEnvironment,
    InlineEnvironment,
    SuiteEnvironment,
)
from multisrt.spec.faults import Death, Fault, LateStart, Silence
from multisrt.spec.part import Scalar
from multisrt.spec.radio import RadioSpec
from multisrt.spec.robots import (
    MAX_BEAMS,
    MAX_RANGE_M,
    MIN_RANGE_M,
    DriveSpec,
    RangeFinderSpec,
    RobotSpec,
)
from multisrt.spec.run import PlacedHow, RunSpec, StopRule

__all__ = [
    "MAX_BEAMS",
    "MAX_RANGE_M",
    "MIN_RANGE_M",
    "BaseSpec",
    "CatalogEnvironment",
    "Death",
    "DriveSpec",
    "EnvironmentSpec",
    "Fault",
    "FileEnvironment",
    "InlineEnvironment",
    "LateStart",
    "PlacedHow",
    "RadioSpec",
    "RangeFinderSpec",
    "RobotSpec",
    "RunSpec",
    "Scalar",
    "Silence",
    "StopRule",
    "SuiteEnvironment",
]
