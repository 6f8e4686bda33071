"""Runs as files: what a script left, read and written.

``readers`` makes a recording out of any file of poses, one module a form; ``convert`` writes one in
other forms; ``recorder`` offers the pose log to scripts that know nothing of it.
"""

__all__ = ["convert", "readers", "run"]
