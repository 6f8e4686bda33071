"""Over how many seeds the paper is judged where nobody asks for others.

What is seen at all of a hundred has an interval that begins at 0.963, so that a share of 95 in 100
can be shown; of twenty it begins at 0.839, which shows no such thing.
"""

SEEDS = 100
