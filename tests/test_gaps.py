"""Gaps are a robot's own: what is missing, held or a placeholder is left out, told and stated."""

import warnings

import numpy as np
import pytest
from rolling_robots import rolling
from typer.testing import CliRunner

from posflock_robotarium.alignment.disturbed import errors_of
from posflock_robotarium.alignment.verdicts import Mark
from posflock_robotarium.cli import app
from posflock_robotarium.logs.plausibility import Why, believed, sightings_of
from posflock_robotarium.report import ReadOptions, Run, analyse, read
from posflock_robotarium.report.outputs import write_report

ROWS, ROBOTS = 400, 5
T, SMOOTH = rolling(ROWS, ROBOTS)


def tracked(seed=0):
    """Robots that a tracker sees: half a millimetre of noise, and 1.5 mrad."""
    noise = np.random.default_rng(seed).standard_normal(SMOOTH.shape)
    return SMOOTH + noise * np.array([[5e-4], [5e-4], [1.5e-3]])


def run_of(poses, t=T):
    return Run("run", t, poses, parameters={"arena": [-9.0, 9.0, -9.0, 9.0]})


def left_out(run):
    return {(e.robot, e.why) for e in sightings_of(run, run.t).unbelieved}


def verdict(analysis, question):
    return next(v for v in analysis.verdicts if question in v.question)


def missing(poses):
    poses[100:200, :, 2] = np.nan


def zeros(poses):
    poses[100:200, :, 2] = 0.0


def zeros_at_the_start(poses):
    poses[:100, :, 2] = 0.0


def zeros_all_the_time(poses):
    poses[:, :, 2] = 0.0


def minus_one(poses):
    poses[100:200, :, 2] = -1.0


def markers_now_and_then(poses):
    poses[::10, :, 2] = -9999.0


def a_million(poses):
    poses[100:200, :, 2] = 1e6


def infinite(poses):
    poses[100:200, :, 2] = np.inf


def frozen(poses):
    poses[100:200, :, 2] = poses[99, :, 2]


def frozen_to_the_end(poses):
    poses[200:, :, 2] = poses[199, :, 2]


def another_robots(poses):
    poses[100:200, :, 2] = poses[100:200, :, 4]


def turned_round(poses):
    poses[100:200, 2, 2] += np.pi


@pytest.mark.parametrize(
    ("lose", "why"),
    [
        (missing, Why.MISSING),
        (zeros, Why.UNSEEN),
        (zeros_at_the_start, Why.UNSEEN),
        (zeros_all_the_time, Why.UNSEEN),
        (minus_one, Why.UNSEEN),
        (markers_now_and_then, Why.UNSEEN),
        (a_million, Why.MISSING),
        (infinite, Why.MISSING),
        (frozen, Why.UNSEEN),
        (frozen_to_the_end, Why.HELD),
        (another_robots, Why.ELSEWHERE),
        (turned_round, Why.ELSEWHERE),
    ],
)
def test_a_lost_robot_is_named_and_nobody_elses_loss(lose, why):
    poses = tracked()
    lose(poses)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        analysis = analyse(run_of(poses), radius=2.0)
    assert left_out(analysis.recording) == {(2, why)}
    assert analysis.believed.seen[:, [0, 1, 3, 4]].all()
    whole = analyse(run_of(tracked()), radius=2.0).numbers
    for key in ("smallest_wall_distance", "boundary_events", "collisions"):
        assert analysis.numbers[key].value == pytest.approx(whole[key].value, abs=0.3)
    sure = verdict(analysis, "sure")
    assert sure.mark is Mark.CAUTION
    assert "robot 2" in sure.because
    assert analysis.numbers["robots_seen"].value < ROBOTS
    assert (analysis.curves["robots_seen"] >= 4).all()


@pytest.mark.parametrize("noise", [True, False])
def test_robots_that_are_seen_all_the_time_lose_nothing(noise):
    poses = tracked() if noise else SMOOTH.copy()
    analysis = analyse(run_of(poses), radius=2.0)
    assert analysis.sightings.placed.all()
    assert not analysis.sightings.jumps.any()
    assert "robots_seen" not in analysis.numbers
    assert "robots_seen" not in analysis.curves


def test_simulated_robots_may_stand_and_go_on():
    """To the last bit, as they do without noise; and a robot parked for good is no placeholder."""
    poses = SMOOTH[np.concatenate([np.arange(100), np.full(100, 100), np.arange(101, 300)])].copy()
    poses[:, :, 4] = [0.7, -0.2, 0.3]
    run = Run("stands", T[: len(poses)], poses)
    assert sightings_of(run, run.t).placed.all()


def test_safety_is_not_claimed_for_what_nobody_saw():
    poses = tracked()
    missing(poses)
    safe = verdict(analyse(run_of(poses), radius=2.0), "safe")
    assert safe.mark is Mark.CAUTION
    assert "robot 2 is not for 3.3 s" in safe.because
    poses = tracked()
    poses[100:103, :, 2] = np.nan
    assert verdict(analyse(run_of(poses), radius=2.0), "safe").mark is Mark.GOOD


def test_a_flock_that_may_be_linked_by_who_is_not_seen_has_not_parted():
    t = np.arange(200) * 0.033
    poses = np.zeros((200, 3, 3))
    poses[:, 0] = 0.05 * t[:, np.newaxis]
    poses[:, 1] = [-0.5, 0.0, 0.5]
    poses[100:150, :, 1] = np.nan
    analysis = analyse(run_of(poses, t), radius=0.6)
    assert np.isnan(analysis.curves["components"][120])
    assert analysis.numbers["connected"].value == 1.0
    assert verdict(analysis, "together").mark is Mark.GOOD


