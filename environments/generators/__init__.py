"""Generators: worlds drawn from a few parameters and a seed, one kind of world per module.

Every generator is a function of keyword-only parameters and a ``seed`` that returns an
:class:`~multisrt.environments.environment.Environment`; equal arguments give equal worlds.
Free space is one piece for a body a little narrower than the doors or passages, has no gap
narrower than 0.7 m and no pocket that cannot be reached. A parameter out of its range is an
:class:`~multisrt.geometry.errors.InvalidInputError` that names the range.

The names under which experiments ask for them are in :mod:`multisrt.environments.catalog`.
"""
