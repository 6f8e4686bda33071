"""What trackers and robot middleware write: quaternions, nanoseconds, several header lines."""

import numpy as np
import pytest
from rolling_robots import POSES, T, write

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.convert import convert
from posflock_robotarium.report import Run, read

ONE = POSES[:, :, :1]
HALF = ONE[:, 2, 0] / 2
ZERO = np.zeros(len(T))
EPOCH = 1_700_000_000


def expect(run, poses=ONE):
    np.testing.assert_allclose(run.poses[:, :2], poses[:, :2], atol=1e-6)
    np.testing.assert_allclose(np.exp(1j * run.poses[:, 2]), np.exp(1j * poses[:, 2]), atol=1e-6)
    np.testing.assert_allclose(run.t - run.t[0], T, atol=1e-5)


def rows(columns, separator=","):
    lines = zip(*[[repr(v) for v in np.asarray(c).tolist()] for c in columns], strict=True)
    return "".join(separator.join(line) + "\n" for line in lines)


NS = EPOCH * 10**9 + np.round(T * 1e9).astype(np.int64)
X, Y = ONE[:, 0, 0], ONE[:, 1, 0]


def test_tum(tmp_path):
    columns = [EPOCH + T, X, Y, ZERO, ZERO, ZERO, np.sin(HALF), np.cos(HALF)]
    content = "# timestamp tx ty tz qx qy qz qw\n" + rows(columns, " ")
    run = read(write(tmp_path / "run.txt", content))
    expect(run)
    assert "TUM" in run.notes[0]


def test_euroc(tmp_path):
    names = (
        "#timestamp,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []"
    )
    columns = [NS, X, Y, ZERO, np.cos(HALF), ZERO, ZERO, np.sin(HALF)]
    run = read(write(tmp_path / "run.csv", names + "\n" + rows(columns)))
    expect(run)
    assert "EuRoC" in run.notes[0]


@pytest.mark.parametrize("stamp", [NS, np.full(len(T), NS[0])])
def test_ros_odometry(tmp_path, stamp):
    pose = "field.pose.pose"
    names = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    names += [f"{pose}.position.{a}" for a in "xyz"] + [f"{pose}.orientation.{a}" for a in "xyzw"]
    lines = rows([NS, np.arange(len(T)), stamp, X, Y, ZERO, ZERO, ZERO, np.sin(HALF), np.cos(HALF)])
    cells = [line.split(",") for line in lines.splitlines()]
    body = "".join(",".join([*row[:3], "", *row[3:]]) + "\n" for row in cells)
    run = read(write(tmp_path / "run.csv", ",".join(names) + "\n" + body))
    expect(run)
    assert any("ROS" in note for note in run.notes)


def test_mrclam_ground_truth_and_no_odometry(tmp_path):
    head = "# Robot 1\n# Time [s]    x [m]    y [m]    orientation [rad]\n"
    columns = [EPOCH + T, X, Y, ONE[:, 2, 0]]
    expect(read(write(tmp_path / "Robot1_Groundtruth.dat", head + rows(columns, "\t"))))
    head = "# Robot 1\n# Time [s]    forward velocity [m/s]    angular velocity[rad/s]\n"
    with pytest.raises(LogError, match=r"without poses.*Groundtruth"):
        read(write(tmp_path / "Robot1_Odometry.dat", head + rows(columns[:3], "\t")))


def test_motive_has_y_up(tmp_path):
    head = (
        "Format Version,1.23,Take Name,run,Rotation Type,Quaternion,Length Units,Millimeters\n\n"
        + ",,"
        + ",".join(["Rigid Body"] * 28)
        + "\n,Name,"
        + ",".join(f"r{n}" for n in range(4) for _ in range(7))
        + "\n,ID,"
        + ",".join(["1"] * 28)
        + "\n,,"
        + ",".join((["Rotation"] * 4 + ["Position"] * 3) * 4)
        + "\nFrame,Time (Seconds),"
        + ",".join("XYZWXYZ" * 4)
        + "\n"
    )
    columns = [np.arange(len(T)), T]
    for x, y, theta in POSES.transpose(2, 1, 0):
        columns += [ZERO, np.sin(theta / 2), ZERO, np.cos(theta / 2), 1e3 * x, ZERO, -1e3 * y]
    run = read(write(tmp_path / "run.csv", head + rows(columns)))
    expect(run, POSES)
    assert "r0, r1, r2, r3" in run.notes[0]
    with pytest.raises(LogError, match="rotation type Quaternion"):
        read(write(tmp_path / "run.csv", head.replace("Quaternion", "XYZ") + rows(columns)))


def test_vicon(tmp_path):
    head = (
        f"Objects\n{float(1 / T[1])}\n,,"
        + ",".join(f"lab:r{n},,,,," for n in range(4))
        + "\nFrame,Sub Frame,"
        + ",".join(["RX,RY,RZ,TX,TY,TZ"] * 4)
        + "\n,,"
        + ",".join(["rad,rad,rad,mm,mm,mm"] * 4)
        + "\n"
    )
    columns = [1 + np.arange(len(T)), 0 * ZERO]
    for x, y, theta in POSES.transpose(2, 1, 0):
        columns += [ZERO, ZERO, theta, 1e3 * x, 1e3 * y, ZERO]
    run = read(write(tmp_path / "run.csv", head + rows(columns)))
    expect(run, POSES)
    assert "r0, r1, r2, r3" in run.notes[0]


def test_our_own_mcap_comes_back(tmp_path):
    commands = np.full((len(T), 2, 4), 0.1)
    convert(Run("run", T, POSES, commands=commands), tmp_path / "run.mcap")
    run = read(tmp_path / "run.mcap")
    expect(run, POSES)
    np.testing.assert_array_equal(run.commands, commands)
