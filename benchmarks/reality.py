"""How true predictions are: public runs of the real testbed, each simulated under each profile.

    python benchmarks/reality.py FOLDER

FOLDER holds fetched repositories with scripts and the logs of their real runs (see `real_runs`),
such as https://github.com/kevinkawchak/robotarium-nurse-patient-study; without an argument the
variable POSFLOCK_REAL_RUNS names it, and where there is none, nothing is done and that is said.
Prints when each event happened and when it was predicted, counts, collisions, the drive to the
start, and the score of each profile: the mean error of event times on runs that the profile was
fitted to and on others, stops foreseen, false alarms, and the Brier score of their probabilities.
A run is predicted to be stopped in the trials in which robots collide or leave the arena.

An event's predicted time is the median over the seeds in which it happened; what happens at the
same time in the real run and in the ideal one is the script's timetable, and left out.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from statistics import mean, median

import comparing  # noqa: F401  one BLAS thread, asked for before numpy is there
from real_runs import ROUNDING, End, Event, RealRun, counts_of, events_of, real_runs

from posflock_robotarium.verify import judge, static
from posflock_robotarium.verify.findings import verdict_of
from posflock_robotarium.verify.fork_server import PRINTED
from posflock_robotarium.verify.initial_drive_time import PUBLISHED, DriveTime, predicted_drive
from posflock_robotarium.verify.trials import ForkServer, Limits, Ran, TrialRoom
from rps_compat.profiles import load_profile
from rps_compat.running.plan import RunPlan
from rps_compat.violations import FaultKind

#: The runs that ``gternal`` was fitted to.
FITTED = ("Run08", "Run10")
VARIABLE = "POSFLOCK_REAL_RUNS"


@dataclass
class Prediction:
    """What one profile says of a run.

    Attributes
    ----------
    events : list of dict
        When each event happened, a dict a seed.
    counts : list of dict
        What was counted when, a dict a seed.
    collisions, outside : list of float
        When the first two robots collided, and the first left the arena, s, a number a seed;
        infinite where none did.
    verdict : str
        What verify makes of these trials.
    """

    events: list[dict[Event, float]] = field(default_factory=list)
    counts: list[dict[tuple[float, str], str]] = field(default_factory=list)
    collisions: list[float] = field(default_factory=list)
    outside: list[float] = field(default_factory=list)
    verdict: str = ""

    def time_of(self, event: Event) -> float | None:
        """Return when an event is predicted, s; None where in half of the seeds it never is."""
        times = [seed[event] for seed in self.events if event in seed]
        return median(times) if 2 * len(times) > len(self.events) else None

    def stopped_before(self, time: float) -> float:
        """Return the share of the seeds in which the testbed would end the run before `time`, s."""
        ends = [min(pair) for pair in zip(self.collisions, self.outside, strict=True)]
        return mean(end < time for end in ends)


def predict(run: RealRun, profiles: Sequence[str], seeds: int, server: ForkServer) -> _Table:
    """Simulate a run under each profile, and once in the ideal arena."""
    known, source = static.check_source(run.script)
    assert source is not None
    with TrialRoom(source, 2, Limits(), server) as room:
        plans = {"ideal": [room.plan("ideal")]}
        for number, name in enumerate(profiles):  # a file's name would be no name of a folder
            plans[name] = [
                room.plan(f"{number}-{k}", load_profile(name), initial="arrive", seed=k)
                for k in range(seeds)
            ]
        ran = iter(room.run([plan for own in plans.values() for plan in own]))
        found = {name: [next(ran) for _ in own] for name, own in plans.items()}
        table = {name: _prediction(own, found[name]) for name, own in plans.items()}
    (ideal,) = found["ideal"]
    for name in profiles:
        runs = judge.Runs(ideal, tuple(found[name]))
        table[name].verdict = verdict_of([*known, *judge.judge(runs, known)]).name
    return table


_Table = dict[str, Prediction]


def _prediction(plans: list[RunPlan], ran: list[Ran]) -> Prediction:
    out = Prediction()
    for plan, one in zip(plans, ran, strict=True):
        text = (Path(plan.folder).parent / PRINTED).read_text(errors="replace")
        out.events.append(events_of(text))
        out.counts.append(counts_of(text))
        out.collisions.append(_first(one, FaultKind.COLLISION))
        out.outside.append(_first(one, FaultKind.BOUNDARY))
    return out


def _first(one: Ran, kind: FaultKind) -> float:
    return min((fault.start for fault in one.outcome.faults(kind)), default=inf)


def free_events(run: RealRun, table: _Table) -> dict[Event, float]:
    """Return the real times of events that hang on the robots, not on the script's timetable."""
    ideal = table["ideal"].events[0]
    return {
        event: time
        for event, time in run.events.items()
        if abs(ideal.get(event, -1.0) - time) > ROUNDING
    }


