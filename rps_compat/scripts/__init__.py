"""What a script is, and what the testbed has for it.

``run``, ``lint``, ``verify``, ``bundle`` and ``rehearse`` ask the same questions of a script, and
here each has its one answer: what is installed on the testbed (`libraries`).
"""
