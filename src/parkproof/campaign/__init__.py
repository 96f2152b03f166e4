"""Campaigns: many trials drawn from distributions, whose rows are kept as they come."""
