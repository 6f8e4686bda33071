"""Every number of a report's summary, derived a second time from the curves and by hand."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from posflock_robotarium.alignment.estimators import (
    estimate,
    expected_bias,
    tracking_noise,
)
from posflock_robotarium.report import AnalysisOptions, Run, analyse

#: What is said of each number, in the order of the summary table.
AGREED = json.loads((Path(__file__).parent / "golden" / "metric_catalogue.json").read_text("utf-8"))
NUMBERS = AGREED["numbers"]
#: What only logs with a real time, with what was printed beside them, or with unseen robots tell.
OF_SOME_LOGS = {
    "robots_seen", "longest_unseen", "gamma_unseen",
    "real_duration", "step_mean", "step_median", "step_longest", "step_longest_at",
    "steps_irregular", "steps_over_watchdog", "time_braked", "drive_time", "drive_in_log",
}  # fmt: skip


def eventful(uneven=True):
    """Return a run of 27 s in which everything happens that a number counts."""
    rng = np.random.default_rng(7)
    steps = rng.uniform(0.025, 0.045, 760) if uneven else np.full(760, 0.033)
    steps[[650, 700]] += np.array([1.0, 2.0]) * uneven  # gaps, late in the run
    t = np.concatenate([[0.5], 0.5 + np.cumsum(steps)])
    rows = len(t)
    since = t - t[0]
    heading = 0.1 + 0.3 * np.sin(0.4 * since)[:, None] + np.array([0.0, 0.05, -0.05, 0.1])
    heading[since < 3.0, 0] += 2.5  # robot 0 begins the wrong way
    speed = np.full((rows, 4), 0.08)
    speed[since > 21.0, 3] = 0.0  # robot 3 stops
    speed[since > since[-1] - 1.0, 2] = 0.0  # robot 2 soon before the end
    speed[(since > 15.0) & (since < 15.6), 1] = 0.0  # and robot 1, for too short a time to stall
    speed[(since > 16.0) & (since < 18.5), 1] = 0.0
    poses = np.zeros((rows, 3, 4))
    moved = np.diff(t, prepend=t[0])[:, None] * speed
    poses[:, 0] = np.cumsum(moved * np.cos(heading), axis=0) + np.array([-1.2, -1.14, -0.7, -0.9])
    poses[:, 1] = np.cumsum(moved * np.sin(heading), axis=0) + np.array([0.0, 0.07, 0.3, -0.4])
    poses[:, 2] = heading
    poses[:, :2] += rng.normal(0.0, 2e-4, (rows, 2, 4))
    commands = np.zeros((rows, 2, 4))
    commands[:, 0] = 0.08
    commands[since > 24.0, 0, 3] = 0.0
    commands[100:130, 0, 2] = 0.3
    commands[200:210, 1, 2] = -5.0
    intervention = np.where(rng.random(rows) < 0.3, rng.uniform(0.002, 0.02, rows), 0.0005)
    intervention[:20] = math.nan
    clearance = rng.uniform(0.01, 0.2, rows)
    clearance[5], clearance[300] = math.nan, -0.03
    status = np.full(rows, "trivial", dtype="<U8")
    status[40:45], status[50], status[60:62] = "relaxed", "failed", "optimal"
    parameters = {"neighbour_radius": 0.55}
    return Run("eventful", t, poses, commands, intervention, clearance, status, parameters)


@pytest.fixture(scope="module", params=[True, False], ids=["uneven", "even"])
def analysis(request):
    return analyse(eventful(request.param))


#: What is only told where somebody asks for it.
ASKED_FOR = {"Formation", "Coverage"}


class Again:
    """Means over time, weighted by how long each sample stands."""

    def __init__(self, analysis):
        self.run, self.curves = analysis.recording, analysis.curves
        t = self.run.t
        step = np.median(np.diff(t))
        lasts = np.append(np.diff(t), step)
        self.lasts = np.where(lasts > 3.0 * step, step, lasts)
        self.settled = t - t[0] > 20.0

    def mean(self, values, which=None):
        which = np.isfinite(values) & (self.settled if which is None else which)
        return float((values * self.lasts)[which].sum() / self.lasts[which].sum())

    @property
    def speeds(self):
        smooth = estimate(self.run, "savitzky_golay").velocities
        return np.hypot(smooth[:, 0], smooth[:, 1])


def value(analysis, key):
    return analysis.numbers[key].value


def test_the_table_is_complete_in_order_with_groups_and_units(analysis):
    expected = [
        (agreed["group"], key, agreed["unit"])
        for key, agreed in NUMBERS.items()
        if key in analysis.numbers or (key not in OF_SOME_LOGS and agreed["group"] not in ASKED_FOR)
    ]
    assert [(n.group, key, n.unit) for key, n in analysis.numbers.items()] == expected
    for number in analysis.numbers.values():
        assert number.label
        assert number.definition.endswith(".")
        assert "_" not in number.label  # words for people


def test_the_run(analysis):
    t = analysis.recording.t
    step = np.median(np.diff(t))
    assert value(analysis, "robots") == 4
    assert value(analysis, "samples") == 761
    assert value(analysis, "duration") == t[-1] - t[0]
    assert value(analysis, "step") == step
    gaps = np.diff(t)[np.diff(t) > 0.5]
    assert value(analysis, "gaps") == len(gaps)
    assert value(analysis, "gap_time") == pytest.approx(gaps.sum())


def test_means_are_over_the_time_that_each_sample_stands_for(analysis):
    again, curves = Again(analysis), analysis.curves
    for key in (
        "gamma_motion", "gamma_headings", "gamma_differences", "left_out_motion",
        "left_out_headings", "left_out_differences", "polarisation_motion",
        "polarisation_headings", "speed", "drift", "cohesive_radius", "spread",
        "nearest_neighbour",
    ):  # fmt: skip
        assert value(analysis, key) == pytest.approx(again.mean(curves[key]), abs=1e-12), key
    assert 0.0 < value(analysis, "left_out_motion") < 1.0


@pytest.mark.parametrize("short", ["motion", "headings"])
def test_alignment_begins_lasts_and_is_a_share_of_the_time(analysis, short):
    again, gamma = Again(analysis), analysis.curves[f"gamma_{short}"]
    t, aligned = analysis.recording.t, gamma >= 0.9
    everything = np.ones(len(t), dtype=bool)
    assert not aligned[0]
    assert 0 < aligned.sum() < len(t)
    assert value(analysis, f"time_to_alignment_{short}") == t[np.argmax(aligned)] - t[0]
    last = np.flatnonzero(~aligned)[-1]
    for_good = math.nan if last == len(t) - 1 else t[last + 1] - t[0]
    found = value(analysis, f"time_aligned_for_good_{short}")
    assert found == pytest.approx(for_good, nan_ok=True)
    share, steady = again.mean(aligned * 1.0, everything), again.mean(aligned * 1.0)
    assert value(analysis, f"share_aligned_{short}") == pytest.approx(share, abs=1e-12)
    assert value(analysis, f"steadiness_{short}") == pytest.approx(steady, abs=1e-12)


def test_alignment_that_ends_or_never_comes_has_no_time():
    run = eventful()
    never = analyse(run, AnalysisOptions(threshold=1.0)).numbers
    for key in ("time_to_alignment_motion", "time_aligned_for_good_motion"):
        assert math.isnan(never[key].value)
    assert never["share_aligned_motion"].value == 0.0
    always = analyse(run, AnalysisOptions(threshold=-1.0)).numbers
    assert always["time_to_alignment_headings"].value == 0.0
    assert always["time_aligned_for_good_headings"].value == 0.0
    assert always["share_aligned_headings"].value == 1.0
    poses = run.poses.copy()
    poses[-1, 2, :2] += np.pi  # two turn round at the very end
    ended = analyse(replace(run, poses=poses)).numbers
    assert math.isnan(ended["time_aligned_for_good_headings"].value)
    assert math.isfinite(ended["time_to_alignment_headings"].value)


def test_the_spread_of_headings_is_the_circular_deviation(analysis):
    again = Again(analysis)
    heading = analysis.curves["heading"][again.settled]
    length = np.hypot(np.cos(heading).mean(), np.sin(heading).mean())
    assert value(analysis, "heading_spread") == pytest.approx(math.sqrt(-2 * math.log(length)))


def test_who_stands_and_for_how_long(analysis):
    again = Again(analysis)
    stands = again.speeds <= 0.01
    standing = stands.mean(axis=1)
    t = analysis.recording.t
    assert value(analysis, "standing") == pytest.approx(again.mean(standing), abs=1e-12)
    assert value(analysis, "robots_standing") == 1  # robot 3; robot 1 stood less than half the time
    final = t >= t[-1] - 0.1 * (t[-1] - t[0]) - 1e-9
    assert value(analysis, "standing_end") == pytest.approx(again.mean(standing, final), abs=1e-12)
    assert 0.25 < value(analysis, "standing_end") < 0.5


def test_speeds_are_those_of_robots_and_of_their_centroid(analysis):
    curves, speeds = analysis.curves, Again(analysis).speeds
    for key, expected in (
        ("speed", speeds.mean(axis=1)),
        ("speed_slowest", speeds.min(axis=1)),
        ("speed_fastest", speeds.max(axis=1)),
    ):
        np.testing.assert_allclose(curves[key], expected, rtol=1e-12, err_msg=key)
    centre = estimate(analysis.recording, "savitzky_golay").velocities.mean(axis=2)
    np.testing.assert_allclose(curves["drift"], np.hypot(*centre.T), rtol=1e-12)


def test_the_centroid_goes_from_its_first_place_to_its_last(analysis):
    centre = analysis.recording.poses[:, :2].mean(axis=2)
    way = math.dist(centre[0], centre[-1])
    assert value(analysis, "centroid_displacement") == pytest.approx(way)


def test_stalls_are_long_stands_against_a_command(analysis):
    run, again = analysis.recording, Again(analysis)
    stuck = (again.speeds <= 0.01) & (np.abs(run.commands[:, 0]) >= 0.02)
    stretches = []
    for robot in range(4):
        rows = np.flatnonzero(stuck[:, robot])
        for part in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1):
            if part.size and run.t[part[-1]] - run.t[part[0]] > 1.0:
                stretches.append(run.t[part[-1]] - run.t[part[0]])
    assert len(stretches) == 2  # robot 1 once, robot 3 until it was told to stop
    assert value(analysis, "stalls") == 2
    assert value(analysis, "stall_time") == pytest.approx(sum(stretches))


def test_wheels_are_held_against_the_robots_own_limit(analysis):
    wheels = analysis.curves["fastest_wheel"]
    assert value(analysis, "fastest_wheel") == wheels.max()
    assert value(analysis, "wheel_excess") == pytest.approx(wheels.max() - 12.5)
    assert value(analysis, "wheel_excess_steps") == int((wheels > 12.5).sum()) == 40


def test_commands_within_the_limit_have_no_excess():
    run = eventful()
    slow = analyse(replace(run, commands=0.2 * run.commands)).numbers
    assert slow["wheel_excess"].value == 0.0
    assert slow["wheel_excess_steps"].value == 0
    assert "fastest_wheel" not in analyse(replace(run, commands=None)).numbers
    commands = 0.0 * run.commands
    commands[:, 0] = 0.2  # 12.5 rad/s exactly
    commands[5:8, 0, 1] = 0.208
    little = analyse(replace(run, commands=commands)).numbers
    assert little["wheel_excess"].value == pytest.approx(0.5)
    assert little["wheel_excess_steps"].value == 3


def test_cohesion(analysis):
    again, curves = Again(analysis), analysis.curves
    radius, everything = curves["cohesive_radius"][again.settled], np.ones(761, dtype=bool)
    ratio = radius.max() / radius.min()
    assert value(analysis, "cohesive_radius_ratio") == pytest.approx(ratio)
    assert value(analysis, "components") == curves["components"].max() > 1
    together = again.mean((curves["components"] == 1) * 1.0, everything)
    assert value(analysis, "connected") == pytest.approx(together, abs=1e-12)
    assert 0.0 < together < 1.0
    least = curves["algebraic_connectivity"].min()
    assert value(analysis, "algebraic_connectivity") == least


def test_safety(analysis):
    x, y, theta = np.moveaxis(analysis.recording.poses, 1, 0)
    first, second = np.triu_indices(4, 1)

    def gaps(ahead):
        points = x + ahead * np.cos(theta) + 1j * (y + ahead * np.sin(theta))
        return np.abs(points[:, first] - points[:, second])

    close = gaps(0.025) < 0.135
    walls = np.minimum.reduce([x + 1.6, 1.6 - x, y + 1.0, 1.0 - y])
    assert value(analysis, "smallest_distance") == pytest.approx(gaps(0.0).min())
    assert value(analysis, "smallest_collision_distance") == pytest.approx(gaps(0.025).min())
    assert value(analysis, "collision_steps") == close.sum() > 0
    begun = close & ~np.vstack([np.zeros((1, 6), dtype=bool), close[:-1]])
    assert value(analysis, "collisions") == begun.sum()
    assert value(analysis, "smallest_wall_distance") == pytest.approx(walls.min())
    assert value(analysis, "boundary_events") == value(analysis, "boundary_steps") == 0
    moved = analysis.recording.poses.copy()
    moved[:, 0] -= 0.45
    outside = analyse(replace(analysis.recording, poses=moved)).numbers
    beyond = x - 0.45 < -1.6
    assert outside["boundary_steps"].value == beyond.any(axis=1).sum() > 0
    begun = beyond & ~np.vstack([np.zeros((1, 4), dtype=bool), beyond[:-1]])
    assert outside["boundary_events"].value == begun.sum()


def test_what_the_certificate_did(analysis):
    run = analysis.recording
    known = run.intervention[20:]
    moved = known > 1e-3
    assert value(analysis, "interventions") == pytest.approx(moved.mean())
    assert value(analysis, "intervention_mean") == pytest.approx(known[moved].mean())
    assert value(analysis, "intervention_largest") == known.max()
    assert value(analysis, "clearance") == -0.03
    assert value(analysis, "clearance_first") == run.clearance[0]
    assert value(analysis, "unsolved") == 6


def test_what_the_certificate_did_not_say_is_in_no_table():
    run = eventful()
    idle = np.full(761, 0.0005)
    untouched = analyse(replace(run, intervention=idle)).numbers
    assert untouched["interventions"].value == untouched["intervention_mean"].value == 0.0
    assert untouched["intervention_largest"].value == 0.0005
    barely = analyse(replace(run, intervention=2 * idle)).numbers
    assert barely["interventions"].value == barely["intervention_mean"].value == 0.0
    late = run.clearance.copy()
    late[0] = math.nan
    assert "clearance_first" not in analyse(replace(run, clearance=late)).numbers
    unknown = analyse(replace(run, intervention=None, clearance=None, status=None)).numbers
    assert {number.group for number in unknown.values()} == {
        agreed["group"] for agreed in NUMBERS.values()
    } - {"Certificate"} - ASKED_FOR


def test_how_far_the_estimates_can_be_trusted(analysis):
    run, again = analysis.recording, Again(analysis)
    moving = again.speeds[again.settled]
    speed = float(np.median(moving[np.isfinite(moving) & (moving > 0.01)]))
    noise = tracking_noise(run, speed)
    assert value(analysis, "noise_position") == noise.position
    assert value(analysis, "noise_heading") == noise.heading
    assert value(analysis, "noise_course") == pytest.approx(noise.course)
    assert value(analysis, "gamma_bias") == pytest.approx(expected_bias(noise.course))


def test_the_offset_of_headings_is_taken_over_ten_samples(analysis):
    t, poses = analysis.recording.t, analysis.recording.poses
    first, last, step = np.arange(len(t) - 10), np.arange(10, len(t)), np.median(np.diff(t))
    x, y = np.moveaxis(poses[last, :2] - poses[first, :2], 1, 0)
    moved = (np.hypot(x, y) > 0.005) & (t[last] - t[first] < 30 * step)[:, None]
    off = (poses[first + 5, 2] - np.arctan2(y, x) + np.pi / 2) % np.pi - np.pi / 2  # of a line
    assert value(analysis, "heading_offset") == pytest.approx(np.median(np.abs(off[moved])))
