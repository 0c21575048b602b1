"""A finished run: its metrics, explanations, pictures, tables and files."""

from multisrt.finished_run.saved import (
    RECORDING_NAME,
    RUN_FILES,
    RUN_NAME,
    SPEC_NAME,
    TREE_NAME,
    Run,
)

__all__ = ["RECORDING_NAME", "RUN_FILES", "RUN_NAME", "SPEC_NAME", "TREE_NAME", "Run"]
