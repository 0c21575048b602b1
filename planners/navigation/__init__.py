"""Reactive driving, following of paths, and who goes first where robots meet."""
