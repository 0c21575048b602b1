"""Statistics of many runs: pure functions on arrays.

A value is one number measured in one run. A failed run has the value ``inf`` where lower is better
and ``-inf`` where higher is better, worse than all others. Statistics by ranks treat such values
as ties at the worst end; means refuse them; nan is always refused. A stratum is the array of
values of one task: one environment, one team size, whatever was repeated under equal conditions.

Random numbers come from a `numpy.random.Generator` or a seed that the caller gives: the same one
gives the same result.
"""