def tell(run: RealRun, table: _Table) -> None:
    """Print what happened in a run beside what each profile predicts."""
    drive = run.initial_drive
    print(f"\n{run.name}: {run.robots} robots, {run.end.value}, last told of at {run.last:.1f} s")
    if drive is not None:
        print(f"  drive to the start {drive:.1f} s, predicted from the others {drive_of(run)}")
    print(f"  {'':<44}{'real':>8}" + "".join(f"{name:>14}" for name in table))
    for event, time in free_events(run, table).items():
        cells = [_cell(prediction.time_of(event), time) for prediction in table.values()]
        print(f"  {f'{event[0][:38]} ({event[1]})':<44}{time:>8.1f}" + "".join(cells))
    real = counts_of(run.text)
    for at, name in [key for key in real if key[0] == run.last]:
        cells = [_most_common(prediction, (at, name)) for prediction in table.values()]
        print(
            f"  {f'{name} at {at:.0f} s':<44}{real[at, name]:>8}"
            + "".join(f"{c:>14}" for c in cells)
        )
    real = "stopped" if run.end is End.COLLISION else "no"
    for what, name in (("collisions", "collisions"), ("left the arena", "outside")):
        print(f"  {what:<44}{real:>8}" + "".join(_hits(getattr(p, name)) for p in table.values()))
    print(f"  {'verdict':<52}" + "".join(f"{p.verdict:>14}" for p in table.values()), flush=True)


def drive_of(run: RealRun) -> DriveTime:
    """Return the drive to the start that is predicted without what is known of this run's own."""
    own = (run.robots, round(run.initial_drive or 0.0, 1))
    return predicted_drive(run.robots, published=[drive for drive in PUBLISHED if drive != own])


def _hits(times: list[float]) -> str:
    hit = [time for time in times if time < inf]
    return f"{f'{len(hit)} of {len(times)}' + (f', {min(hit):.0f} s' if hit else ''):>14}"


def _cell(predicted: float | None, real: float) -> str:
    if predicted is None:
        return f"{'never':>14}"
    return f"{f'{predicted:.1f} {100 * (real / predicted - 1):+.0f}%':>14}"


def _most_common(prediction: Prediction, key: tuple[float, str]) -> str:
    values = [seed[key] for seed in prediction.counts if key in seed]
    return max(set(values), key=values.count) if values else "–"


def errors(run: RealRun, table: _Table, profile: str) -> tuple[list[float], int]:
    """Return the errors of predicted times, real against predicted, and how many never happen."""
    out, never = [], 0
    for event, real in free_events(run, table).items():
        predicted = table[profile].time_of(event)
        if predicted is None:
            never += 1
        else:
            out.append(abs(real / predicted - 1))
    return out, never


def score(profile: str, results: Sequence[tuple[RealRun, _Table]]) -> None:
    """Print how true a profile is over all runs."""
    fitted, other, never = [], [], 0
    foreseen, alarms, squares = [], [], []
    for run, table in results:
        found, missing = errors(run, table, profile)
        (fitted if run.name in FITTED else other).extend(found)
        never += missing
        until = run.last if run.end is End.INTERRUPTED else inf
        chance = table[profile].stopped_before(until)
        (foreseen if run.end is End.COLLISION else alarms).append(chance > 0)
        squares.append((chance - (run.end is End.COLLISION)) ** 2)
    print(
        f"  {profile:<12}{_percent(fitted):>16}{_percent(other):>16}{never:>8}"
        f"{f'{sum(foreseen)} of {len(foreseen)}':>14}{f'{sum(alarms)} of {len(alarms)}':>14}"
        f"{mean(squares):>8.2f}"
    )


def _percent(found: list[float]) -> str:
    return f"{100 * mean(found):.1f} % of {len(found)}" if found else "none"


def main() -> int:
    """Simulate, compare, print; 0 also where there are no runs to compare with."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=os.environ.get(VARIABLE))
    parser.add_argument("--profiles", nargs="+", default=["gritsbot_x", "gternal"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", default="", help="runs whose names hold this")
    options = parser.parse_args()
    runs = [] if options.folder is None else list(real_runs(Path(options.folder)))
    runs = [run for run in runs if options.only in run.name]
    if not runs:
        print(
            "skipped: no real runs at hand. Fetch repositories that hold scripts with their logs,"
            f" and name their folder as an argument or in {VARIABLE}."
        )
        return 0
    results = []
    with ForkServer() as server:
        for run in runs:
            results.append((run, predict(run, options.profiles, options.seeds, server)))
            tell(*results[-1])
    print(f"\n  {'':<12}{'events, fitted':>16}{'others':>16}{'never':>8}", end="")
    print(f"{'foreseen':>14}{'false alarms':>14}{'Brier':>8}")
    for profile in ("ideal", *options.profiles):
        score(profile, results)
    drives = [(run.initial_drive, drive_of(run)) for run in runs if run.initial_drive is not None]
    inside = sum(predicted.least <= real <= predicted.most for real, predicted in drives)
    print(f"  drives to the start within their intervals: {inside} of {len(drives)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
