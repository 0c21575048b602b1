"""Recordings: all events of a run, one JSON object per line, written during the run.

The first line is a `Header`: the format and its version, the spec, the world, and the versions of
the packages. The events of `multisrt.events` follow in the order in which they were recorded. The
last line is a `Footer`: how the run ended, and the digest. A recording without a footer belongs to
a run that was interrupted.

The digest is the SHA-256 of the spec, the world and every event line: equal specs give equal
digests, in any process and on any machine of the same architecture with the same packages.
"""

from multisrt.recording.files import atomic_write, make_folder
from multisrt.recording.lines import (
    FORMAT,
    READABLE,
    VERSION,
    Footer,
    Header,
    RunOutcome,
    header_of,
)
from multisrt.recording.recorder import Recorder
from multisrt.recording.recording import Recording

__all__ = [
    "FORMAT",
    "READABLE",
    "VERSION",
    "Footer",
    "Header",
    "Recorder",
    "Recording",
    "RunOutcome",
    "atomic_write",
    "header_of",
    "make_folder",
]
