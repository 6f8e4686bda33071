"""Logs that fit a wrong reading: read rightly, or refused with what it is and what to do."""

import numpy as np
import pytest
from rolling_robots import POSES, STEP, T, write

from posflock_robotarium.flocking.errors import PosflockError
from posflock_robotarium.report import LayoutError, ReadOptions, read

ROBOTS = range(POSES.shape[2])
X, Y, THETA = (POSES[:, axis] for axis in range(3))
NAMES = [f"{state}{robot}" for robot in ROBOTS for state in ("x", "y", "theta")]
COS, SIN = np.cos(THETA), np.sin(THETA)


def table(columns, names=(), cell="{!r}".format, between=","):
    """Text of a table: columns of T numbers, or arrays (T, N) of which a robot's come together."""
    wide = np.stack([np.atleast_2d(c.T).T for c in columns[1:]], axis=2).reshape(len(T), -1)
    rows = [[cell(float(number)) for number in row] for row in np.column_stack([columns[0], wide])]
    return "\n".join(between.join(row) for row in ([names] if names else []) + rows) + "\n"


PLAIN = table([T, X, Y, THETA], ["t", *NAMES])


def numbered(*states):
    return ["t", *(state.format(robot) for robot in ROBOTS for state in states)]


@pytest.mark.parametrize(
    "content",
    [
        table([T, X, Y, COS, SIN], numbered("x{}", "y{}", "cos{}", "sin{}")),
        table([T, X, Y, COS, SIN], numbered("x_{}", "y_{}", "cos_theta_{}", "sin_theta_{}")),
        table([T, X, Y, SIN, COS], numbered("x{}", "y{}", "sin(yaw{})", "cos(yaw{})")),
        table(
            [T, X, Y, np.sin(THETA / 2), np.cos(THETA / 2)], numbered("x{}", "y{}", "qz{}", "qw{}")
        ),
    ],
)
def test_headings_from_the_parts_of_rotations(tmp_path, content):
    run = read(write(tmp_path / "run.csv", content.encode()))
    np.testing.assert_allclose(run.poses[:, :2], POSES[:, :2])
    np.testing.assert_allclose(np.exp(1j * run.poses[:, 2]), np.exp(1j * THETA), atol=1e-12)
    assert any("headings from" in note for note in run.notes)


def fortran(number):
    return f"{number:.17E}".replace("E", "D")


def comma(number):
    return repr(number).replace(".", ",")


@pytest.mark.parametrize(
    ("content", "note"),
    [
        (table([T, X, Y, THETA], ["t", *NAMES], fortran).encode(), ""),
        (table([T, X, Y, THETA], (), comma, " ").encode(), "decimal points"),
        (table([T, X, Y, THETA], ["t", *NAMES], lambda n: f'"{comma(n)}"').encode(), "decimal"),
        (PLAIN.encode("utf-32"), "UTF-32"),
        (PLAIN.encode("utf-16-be"), "without its mark"),
        ((PLAIN + "\0" * 300).encode(), "zero bytes"),
        ((PLAIN + "\0" * 300 + PLAIN.splitlines()[-1] + "\n").encode(), "zero bytes"),
    ],
)
def test_numbers_and_letters_of_other_programs(tmp_path, content, note):
    run = read(write(tmp_path / "run.csv", content))
    np.testing.assert_array_equal(run.poses, POSES)
    assert any(note in said for said in run.notes)
    assert not any("no end" in said for said in run.notes)


@pytest.mark.parametrize("clock", ["14:03:{:09.6f}", "11.06.2026 02:03:{:09.6f} PM"])
@pytest.mark.parametrize("names", [(), ["Zeit", *NAMES]])
def test_times_of_day_without_a_header_too(tmp_path, clock, names):
    rows = table([T, X, Y, THETA]).splitlines()
    rows = [
        ",".join([clock.format(t), *row.split(",")[1:]]) for t, row in zip(T, rows, strict=True)
    ]
    content = "\n".join([",".join(names)] * bool(names) + rows) + "\n"
    run = read(write(tmp_path / "run.csv", content.encode()))
    np.testing.assert_allclose(run.t - run.t[0], T, atol=1e-6)
    np.testing.assert_array_equal(run.poses, POSES)


DEGREES, COMPASS = np.degrees(THETA), 90.0 - np.degrees(THETA)


@pytest.mark.parametrize(
    ("headings", "says"),
    [
        (DEGREES, "headings are degrees: .* say --degrees"),
        (DEGREES % 360, "headings are degrees: .* say --degrees"),
        (COMPASS, "compass .* write 90 - heading"),
        (np.pi / 2 - THETA, "compass .* write π/2"),
    ],
)
def test_headings_that_are_no_radians_are_a_question(tmp_path, headings, says):
    np.savez(tmp_path / "run.npz", t=T, poses=np.stack([X, Y, headings], axis=1))
    with pytest.raises(LayoutError, match=says):
        read(tmp_path / "run.npz")
    if "--degrees" in says and "compass" not in says:
        run = read(tmp_path / "run.npz", ReadOptions(degrees=True))
        np.testing.assert_allclose(np.exp(1j * run.poses[:, 2]), np.exp(1j * THETA), atol=1e-9)


