"""The paper, recomputed: its figures, its table and every sentence of it that can be checked.

Jond et al., "Position-Based Flocking for Persistent Alignment without Velocity Sensing",
show one run of three models and one experiment.  Here the same is computed over many
seeds, as four steps that only look back:

=============  ==================================================================
evidence       run everything that is judged or drawn, on all processors
claims         a sentence of the paper, a number measured in the evidence with its
               interval, and the thresholds that turn this into a verdict
tables         the qualitative table with numbers, and the table over seeds
paper_figures  the paper's figures, with median and quartiles over seeds
=============  ==================================================================

:func:`posflock_robotarium.paper.reproduction.reproduce` goes through all of them.
"""

__all__ = ["claim", "reproduction"]
