"""Text as spreadsheets and loggers write it: units in headers, quotes, alphabets, missing cells."""

import numpy as np
import pytest
from rolling_robots import POSES, T, rolling, write

from posflock_robotarium.alignment.verdicts import Mark
from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import Lengths
from posflock_robotarium.report import LayoutError, ReadOptions, analyse, read, write_report

NAMES = [f"{state}{n}" for n in range(1, 5) for state in ("x", "y", "theta")]
TABLE = np.column_stack([T, POSES.transpose(0, 2, 1).reshape(len(T), -1)])


def csv(names, table, ending="\n", quote=""):
    rows = [names, *([repr(float(cell)) for cell in row] for row in table)]
    return ending.join(",".join(f"{quote}{cell}{quote}" for cell in row) for row in rows) + ending


PLAIN = csv(["t", *NAMES], TABLE)


@pytest.mark.parametrize(
    ("content", "note"),
    [
        (csv(["t", *NAMES], TABLE, quote='"').encode(), ""),
        (PLAIN.replace("\n", ",\n").encode(), ""),
        (csv(["t", *NAMES], TABLE, ending="\r\n").encode("utf-16"), "UTF-16"),
        (("# Müller\n" + PLAIN).encode("latin-1"), "Latin-1"),
        (PLAIN.replace("theta", "θ").encode(), ""),
        (PLAIN.encode() + b"1.32,0.1,0.2", "the last row is cut off, and left out"),
    ],
)
def test_spreadsheets(tmp_path, content, note):
    run = read(write(tmp_path / "run.csv", content))
    np.testing.assert_array_equal(run.poses, POSES)
    np.testing.assert_array_equal(run.t, T)
    assert any(note in said for said in run.notes)


@pytest.mark.parametrize("style", ["{} [{}]", "{}_{}", "{} ({})"])
@pytest.mark.parametrize(("length", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)])
def test_units_come_from_the_header(tmp_path, style, length, metres):
    names = [style.format(name, "deg" if name[0] == "t" else length) for name in NAMES]
    scale = np.tile([1 / metres, 1 / metres, 180 / np.pi], 4)
    run = read(write(tmp_path / "run.csv", csv(["t", *names], TABLE * [1.0, *scale])))
    np.testing.assert_allclose(run.poses, POSES, atol=1e-12)
    assert any("units by the header" in note for note in run.notes)


def test_lengths_that_cannot_be_metres_are_a_question(tmp_path):
    corner = POSES + np.array([[2.0], [1.0], [0.0]])
    scale = np.array([100.0, 100.0, 180 / np.pi])[:, np.newaxis]
    np.savez(tmp_path / "run.npz", t=T, poses=corner * scale)
    with pytest.raises(LayoutError, match=r"--units cm or --units mm"):
        read(tmp_path / "run.npz")
    run = read(tmp_path / "run.npz", ReadOptions(units=Lengths.CM, degrees=True))
    np.testing.assert_allclose(run.poses, corner, atol=1e-12)
    far = read(tmp_path / "run.npz", ReadOptions(units=Lengths.M, degrees=True))
    assert far.poses.max() > 100


@pytest.mark.parametrize("second", [1.0, 1e3, 1e6, 1e9])
def test_clocks_since_1970_in_any_unit(tmp_path, second):
    table = np.column_stack([np.round((1.7e9 + T) * second), TABLE[:, 1:]])
    if second == 1.0:
        table[:, 0] = 1.7e9 + T
    run = read(write(tmp_path / "run.csv", csv(["t", *NAMES], table)))
    np.testing.assert_allclose(run.t, T, atol=1e-3)


def test_rows_written_twice_are_dropped_and_told(tmp_path):
    twice = np.repeat(TABLE, 2, axis=0)
    twice[1::2, 0] += 0.0004
    run = read(write(tmp_path / "run.csv", csv(["t", *NAMES], twice)))
    np.testing.assert_array_equal(run.poses, POSES)
    assert any("40 of 80 rows repeat the one before them: dropped" in n for n in run.notes)


def test_robots_that_stand_still_are_not_written_twice(tmp_path):
    still = np.column_stack([T, np.repeat(TABLE[:1, 1:], len(T), axis=0)])
    still[30:, 1:] = TABLE[: len(T) - 30, 1:]  # then they drive off from there
    assert len(read(write(tmp_path / "run.csv", csv(["t", *NAMES], still))).t) == len(T)


def long(names, stamps):
    """One row a robot and sample, by what robots are called and by their own clocks."""
    rows = [
        f"{stamps[n][k]!r},{name},{','.join(map(repr, POSES[k, :, n].tolist()))}"
        for k in range(len(T))
        for n, name in enumerate(names)
    ]
    return "time,robot,x,y,theta\n" + "\n".join(rows) + "\n"


def test_robots_keep_their_names(tmp_path):
    names = ("ada", "bob", "cyd", "dan")
    run = read(write(tmp_path / "run.csv", long(names, [T.tolist()] * 4)))
    np.testing.assert_array_equal(run.poses, POSES)
    assert any("ada, bob, cyd, dan" in note for note in run.notes)


def test_robots_on_clocks_of_their_own_share_one(tmp_path):
    stamps = [(T + 0.003 * n).tolist() for n in range(4)]
    run = read(write(tmp_path / "run.csv", long("0123", stamps)))
    assert run.robots == 4
    _, truth = rolling(40, 4)
    for n in range(4):
        for axis in range(3):
            there = np.interp(run.t, T + 0.003 * n, truth[:, axis, n])
            np.testing.assert_allclose(run.poses[:, axis, n], there, atol=1e-9)
    assert any("resampled on a common clock" in note for note in run.notes)


def test_words_among_numbers_are_damage(tmp_path):
    with pytest.raises(LogError, match="line 3: column 2 is 'left'"):
        read(write(tmp_path / "run.csv", "t,x,y,theta\n0,0,0,0\n1,left,0,0\n2,0,0,0\n"))


def test_positions_alone_have_no_headings(tmp_path):
    names = [name for name in NAMES if name[0] != "t"]
    table = np.column_stack([T, POSES[:, :2].transpose(0, 2, 1).reshape(len(T), -1)])
    run = read(write(tmp_path / "run.csv", csv(["t", *names], table)))
    np.testing.assert_array_equal(run.poses[:, :2], POSES[:, :2])
    assert not run.headed
    assert any("positions only" in note for note in run.notes)


def test_a_report_of_positions_alone_does_not_judge_collisions(tmp_path):
    names = [name for name in NAMES if name[0] != "t"]
    table = np.column_stack([T, POSES[:, :2].transpose(0, 2, 1).reshape(len(T), -1)])
    analysis = analyse(write(tmp_path / "run.csv", csv(names=["t", *names], table=table)), radius=9)
    safe = next(verdict for verdict in analysis.verdicts if verdict.question == "Was it safe?")
    assert safe.mark is Mark.UNKNOWN
    assert "collisions" not in analysis.numbers
    assert np.isfinite(analysis.numbers["gamma_motion"].value)
    assert np.isnan(analysis.numbers["gamma_headings"].value)
    write_report([analysis], tmp_path / "report")
