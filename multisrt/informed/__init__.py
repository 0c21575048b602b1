"""The informed plan: what an exploration takes for a team that knows the map.

Its robots drive routes that are planned on the truth, so that they see all that there is to see
in little time. It is the only strategy that sees the truth. It is not a competitor but a reference:
an upper bound of the time that perfect knowledge needs, by which the times of strategies are
judged.

`views` says what is seen from a place, `roadmap` how a body gets from place to place, `routes`
divides places among robots, `search` finds places and routes that see enough, `timetable` times
them so that robots do not meet, `plan` puts these together, `explorer` drives them, `reference`
compares with them.
"""
