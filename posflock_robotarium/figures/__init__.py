"""How figures look (``style``), and those of the nine-robot experiment (``experiment``)."""

__all__ = ["experiment", "style"]
