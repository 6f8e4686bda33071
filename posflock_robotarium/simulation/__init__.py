"""The flock in the simulated arena: one trial, and many in parallel."""
