"""Campaigns: very many drawn runs, each held against invariants, to find what breaks them."""
