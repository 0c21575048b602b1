"""Explorers to start from, which `multisrt strategy new` copies: a rule, a planner, an explorer."""
