"""Rules that assign frontiers to robots, one rule per file.

The rules are pure: the same costs give the same choices. Robots and frontiers are numbered from 0;
robots in ascending order of their ids. Costs are path lengths in metres, ``inf`` where no path is
known.

`closest`, `greedy` and `minpos` take a `CostOracle`, which may compute costs only when asked for
them; `DenseCosts` is the oracle of a table. `utility` and `self_bidding` depend on every cost and
take tables. `choose_cell` and `exchange` are the two rules of Álvarez.

Ties are broken by cost, then by the lower robot, then by the lower frontier, so that robots with
the same knowledge decide alike.
"""
