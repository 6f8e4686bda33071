"""Learn on the batch, act on the testbed: scenarios, environments, and a trainer.

From the inside out:

- `scenario`: what a task says of itself; `scenarios`: three of them;
- `teams`: B teams at a task, a step after the other, by numpy alone;
- `vector_env`, `parallel_env`: the same for learners, as gymnasium and pettingzoo have it; they
  need the extra ``learn``, and say so without;
- `evolution`, `training`: an evolution strategy, and a policy found by it;
- `policy_files`: what a training leaves, weights first;
- `rendering`: a team in its arena as a picture; `learning_curve`: how a search went.

What a trained policy needs on board is none of this: `flocking.trained_policy` and what it sees.
"""

__all__ = [
    "evolution",
    "learning_curve",
    "libraries",
    "parallel_env",
    "policy_files",
    "scenario",
    "scenarios",
    "teams",
    "training",
    "vector_env",
]
