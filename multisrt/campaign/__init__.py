"""A campaign of missions that tries to break the program, and judges each by invariants."""
