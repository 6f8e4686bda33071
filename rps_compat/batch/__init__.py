"""Thousands of teams at once: the arena as arrays (B, 3, N), compiled where numba is installed.

From the outside in:

- `batch_arena`: B teams and their steps; `batch_violations`: what is counted;
- `rollout`: many steps under a certificate; `rollout_kernel`: the same, compiled;
- `batch_effects`: realism profiles for many teams; `team_profiles`: where they differ;
  `random_streams`: a stream for each;
- `step_kernel`: a step, compiled; `count_kernel`: what is held against a team; `step_constants`:
  robot models for both; `step_arrays`: a step in numpy.
"""

from rps_compat.batch.batch_arena import BatchArena
from rps_compat.batch.batch_violations import BatchViolations
from rps_compat.batch.rollout import Hold, Rollout, RolloutOutcome, ToGoals, rollout

__all__ = [
    "BatchArena",
    "BatchViolations",
    "Hold",
    "Rollout",
    "RolloutOutcome",
    "ToGoals",
    "rollout",
]
