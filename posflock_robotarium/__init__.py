"""Position-based flocking on the Robotarium: the law, the experiment, and what became of it."""

__version__ = "0.1.0"
