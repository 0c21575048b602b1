"""Who goes to which frontier: rules on tables of distances, one to a file.

Each is a pure function of arrays. Rows are robots in the order of their ids, columns are
frontiers; distances are in metres, ``inf`` where there is no way. All ties are broken by
distance, then for the robot of the lower id, then for the frontier of the lower index, so that
robots that know the same decide alike.
"""
