"""Mutants that no test can kill, since they change nothing that anyone could see, and why.

Each is the end of a file's path, a part of the line, a part of the change, and the reason.
"""

EQUIVALENT: list[tuple[str, str, str, str]] = []
