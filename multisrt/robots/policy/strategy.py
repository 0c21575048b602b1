"""A policy as a strategy, to be compared with all others."""

from __future__ import annotations

from typing import Any

from multisrt.robots.built_in import require_no_car
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.policy.decision_spec import DecisionSpec
from multisrt.robots.policy.explorer import Policy, PolicyExplorer, PolicyOptions
from multisrt.robots.strategy import Strategy
from multisrt.spec import RunSpec


def policy_strategy(
    name: str,
    policy: Policy | None,
    spec: DecisionSpec | None = None,
    *,
    summary: str = "Where a policy says",
) -> Strategy:
    """Return the strategy of robots that go where a policy says.

    Stores of experiments know a strategy by its name and its code, and not by the weights that a
    policy reads from a file: after training, give it another name, or use another store.

    Parameters
    ----------
    name : str
        Its name; the choices are recorded under it, too.
    policy : callable or None
        Takes what a robot observes (a dict of arrays), and returns the number of a frontier, or
        the offset of a place. One policy serves all robots: it must keep nothing from one call
        to the next, or runs would not repeat. None: answers come from outside; see
        `PolicyExplorer`.
    spec : DecisionSpec, optional
        What robots observe and may be answered.
    summary : str, optional
        One line for lists.

    Returns
    -------
    Strategy
        To be given to `multisrt.register`.

    Examples
    --------
    Always to the nearest frontier, the first of those that are observed:

    >>> import multisrt as ms
    >>> spec = DecisionSpec(observe=())
    >>> first = policy_strategy("first-frontier", lambda observation: 0, spec)
    >>> run = ms.explore("open", strategy=first, seed=1)
    >>> run.outcome, run.metrics.coverage > 0.99
    ('complete', True)
    """
    decisions = DecisionSpec() if spec is None else spec

    def explorer(me: RobotSelf, options: PolicyOptions) -> Explorer:
        return PolicyExplorer(me, options, decisions, policy, rule=name)

    if policy is not None:
        # The strategy is one of the policy's module: loading by reference goes by that.
        known: Any = getattr(policy, "func", policy)  # of a functools.partial
        home = known if hasattr(known, "__name__") else type(known)
        explorer.__module__, explorer.__name__ = home.__module__, home.__name__
    return Strategy(
        name=name,
        summary=summary,
        options=PolicyOptions,
        explorer=explorer,
        fits=_require_fit,
    )


def _require_fit(spec: RunSpec) -> None:
    if spec.options.get("drive") == "nearness-diagram":
        require_no_car(spec)
