"""What every benchmark measures and prints with: CPU time in turns, and bars that judge ratios.

A second is not the same on two processors, nor on one that others use as well. So what is judged is
the ratio of two candidates that did their work in turns in one run, in CPU time, the median over
rounds; seconds are printed beside it and judge nothing. Import this before numpy: it asks for one
BLAS thread, since small matrices only lose time to more.
"""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median

for _variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")


def cpu(run: Callable[[], object]) -> float:
    """Return the CPU seconds of a call, in this process."""
    before = time.process_time()
    run()
    return time.process_time() - before


def cpu_with_children(run: Callable[[], object]) -> float:
    """Return the CPU seconds of a call, with those of the processes that it waits for."""

    def used() -> float:
        both = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        return sum(usage.ru_utime + usage.ru_stime for usage in both)

    before = used()
    run()
    return used() - before


class Times:
    """CPU seconds of candidates that took turns.

    Parameters
    ----------
    candidates : mapping
        By name, what does the work and returns the seconds it took, mostly by `cpu`.
    rounds : int
        How often each has its turn.
    """

    def __init__(self, candidates: Mapping[str, Callable[[], float]], rounds: int = 5) -> None:
        self.seconds: dict[str, list[float]] = {name: [] for name in candidates}
        names = list(candidates)
        for turn in range(rounds):  # another one first each time: it finds the caches cold
            for name in names[turn % len(names) :] + names[: turn % len(names)]:
                self.seconds[name].append(candidates[name]())

    def median(self, name: str) -> float:
        """Return the median seconds of a candidate."""
        return median(self.seconds[name])

    def ratio(self, name: str, reference: str) -> float:
        """Return how many times as long one takes as another, the median over rounds."""
        pairs = zip(self.seconds[name], self.seconds[reference], strict=True)
        return median(one / other for one, other in pairs)


@dataclass(frozen=True)
class Bar:
    """One requirement, and what was measured; `sense` is ≥ or ≤.

    A number over seeds comes with its `interval`, which is judged in its place: the requirement is
    met by the whole of it, or missed by the whole of it, or else not settled.
    """

    what: str
    measured: float
    sense: str
    required: float
    unit: str = ""
    interval: tuple[float, float] | None = None

    @property
    def holds(self) -> bool:
        """Whether it is met."""
        return all(self._met(end) for end in self._ends)

    @property
    def missed(self) -> bool:
        """Whether it is not met, and that is settled."""
        return not any(self._met(end) for end in self._ends)

    @property
    def verdict(self) -> str:
        """In a word or two."""
        return "ok" if self.holds else "MISSED" if self.missed else "not settled"

    @property
    def _ends(self) -> tuple[float, ...]:
        return (self.measured,) if self.interval is None else self.interval

    def _met(self, value: float) -> bool:
        return bool(value >= self.required if self.sense == "≥" else value <= self.required)


class Table:
    """Measured against required, a line each; and what judges nothing."""

    def __init__(self, width: int = 60) -> None:
        self.bars: list[Bar] = []
        self._width = width
        self._part = ""

    @property
    def missed(self) -> int:
        """How many requirements were missed."""
        return sum(bar.missed for bar in self.bars)

    def part(self, title: str) -> None:
        """Print a heading; what follows belongs to it, and may be called as in another part."""
        self._part = f"{title}: "
        print(title, flush=True)

    def bar(
        self,
        what: str,
        measured: float,
        sense: str,
        required: float,
        unit: str = "",
        *,
        beside: str = "",
        interval: tuple[float, float] | None = None,
    ) -> None:
        """Print one requirement; `sense` is ≥ or ≤, and `beside` is said without judging."""
        bar = Bar(self._part + what, float(measured), sense, float(required), unit, interval)
        self.bars.append(bar)
        if interval is not None:
            ends = f"95 % interval {interval[0]:.4g} to {interval[1]:.4g}"
            beside = f"{ends}; {beside}" if beside else ends
        verdict = bar.verdict + (f"   ({beside})" if beside else "")
        figures = f"{measured:>9.4g} {unit:<6} {sense} {required:<7g}"
        print(f"  {what:<{self._width}}{figures}{verdict}", flush=True)

    def ratio(
        self, what: str, times: Times, name: str, reference: str, most: float, per: int = 1
    ) -> None:
        """Print how one candidate compares with its reference, and its time for each of `per`."""
        beside = (
            f"{seconds(times.median(name) / per)} against {seconds(times.median(reference) / per)}"
        )
        self.bar(what, times.ratio(name, reference), "≤", most, "×", beside=beside)

    def exit_code(self) -> int:
        """Say how many requirements were missed; 1 if any was."""
        unsettled = sum(not bar.holds and not bar.missed for bar in self.bars)
        if self.missed or unsettled:
            print(f"{self.missed} missed" + (f", {unsettled} not settled" if unsettled else ""))
        else:
            print("every requirement holds")
        return int(self.missed > 0)


def seconds(value: float) -> str:
    """Return a time in the unit in which it reads best."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"
