"""Studies: many runs of one experiment, described in a file, kept in a store that survives.

===========  ==========================================================================
study        a TOML file becomes a list of runs, each with a key and a random stream of
             its own
experiments  what can be run: a name, its parameters, a function of parameters and seeds
store        finished runs on disk, appended; whatever kills the sweep, they stay
execution    what is missing is computed, by local processes or on a Dask cluster
results      tidy tables, medians with confidence intervals, figures
===========  ==========================================================================
"""
