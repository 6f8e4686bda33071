"""From how many runs on there is an interval, everywhere: of one or two it says nothing."""

FEWEST_RUNS = 3
"""Runs below which no interval is told, by whatever method."""
