"""Experiments from keywords: the short form of `multisrt.compare`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from numbers import Integral
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from multisrt.environments.environment import Environment
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec, RadioChoice
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import builtin
from multisrt.simulation.worlds import inline
from multisrt.spec import RadioSpec
from multisrt.spec.keywords import base_of


def from_keywords(given: Mapping[str, Any]) -> ExperimentSpec:
    """Return the experiment that the keywords of `multisrt.compare` describe.

    Parameters
    ----------
    given : mapping
        Conditions by name, one or several of each, and other fields of `ExperimentSpec`.

    Returns
    -------
    ExperimentSpec
        The experiment; it keeps no recordings by default.

    Raises
    ------
    InvalidInputError
        If a field is wrong; the message names it.

    Examples
    --------
    >>> spec = from_keywords({"environments": "open", "strategies": "minpos", "seeds": 3})
    >>> spec.strategies, spec.repetitions
    (('minpos',), 3)
    """
    fields: dict[str, Any] = {"name": "Comparison", "recordings": "none"} | dict(given)
    for name in ("environments", "strategies", "robots", "starts", "radios", "faults"):
        if name in fields:
            fields[name] = _several(fields[name])
    fields["environments"] = [_environment(one) for one in fields["environments"]]
    if "radios" in fields:
        fields["radios"] = [_radio(one) for one in fields["radios"]]
    if "base" in fields:
        fields["base"] = base_of(fields["base"])
    if "seeds" in fields:
        fields |= _repetitions(fields.pop("seeds"))
    return from_fields(fields)


def from_fields(fields: object) -> ExperimentSpec:
    """Return an experiment with the given fields, numbers of numpy in them as builtin ones.

    Parameters
    ----------
    fields : ExperimentSpec or mapping
        The experiment, or its fields by name.

    Returns
    -------
    ExperimentSpec
        The experiment.

    Raises
    ------
    InvalidInputError
        If a field is wrong; the message names it.
    """
    try:
        plain = msgspec.to_builtins(fields, enc_hook=builtin)
    except (TypeError, NotImplementedError) as error:
        raise InvalidInputError(
            f"an experiment consists of text, numbers and the parts of an ExperimentSpec "
            f"({', '.join(ExperimentSpec.__struct_fields__)}): {error}"
        ) from None
    return ExperimentSpec.from_dict(plain)


def _several(given: object) -> list[Any]:
    if isinstance(given, Iterable) and not isinstance(given, (str, bytes, dict)):
        return list(given)
    return [given]


def _repetitions(seeds: object) -> dict[str, int]:
    if isinstance(seeds, bool):
        raise InvalidInputError(f"seeds are a number of repetitions, or a range, not {seeds}")
    if isinstance(seeds, Integral):
        if seeds < 1:
            raise InvalidInputError(f"seeds are a number of repetitions from 1 on, not {seeds}")
        return {"repetitions": int(seeds)}
    if not isinstance(seeds, Iterable) or isinstance(seeds, str):
        raise InvalidInputError(f"seeds are a number of repetitions, or a range, not {seeds!r}")
    given = list(seeds)
    if not all(isinstance(seed, Integral) and not isinstance(seed, bool) for seed in given):
        raise InvalidInputError(f"seeds are whole numbers, not {seeds!r}")
    if not given or given != list(range(given[0], given[0] + len(given))):
        raise InvalidInputError(
            f"seeds are consecutive numbers, as in range(100, 120), not {seeds!r}"
        )
    return {"first_seed": int(given[0]), "repetitions": len(given)}


def _environment(given: object) -> object:
    if isinstance(given, Environment):
        written = inline(given)
        return EnvironmentChoice(name=written.name, wkt=written.wkt, starts=written.starts)
    return str(given) if isinstance(given, Path) else given


def _radio(given: object) -> object:
    if isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool):
        return RadioChoice(range_m=float(given))
    if isinstance(given, RadioSpec) and not isinstance(given, RadioChoice):
        return RadioChoice(**msgspec.structs.asdict(given))
    return given
