"""The flock in the simulated arena: one trial, and many in parallel."""

__all__ = ["flock_trial"]
