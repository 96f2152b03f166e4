"""Compiled lanes: one buffer, its plant, its metrics, and a kernel for each law."""
