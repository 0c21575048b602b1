"""Comparisons that hold: many runs over conditions and repetitions, stored, resumable."""
