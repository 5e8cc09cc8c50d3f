"""Fleets of robots: populations of parameters, outliers and drift."""
