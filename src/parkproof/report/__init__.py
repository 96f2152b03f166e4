"""Figures, claims and pages."""