def test_parked_robots_tell_degrees_by_where_they_begin(tmp_path):
    parked = np.stack([X[:1] + 0 * X, Y[:1] + 0 * Y, 90.0 + 0 * X], axis=1)
    np.savez(tmp_path / "run.npz", t=T, poses=parked)
    with pytest.raises(LayoutError, match="heading of 90, more than four turns"):
        read(tmp_path / "run.npz")


ONE = slice(0, 1)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (table([T, X[:, ONE], Y[:, ONE]]), "rises evenly .* --columns t,x1,y1"),
        (table([T, X[:, :2], Y[:, :2]]), "rises evenly"),
        (table([T, X[:, ONE], Y[:, ONE], COS[:, ONE], SIN[:, ONE]]), "name all columns"),
        (table([T, X, Y, COS, SIN]), "4 numbers each: x, y, cosine and sine; .* t,x1,y1,cos1,sin1"),
        (table([T, X, Y, THETA], ["t", *NAMES], comma), "commas stand within numbers and between"),
        (
            table([T, X, Y, THETA], (), lambda n: f"{n:.4f}".replace(".", ",")),
            "commas stand within",
        ),
        (PLAIN.replace("\n0.033,", '\n"1,234.5",'), "without marks between thousands"),
        ("header:\n  stamp:\n    sec: 1\n", "ros2 topic echo .* --csv"),
        ("#ROSBAG V2.0\nx", "a bag of ROS 1: convert it"),
    ],
)
def test_what_it_is_and_what_to_do(tmp_path, content, says):
    with pytest.raises(PosflockError, match=says):
        read(write(tmp_path / "run.csv", content.encode()), ReadOptions(dt=STEP))


@pytest.mark.parametrize(
    ("parts", "what"),
    [((COS, SIN), "cosine and sine"), ((0 * X, 0 * X, 0 * X, SIN, COS), "a quaternion")],
)
def test_rotations_in_arrays_are_no_robots(tmp_path, parts, what):
    np.savez(tmp_path / "run.npz", t=T, poses=np.stack([X, Y, *parts], axis=2)[:, :3])
    with pytest.raises(LayoutError, match=what):
        read(tmp_path / "run.npz")


@pytest.mark.parametrize("column", ["name", "marker"])
def test_rows_of_several_robots_are_never_one_robot(tmp_path, column):
    rows = [f"time,{column},x,y,theta"]
    for t, pose in zip(T.tolist(), POSES, strict=True):
        rows += [f"{t!r},r{n}," + ",".join(map(repr, pose[:, n].tolist())) for n in ROBOTS]
    file = write(tmp_path / "run.csv", "\n".join([*rows, ""]).encode())
    for options in (ReadOptions(), ReadOptions(dt=STEP)):
        if column == "name":
            np.testing.assert_array_equal(read(file, options).poses, POSES)
        else:
            with pytest.raises(LayoutError, match=r"'marker' tells them apart: is it the robot\?"):
                read(file, options)


def test_a_long_log_of_one_robot_has_no_row_of_times(tmp_path):
    t = STEP * np.arange(256)
    rows = np.stack(
        [-1.9 + 0.1 * t + 1e-3 * np.sin(t), 0 * t - 0.5, 0 * t + 0.0], axis=1
    )  # its first row rises
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",")
    run = read(tmp_path / "run.csv", ReadOptions(dt=STEP))
    np.testing.assert_allclose(run.poses[:, :, 0], rows)


@pytest.mark.parametrize("camera", [False, True])
def test_kitti_poses_of_a_robot_and_of_a_camera_on_it(tmp_path, camera):
    x, y, theta = X[:, 0], Y[:, 0], THETA[:, 0] + 0.4
    motion = np.zeros((len(T), 3, 4))
    motion[:, 0, :2] = np.stack([np.cos(theta), -np.sin(theta)], 1)
    motion[:, 1, :2] = np.stack([np.sin(theta), np.cos(theta)], 1)
    motion[:, 2, 2], motion[:, 0, 3], motion[:, 1, 3] = 1.0, x, y
    if camera:  # z ahead, x to the right, y down
        right_down_ahead = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
        motion[:, :, :3] = motion[:, :, :3] @ right_down_ahead.T
        motion = right_down_ahead @ motion
    np.savetxt(tmp_path / "00.txt", motion.reshape(len(T), 12))
    run = read(tmp_path / "00.txt", ReadOptions(dt=STEP))
    np.testing.assert_allclose(run.poses[:, :, 0], np.stack([x, y, theta], 1), atol=1e-9)
    assert any("KITTI" in note for note in run.notes)


def test_units_that_are_not_used_are_told(tmp_path):
    names = ["t", *(f"{n}_deg" if n[0] == "t" else f"{n}_m" for n in NAMES)]
    content = table([T, X, Y, DEGREES], names)
    run = read(write(tmp_path / "run.csv", content.encode()), ReadOptions(degrees=True))
    assert any("--degrees not used" in note for note in run.notes)
    np.testing.assert_allclose(run.poses, POSES, atol=1e-12)
