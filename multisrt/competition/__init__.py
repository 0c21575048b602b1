"""Running strategies of this package in the simulator of the public indoor exploration competition.

No file of the competition is part of this package: users clone its repository themselves.
"""
