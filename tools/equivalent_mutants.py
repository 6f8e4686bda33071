"""Mutants that no test can kill, since they change nothing that anyone could see, and why.

Each is a part of the file's path, a part of the line, a part of the change, and the reason.
`mutations` makes none in annotations, docstrings and the words of messages.
"""

_SQUARE = "the array is square in these two axes"
_WHOLE = "whole numbers become floats in the arithmetic that follows"
_NOBODY = "nobody meets equality but by rounding, and either answer is right"
_SHORT = "a short way only: weights that are all alike give the plain mean"
_SPEED = "where the search begins; it ends at the one optimum"
_NO_COUNT = "any number will do that is the same for all sets whose rows have keys"
_ALL = "all rows are in from the start, so that none is ever added to these"
_UNIT = "the program has the same answer in any unit"
_SOONER = "a short way only: without it the solvers find that there is no answer"

EQUIVALENT: list[tuple[str, str, str, str]] = [
    ("law.py", "np.nextafter(0.0, 1.0)", "1.0 to 2.0", "the next float is in the same direction"),
    ("law.py", "agents = np.arange(distance.shape[-1])", "", _SQUARE),
    ("law.py", "p = np.asarray(positions", "without argument dtype", _WHOLE),
    ("law.py", "x = np.asarray(vectors", "without argument dtype", _WHOLE),
    ("law.py", "remembered = np.asarray(imprint", "without argument dtype", _WHOLE),
    ("steering.py", "along >= clear * lengths", "GtE to Gt", _NOBODY),
    (
        "alignment/",
        "np.flatnonzero(edges == -1) - 1, strict=True",
        "to False",
        "what begins also ends",
    ),
    ("standing.py", "for first, last in zip(", "strict", "what begins also ends"),
    ("alignment/", "if np.abs(steps - steps.mean())", "Sub to Add", _SHORT),
    ("alignment/", "if (weights == 1.0).all()", "to any", _SHORT),
    ("alignment/", "if (weights == 1.0).all()", "1.0 to 2.0", _SHORT),
    ("working_set.py", "self._bound_in = (0, 0)", "", "nothing is recalled of no rows"),
    ("working_set.py", "working[warm] = True", "left out", _SPEED),
    ("working_set.py", "if rows.key is None else -1", "without minus", _NO_COUNT),
    ("working_set.py", "if rows.key is None else -1", "1 to 2", _NO_COUNT),
    ("scaled_program.py", "if unit <= _FAST", "LtE to Lt", _UNIT),
    ("scaled_program.py", "-(1.0 + TOLERANCE) * math.sqrt(2.0)", "Add to Sub", _NOBODY),
    ("scaled_program.py", "-(1.0 + TOLERANCE) * math.sqrt(2.0)", "Lt to LtE", _NOBODY),
    ("infeasible.py", "np.ones(which.shape[0], dtype=bool)", "without argument dtype", _ALL),
    ("infeasible.py", "> TOLERANCE", "Gt to GtE", _NOBODY),
    ("infeasible.py", "<= TOLERANCE", "LtE to Lt", _NOBODY),
    ("infeasible.py", "> tolerance", "Gt to GtE", _NOBODY),
    ("infeasible.py", "> -BINDS", "Gt to GtE", _NOBODY),
    ("working_set.py", "> TOLERANCE", "Gt to GtE", _NOBODY),
    ("working_set.py", "> tolerance", "Gt to GtE", _NOBODY),
    ("working_set.py", "> -BINDS", "Gt to GtE", _NOBODY),
    ("working_set.py", "working[warm] = True", "to False", _SPEED),
    ("working_set.py", "self._bound = info.binding", "left out", _SPEED),
    ("working_set.py", "self._bound_in = _team(rows)", "left out", _SPEED),
    ("working_set.py", "_GUESSES = 8", "", "one more guess before a solver is asked"),
    ("working_set.py", "ROUNDS = 50", "", "five are many already"),
    ("projector.py", "self._search.forget()", "left out", _SPEED),
    ("projector.py", ".reshape(-1", "1 to 2", "numpy takes any negative number for the rest"),
    ("projector.py", "<= TOLERANCE", "LtE to Lt", _NOBODY),
    ("projector.py", "> TOLERANCE", "Gt to GtE", _NOBODY),
    ("projector.py", "if program.unit != 1.0", "1.0 to 2.0", "times one changes nothing"),
    ("scaled_program.py", ".reshape(-1, 2)", "1 to 2", "numpy takes any negative number"),
    ("scaled_program.py", "_FAST = 10.0", "", _UNIT),
    ("scaled_program.py", "_LARGE = 1e5", "", _UNIT),
    ("scaled_program.py", "self.worst <= _LARGE", "LtE to Lt", _UNIT),
    ("scaled_program.py", "_FAR = 1e5", "", "from so far away only the direction counts"),
    ("scaled_program.py", "bound.argmin()", "to argmax", _SOONER),
    ("scaled_program.py", "math.sqrt(2.0) * self.top_speed", "1.0 to 2.0", _SOONER),
    ("scaled_program.py", "math.sqrt(2.0) * self.top_speed", "2.0 to 3.0", _SOONER),
    ("scaled_program.py", "if not math.isfinite(self.top_speed)", "negated", _SOONER),
    ("scaled_program.py", "if self.worst <= _FAST", "LtE to Lt", _UNIT),
    ("law.py", "np.asarray(neighbour_count", "without argument dtype", _WHOLE),
    ("", 'TypeVar("_T")', "'_T' to another word", "nobody reads the name of a type variable"),
    ("measured_run.py", "PAIRS_AT_A_TIME = 200_000", "", "one pair more or less at a time"),
    ("alignment/", "if np.abs(steps - steps.mean())", "to median", _SHORT),
    ("alignment/", "if np.abs(steps - steps.mean())", "LtE to Lt", _SHORT),
    ("alignment_times.py", "nan=-2.0", "2.0 to 3.0", "either is below any γ"),
    ("confidence.py", "len(r.t) // 5000", "5000 to 5001", "about as many samples for a median"),
    ("confidence.py", "(length > least)", "Gt to GtE", _NOBODY),
    ("polarisation.py", "if length > 0", "Gt to GtE", "minus the logarithm of 0 is infinite"),
    ("wheels.py", "ties.beyond(excess, 0.0)", "to reached", "an excess of nothing either way"),
    ("arena.py", "< x_min", "Lt to LtE", _NOBODY),
    ("arena.py", "> x_max", "Gt to GtE", _NOBODY),
    ("arena.py", "< y_min", "Lt to LtE", _NOBODY),
    ("arena.py", "> y_max", "Gt to GtE", _NOBODY),
    ("arena.py", "<= reach", "LtE to Lt", _NOBODY),
    ("arena.py", "> WRAPPED_BEYOND", "Gt to GtE", _NOBODY),
    ("arena.py", "where[0] % 2", "2 to 3", "the row is 0 or 1"),
    ("violations.py", "distances.tolist(), strict=True", "", "the arena cuts all three alike"),
    ("judge.py", "robots = 0 if ideal.report is None", "0 to 1", "neither is too many"),
]
