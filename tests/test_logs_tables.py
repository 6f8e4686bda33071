"""Tables of text are read by their headers, whatever separates, orders and names the columns."""

import numpy as np
import pytest
from rolling_robots import POSES, STEP, T, flat, rolling, write

from posflock_robotarium.report import LayoutError, ReadOptions, read

HEADERS = {
    "plain": "t,x1,y1,theta1,x2,y2,theta2,x3,y3,theta3,x4,y4,theta4",
    "underscores": "time,x_1,y_1,yaw_1,x_2,y_2,yaw_2,x_3,y_3,yaw_3,x_4,y_4,yaw_4",
    "robot first": "Time (s),"
    + ",".join(f"robot{i}_{s}" for i in range(4) for s in ("x", "y", "heading")),
    "brackets": "timestamp," + ",".join(f"{s}[{i}]" for i in range(4) for s in ("x", "y", "theta")),
}


@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_csv_by_header(tmp_path, header, separator):
    table = np.column_stack([T, flat("robot")])
    lines = [header, *(",".join(map(repr, row)) for row in table.tolist())]
    (tmp_path / "run.csv").write_text("\n".join(lines).replace(",", separator))
    recording = read(tmp_path / "run.csv")
    np.testing.assert_array_equal(recording.poses, POSES)
    np.testing.assert_array_equal(recording.t, T)


def test_csv_columns_in_any_order_and_with_others(tmp_path):
    names = HEADERS["plain"].split(",")
    table = np.column_stack([T, flat("robot"), np.full(len(T), 12.6)])
    order = np.random.default_rng(0).permutation(14)
    lines = [[*names, "battery"], *table.astype(str)]
    (tmp_path / "run.csv").write_text("\n".join(",".join(line[k] for k in order) for line in lines))
    recording = read(tmp_path / "run.csv")
    np.testing.assert_array_equal(recording.poses, POSES)
    assert any("battery" in note for note in recording.notes)


def test_text_without_header_or_time(tmp_path):
    np.savetxt(tmp_path / "run.txt", flat("robot"), fmt="%.17g")
    recording = read(tmp_path / "run.txt", ReadOptions(dt=STEP))
    np.testing.assert_array_equal(recording.poses, POSES)


def test_numpy_savetxt_with_its_commented_header(tmp_path):
    table = np.column_stack([T, flat("robot")])
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header=HEADERS["plain"])
    np.testing.assert_array_equal(read(tmp_path / "run.csv").poses, POSES)


def test_columns_named_on_the_command_line(tmp_path):
    np.savetxt(tmp_path / "run.csv", np.column_stack([T, POSES[:, :, 0], T]), delimiter=",")
    recording = read(tmp_path / "run.csv", ReadOptions(columns="t,x,y,theta,-"))
    np.testing.assert_allclose(recording.poses[:, :, 0], POSES[:, :, 0])


def test_long_csv_with_a_row_for_each_robot(tmp_path):
    rows = ["stamp,robot_id,x,y,theta"]
    rows += [
        f"{t!r},{i},{x!r},{y!r},{h!r}"
        for t, p in zip(T.tolist(), POSES.tolist(), strict=True)
        for i, (x, y, h) in enumerate(zip(*p, strict=True))
    ]
    (tmp_path / "run.csv").write_text("\n".join(rows))
    np.testing.assert_array_equal(read(tmp_path / "run.csv").poses, POSES)
    (tmp_path / "run.csv").write_text("\n".join(rows[:-1]))
    assert np.argwhere(~read(tmp_path / "run.csv").seen).tolist() == [[len(T) - 1, 3]]
    short = read(tmp_path / "run.csv", ReadOptions(drop_damaged=True))
    np.testing.assert_array_equal(short.poses, POSES[:-1])
    assert any("1 row(s) of single robots are missing" in note for note in short.notes)


def test_decimal_commas_between_semicolons(tmp_path):
    t, poses = rolling(20, 2)
    table = np.column_stack([t, poses.transpose(0, 2, 1).reshape(20, -1)])
    rows = [";".join(f"{value:.6f}".replace(".", ",") for value in row) for row in table]
    header = "t;x1;y1;theta1;x2;y2;theta2"
    for name, lines in (("named", [header, *rows]), ("bare", rows)):
        path = write(tmp_path / f"{name}.csv", "\n".join(lines))
        again = read(path, ReadOptions(columns=None if name == "named" else "robot"))
        np.testing.assert_allclose(again.poses, poses, rtol=0, atol=1e-6)
        np.testing.assert_allclose(again.t, t, rtol=0, atol=1e-6)
        assert any("decimal" in note for note in again.notes)


@pytest.mark.parametrize("name", ["time_ms", "t [ms]", "Time (ms)", "timestamp_ms"])
def test_milliseconds_are_told_by_the_columns_name(tmp_path, name):
    rows = "\n".join(f"{33 * k},{0.003 * k},0,0" for k in range(20))
    recording = read(write(tmp_path / "ms.csv", f"{name},x,y,theta\n{rows}"))
    np.testing.assert_allclose(recording.t, 0.033 * np.arange(20))
    assert any("milliseconds" in note for note in recording.notes)


def test_times_that_must_be_milliseconds_are_asked_about(tmp_path):
    rows = "\n".join(f"{33 * k},{0.003 * k},0,0" for k in range(20))
    with pytest.raises(LayoutError, match=r"33 s from one pose to the next.*milliseconds"):
        read(write(tmp_path / "ms.csv", f"t,x,y,theta\n{rows}"))
