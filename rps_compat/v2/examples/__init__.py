"""Modules among the published examples; the examples themselves are scripts, to be run as files."""
