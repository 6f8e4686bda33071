"""Studies: many runs of one experiment, described in a file, kept in a store that survives.

===========  ==========================================================================
study        a TOML file becomes a list of runs, each with a key and a random stream of
             its own
experiments  what can be run: a name, its parameters, a function of parameters and seeds
points       the experiment ``freespace``; robots: the experiment of that name
scripts      any Robotarium script as an experiment, whose constants are its parameters
sources      the code behind an experiment: when it changes, its runs are computed again
store        finished runs on disk, appended; whatever kills the sweep, they stay
execution    what is missing is computed, by processes of this machine
cluster      the same on a Dask cluster
results      tidy tables, medians with confidence intervals, figures
===========  ==========================================================================
"""

__all__ = [
    "cluster",
    "execution",
    "experiments",
    "parameter_distribution",
    "points",
    "results",
    "store",
    "study",
]
