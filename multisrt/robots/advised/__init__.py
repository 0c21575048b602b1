"""Robots whose goals are chosen by a policy: a function of what the robot observes.

They are robots of the frontier family (`multisrt.robots.frontier`): they sense, drive, talk and
give way as those do, and ask the policy whenever they need a goal. What they observe is made from
their scans, their messages and their own place alone.
"""

from multisrt.robots.advised.decision_spec import Answer, DecisionSpec
from multisrt.robots.advised.explorer import AdvisedExplorer, AdvisedOptions, Policy
from multisrt.robots.advised.observing import Observation
from multisrt.robots.advised.strategy import policy_strategy

__all__ = [
    "AdvisedExplorer",
    "AdvisedOptions",
    "Answer",
    "DecisionSpec",
    "Observation",
    "Policy",
    "policy_strategy",
]
