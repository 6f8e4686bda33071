"""How aligned a flock was, what else is to be said of a run, and how sure that is.

===============  ===============================================================
metrics          γ and its kin, of poses or velocities at one time
estimators       motion out of noisy poses, and how much of it is noise
curves           every metric over time
numbers          one number of each, with its unit and its uncertainty
catalogue        what each quantity is called, where it comes from, how it is told
verdicts         a judgement in words, where there are grounds for one
analysis         all of it for one run; ``comparison``: for several
truth            estimates against what a simulator knows
summary          the numbers of the nine-robot experiment
point_agents     the same for the paper's point agents
===============  ===============================================================
"""
