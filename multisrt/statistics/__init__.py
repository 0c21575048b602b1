"""Statistics of many runs: pure functions on arrays, which know nothing of robots.

A value is one number measured of one run. Where lower is better, a run that failed has the value
``inf``, worse than all others; where higher is better, ``-inf``. What goes by ranks takes such
values as ties at the worst end; means refuse them; nan is refused everywhere. A stratum is the
array of values of one task: a world, a team size, whatever was repeated under the same conditions.

Random generators are given, as a `numpy.random.Generator` or a seed: the same one gives the same
result.
"""
