"""Suites: named and versioned sets of thirty worlds that are held out for comparisons.

>>> from multisrt import suites
>>> suites.names()
('indoor-30', 'mazes-30', 'outdoor-30')
>>> indoor = suites.load("indoor-30")
>>> indoor[7].name
'indoor-30/07'

A world is built when it is accessed, and its digest is compared with that of the suite.
"""

from multisrt.environments.suites.loading import is_world, load, names, world
from multisrt.environments.suites.suite import Suite, digest_of

__all__ = ["Suite", "digest_of", "is_world", "load", "names", "world"]