def test_the_stated_error_holds_the_truth():
    names = ("10 % of the poses missing", "one robot never seen", "5 % of the poses -9999")
    for found in errors_of(("random",), names):
        assert found.holds, found
        assert found.stated < 0.1


@pytest.mark.slow
def test_the_stated_error_holds_the_truth_of_every_disturbance():
    from benchmarks import gaps_truth

    assert gaps_truth.main() == 0


def saved(tmp_path, poses, t=T):
    np.savez(tmp_path / "run.npz", t=t, poses=poses)
    return tmp_path / "run.npz"


def test_frames_that_were_written_again_are_dropped_and_told(tmp_path):
    poses = tracked()
    poses[1::2] = poses[::2]
    run = read(saved(tmp_path, poses))
    np.testing.assert_array_equal(run.poses, poses[::2])
    assert any("200 of 400 rows repeat an earlier frame: dropped" in note for note in run.notes)


def test_a_camera_that_stops_leaves_no_whole_run(tmp_path):
    poses = tracked()
    poses[200:] = poses[199]
    run = read(saved(tmp_path, poses))
    assert len(run.t) == 200
    assert "hold one frame of the camera" in run.doubts[0]


def test_rows_before_the_first_robot_are_cut_and_told(tmp_path):
    for empty in (0.0, np.nan):
        poses = tracked()
        poses[:50] = empty
        run = read(saved(tmp_path, poses))
        assert run.t[0] == T[50]
        assert any("begins at row 50" in note for note in run.notes)


def test_rows_out_of_order_are_sorted_but_two_runs_are_not_mixed(tmp_path):
    order = np.arange(ROWS)
    order[100:110] = order[100:110][::-1]
    run = read(saved(tmp_path, tracked()[order], T[order]))
    np.testing.assert_array_equal(run.t, T)
    assert any("sorted by their times" in note for note in run.notes)
    again = np.concatenate([T[:200], T[:200]])
    with pytest.raises(Exception, match="row 200: time runs backwards"):
        read(saved(tmp_path, tracked(), again))


def test_words_for_what_is_unknown_are_unknown_numbers(tmp_path):
    for word in ("NaN", "nan", "NA", "N/A", "null", "None", "", "-"):
        rows = [f"{t:.3f},{0.1 * t:.4f},0,0" for t in T[:30]]
        rows[10] = f"{T[10]:.3f},{word},{word},{word}"
        path = tmp_path / "run.csv"
        path.write_text("\n".join(["t,x,y,theta", *rows]) + "\n")
        assert np.argwhere(~read(path).seen).tolist() == [[10, 0]], word


def test_layouts_are_told_by_the_robots_that_are_seen(tmp_path):
    poses = tracked()
    missing(poses)
    poses[:50, :, 1] = -9999.0
    flat = poses.transpose(0, 2, 1).reshape(ROWS, -1)
    np.save(tmp_path / "run.npy", np.column_stack([T, flat]))
    run = read(tmp_path / "run.npy")
    np.testing.assert_array_equal(run.seen[:, 0], np.ones(ROWS))
    np.testing.assert_array_equal(run.poses, np.where(np.isfinite(poses), poses, np.nan))


@pytest.mark.parametrize("ending", ["npz", "mat", "csv", "npy", "mcap"])
def test_what_is_not_seen_stays_so_in_every_format(tmp_path, ending):
    poses = tracked()[:30]
    poses[5:9, :, 2] = np.nan
    source = saved(tmp_path, poses, T[:30])
    target = tmp_path / f"again.{ending}"
    done = CliRunner().invoke(
        app, ["convert", str(source), "--to", ending, "--out", str(target)], catch_exceptions=False
    )
    assert done.exit_code == 0, done.output
    np.testing.assert_array_equal(read(target).seen, np.isfinite(poses[:, 0]))


def test_a_page_and_figures_of_robots_that_are_not_seen(tmp_path):
    poses = tracked()
    missing(poses)
    poses[250:300, :, 1] = 0.0
    written = write_report([analyse(run_of(poses), radius=2.0)], tmp_path / "report")
    page = written[0].read_text("utf-8")
    assert "Poses that are left out" in page
    assert "not tracked" in page
    assert any(path.name == "sightings.pdf" for path in written)


def test_a_robot_that_nobody_saw_at_all_is_told():
    poses = tracked()
    poses[:, :, 2] = np.nan
    analysis = analyse(run_of(poses), radius=2.0)
    assert "robot 2 never" in verdict(analysis, "sure").because
    assert believed(analysis.recording).seen[:, 2].sum() == 0
    with pytest.raises(Exception, match="only 0% of its poses are known"):
        run_of(np.full_like(poses, np.nan))


def test_arena_and_collision_diameter_are_the_users(tmp_path):
    poses = tracked()
    path = saved(tmp_path, poses)
    words = ["report", str(path), "--radius", "2", "--no-figures", "-o", str(tmp_path / "out")]
    done = CliRunner().invoke(app, [*words, "--arena=-9,9,-9,9", "--collision-diameter", "0.01"])
    assert "Yes: no collision, nobody outside." in done.output, done.output
    done = CliRunner().invoke(app, [*words, "--arena=-0.5,0.5,-0.5,0.5"])
    assert "boundary crossing" in done.output
    for arena in ("1,2,3", "1,0,0,1", "a,b,c,d"):
        done = CliRunner().invoke(app, [*words, f"--arena={arena}"])
        assert "left,right,bottom,top in metres" in str(done.exception)
    assert read(path, ReadOptions()).robot.collision_diameter > 0.1
