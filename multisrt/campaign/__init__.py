"""Campaigns: randomly drawn missions, each of which is checked against invariants."""
