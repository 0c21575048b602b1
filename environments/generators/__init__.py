"""Generators: worlds drawn from a few parameters and a seed, one kind of world per module.

Every generator is a function of keyword-only parameters and a ``seed`` that returns an
:class:`~multisrt.environments.environment.Environment`; equal arguments give equal worlds.
Free space is connected for a body a little narrower than the doors or passages, and has no gap
narrower than 0.7 m and no pocket that cannot be reached. A parameter out of range raises an
:class:`~multisrt.geometry.errors.InvalidInputError` that names the range.

:mod:`multisrt.environments.catalog` has their names, as used in experiments.
"""
