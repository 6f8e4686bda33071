"""Examples of state estimation."""
