"""Replays of runs in a browser: pages that need neither a network nor a server."""

from multisrt.replay.live import LiveReplay
from multisrt.replay.page import MAX_RUNS, replay_html, save_replay

__all__ = ["MAX_RUNS", "LiveReplay", "replay_html", "save_replay"]
