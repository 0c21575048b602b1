"""The public indoor exploration competition: our strategies in the simulator of a clone of it.

Nothing of the competition is part of this package: users clone it themselves.
"""
