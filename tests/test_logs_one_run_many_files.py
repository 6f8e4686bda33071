"""One run in many files: a file a robot with stamps of its own, folders and zips."""

import zipfile

import numpy as np
import pytest
from rolling_robots import rolling, write

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.report import ReadOptions, read, read_parts

T, POSES = rolling(200, 3)
LATE = 0.007


def robot(n, keep=slice(None)):
    stamps = 1.7e9 + T + LATE * n
    lines = np.column_stack([stamps, POSES[:, :, n]])[keep].tolist()
    return "time,x,y,theta\n" + "".join(",".join(map(repr, line)) + "\n" for line in lines)


def folder_of(place, keep=slice(None)):
    place.mkdir()
    return [
        write(place / f"robot_{n}.csv", robot(n, keep if n == 1 else slice(None))) for n in range(3)
    ]


def expect(run):
    assert run.robots == 3
    start = 2 * LATE
    for n in range(3):
        for axis in range(3):
            there = np.interp(run.t + start - LATE * n, T, POSES[:, axis, n])
            np.testing.assert_allclose(run.poses[:, axis, n], there, atol=1e-5)
    assert any("robot_0, robot_1, robot_2" in note for note in run.notes)


def test_one_file_a_robot_is_joined_on_a_common_clock(tmp_path):
    expect(read_parts(folder_of(tmp_path / "run")))


def test_a_folder_and_a_zip_of_one_run(tmp_path):
    files = folder_of(tmp_path / "run")
    write(tmp_path / "run" / "notes.md", "a good run")
    expect(read(tmp_path / "run"))
    with zipfile.ZipFile(tmp_path / "run.zip", "w") as archive:
        for file in files:
            archive.write(file, f"../deep/{file.name}")
    run = read(tmp_path / "run.zip")
    expect(run)
    assert run.name == "run"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run", "run.zip"]


def test_nothing_is_invented_where_a_robot_was_not_seen(tmp_path):
    seen = np.ones(200, dtype=bool)
    seen[80:120] = False
    files = folder_of(tmp_path / "run", seen)
    run = read_parts(files)
    assert not run.seen[:, 1].all()
    assert run.seen[:, 0].all()
    run = read_parts(files, ReadOptions(drop_damaged=True))
    assert np.diff(run.t).max() > 1.2


def test_robots_that_were_never_seen_together_are_no_run(tmp_path):
    write(tmp_path / "a.csv", robot(0, slice(0, 50)))
    write(tmp_path / "b.csv", robot(1, slice(100, 150)))
    with pytest.raises(LogError, match="report them as several runs"):
        read_parts([tmp_path / "a.csv", tmp_path / "b.csv"])


def test_a_folder_without_logs_says_so(tmp_path):
    with pytest.raises(LogError, match="no log in it"):
        read(tmp_path)


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize(
    ("damaged", "told"),
    [
        ("time,x,y,theta\n0,0,0,0\n0.1,0,0\n0.2,0,0,0\n", r"run(\.zip)?/robot_1\.csv: line 3: "),
        ("t,x1,y1,theta1,x2,y2,theta2\n0,0,0,0,1,1,0\n0.1,0,0,0,1,1,0\n", r"run(\.zip)?: parts of"),
    ],
)
def test_what_is_wrong_in_a_zip_is_told_by_its_name_in_there(tmp_path, packed, damaged, told):
    files = folder_of(tmp_path / "run")
    files[1].write_text(damaged)
    with zipfile.ZipFile(tmp_path / "run.zip", "w") as archive:
        for file in files:
            archive.write(file, file.name)
    with pytest.raises(LogError, match=told) as failure:
        read(tmp_path / ("run.zip" if packed else "run"))
    assert "unpack" not in str(failure.value)
