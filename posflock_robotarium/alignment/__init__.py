"""How aligned a flock was, what else is to be said of a run, and how sure that is.

===============  ===============================================================
metrics          γ and its kin, of poses or velocities at one time
estimators       motion out of noisy poses, and how much of it is noise
metric_registry  what an entry holds: words, computation, numbers, where it is drawn
catalogue        every metric over time and every number, one entry each
panels           the plots that the page draws them in
measured_run     a run whose metrics are computed when asked for; ``measuring`` asks
of_seen          means over the robots that are seen
reductions       the usual ways to take one number from a curve
faults           collisions and boundary crossings, by the testbed's own test
options          radius, window, thresholds
verdicts         a judgement in words, where there are grounds for one
certainty        how sure they are, by noise and by who is not seen
intervals        of a share, a median, a mean over runs; ``fewest_runs``: from how many on
analysis         all of it for one run; ``comparison``: for several
truth            estimates against what a simulator knows
summary          the numbers of the nine-robot experiment
point_agents     the same for the paper's point agents
===============  ===============================================================
"""

__all__ = [
    "analysis",
    "catalogue",
    "comparison",
    "estimators",
    "gamma_band",
    "measured_run",
    "metric_registry",
    "metrics",
    "options",
    "own_metrics",
    "point_agents",
    "questions",
    "reductions",
    "summary",
    "targets",
    "truth",
    "verdicts",
]
