"""Experiments: many runs over conditions and repetitions, stored and resumable."""
