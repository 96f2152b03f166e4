"""Simulation: one run in plain Python, and the same functions compiled for many."""
