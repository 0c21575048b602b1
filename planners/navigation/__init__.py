"""Path following, reactive driving, and right of way between robots."""
