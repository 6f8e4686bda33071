"""The flock for many teams at once: law, filter, steering and certificate as arrays (B, 2, N).

Studies run a flock from a thousand starts. A step of one team is some hundred calls of numpy
on arrays of nine numbers; here a call does it for all teams. Nothing is decided anew: law,
neighbours, filter and limits are those of `flocking`, which take a batch of teams as they stand;
certificate and arena are those of `barrier_certificates.batch` and `rps_compat.batch`.

- `batch_flock`: `BatchFlock`, what `Flock` is for one team;
- `team_laws`: laws with other parameters for each team;
- `batch_steering`: arena steering, the one part that is about a team as a whole;
- `batch_trial`: trials in the simulated arena, each as `simulate` returns it.
"""

__all__ = ["batch_flock", "batch_trial"]
