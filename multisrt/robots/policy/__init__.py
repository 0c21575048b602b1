"""Robots whose goals are chosen by a policy: a function of what the robot observes.

They are robots of the frontier family (`multisrt.robots.frontier`): they sense, drive, talk and
give way as those do, and ask the policy whenever they need a goal. What they observe is made from
their scans, their messages and their own place alone.
"""

from multisrt.robots.policy.decision_spec import Answer, DecisionSpec
from multisrt.robots.policy.explorer import Policy, PolicyExplorer, PolicyOptions
from multisrt.robots.policy.observing import Observation
from multisrt.robots.policy.strategy import policy_strategy

__all__ = [
    "Answer",
    "DecisionSpec",
    "Observation",
    "Policy",
    "PolicyExplorer",
    "PolicyOptions",
    "policy_strategy",
]
