"""Returning data: when robots drive back so that the base station learns what they know."""
