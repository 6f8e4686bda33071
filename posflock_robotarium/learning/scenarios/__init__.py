"""Tasks to learn: a file each; `learning.scenario` says what one of your own has to tell."""

__all__ = ["flocking", "navigation", "predator_prey"]
