"""Damage in a log is named with its file and its place; nothing in a file can do harm."""

import pickle
import warnings
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rolling_robots import POSES, STEP, T, rolling, write
from scipy.io import savemat

from posflock_robotarium.flocking.errors import LogError
from posflock_robotarium.logs.readers import Bounds
from posflock_robotarium.report import ReadOptions, read


def test_a_matlab_file_that_ends_scipys_process_is_refused(tmp_path):
    savemat(tmp_path / "run.mat", {"poses": POSES})
    content = bytearray((tmp_path / "run.mat").read_bytes())
    at = content.index(b"poses") + 8  # the tag of the values: their type, then their length
    assert content[at : at + 4] == b"\x09\0\0\0"
    for wrong in (b"\0\0\0\0", b"\xff\xff\0\0"):
        content[at : at + 4] = wrong
        (tmp_path / "run.mat").write_bytes(content)
        with pytest.raises(LogError, match="poses: values of unknown type"):
            read(tmp_path / "run.mat", ReadOptions(dt=STEP))


def test_a_small_file_may_not_unpack_to_gigabytes(tmp_path):
    bomb = zlib.compress(bytes((1 << 20) + 64))
    head = b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"
    element = np.array([15, len(bomb)], "<u4").tobytes() + bomb
    (tmp_path / "bomb.mat").write_bytes(head + element)
    with pytest.raises(LogError, match="more than 1 MB"):
        read(tmp_path / "bomb.mat", ReadOptions(dt=STEP, bounds=Bounds(megabytes=1)))


def npy_bytes(tmp_path, array):
    np.save(tmp_path / "whole.npy", array)
    return (tmp_path / "whole.npy").read_bytes()


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("empty.csv", "", "empty"),
        ("empty.npy", b"", "empty"),
        ("blank.csv", "\n\n# nothing\n", "no row of numbers"),
        ("header.csv", "t,x,y,theta\n", "no row of numbers"),
        ("word.csv", "t,x,y,theta\n0,0,0,0\n1,0,zero,0\n", "line 3: column 3 is 'zero'"),
        ("ragged.csv", "t,x,y,theta\n0,0,0,0\n1,0,0\n", "line 3: 3 columns"),
        ("backwards.csv", "t,x,y,theta\n0,0,0,0\n2,0,0,0\n1,0,0,0\n", "row 2: time runs backwards"),
        ("standing.csv", "t,x,y,theta\n0,0,0,0\n0,0,0,0\n", "row 1: time stands still"),
        ("nan.csv", "t,x,y,theta\n0,0,0,0\n1,nan,0,0\n2,nan,0,0\n", "only 33% of its poses"),
        ("far.csv", "t,x,y,theta\n0,1e9,1e9,0\n1,1e9,1e9,0\n", "what are lengths in"),
        ("strange.csv", "a,b,c,d\n0,0,0,0\n1,0,0,0\n", "do not say where x, y and theta are"),
        ("one.csv", "t,x,y,theta\n0,0,0,0\n", "at least 2"),
        ("binary.csv", b"\x00\x01\x02\x03" * 10, "binary file"),
        ("latin.csv", b"t,x,y,theta\n0,0,0,\xff\n", "theta holds words"),
        ("not.npy", b"hello there, this is text", "beginning is damaged"),
        ("not.mat", b"hello there, this is text", "beginning is damaged"),
        ("run.pkl", pickle.dumps([1, 2, 3]), "pickle"),
        ("run.dat", pickle.dumps([1, 2, 3]), "pickle"),
    ],
)
def test_damage_is_named_with_file_and_place(tmp_path, name, content, reason):
    with pytest.raises(LogError, match=reason) as caught:
        read(write(tmp_path / name, content))
    assert name in str(caught.value)


def test_a_cut_off_npy_says_at_which_row(tmp_path):
    whole = npy_bytes(tmp_path, POSES)
    with pytest.raises(LogError, match="cut off at row 20 of 40"):
        read(write(tmp_path / "cut.npy", whole[: 128 + 20 * 96 + 5]), ReadOptions(dt=STEP))


def test_pickled_objects_are_refused_in_npy_and_npz(tmp_path):
    harmless = np.array([{"a": 1}, None], dtype=object)
    np.save(tmp_path / "run.npy", harmless, allow_pickle=True)
    np.savez(tmp_path / "run.npz", poses=harmless)
    for name in ("run.npy", "run.npz"):
        with pytest.raises(LogError, match="pickled objects"):
            read(tmp_path / name)


def test_a_header_that_promises_terabytes_costs_nothing(tmp_path):
    whole = npy_bytes(tmp_path, POSES)
    huge = whole.replace(b"(40, 3, 4)", b"(999999999999, 3, 4)"[:10].ljust(10))
    assert huge != whole
    huge = whole.replace(b"(40, 3, 4), }         ", b"(999999999, 3, 4), }  ")
    assert len(huge) == len(whole)
    with pytest.raises(LogError, match="cut off"):
        read(write(tmp_path / "huge.npy", huge), ReadOptions(dt=STEP))


def test_a_missing_file_and_a_folder(tmp_path):
    with pytest.raises(LogError, match="no such file"):
        read(tmp_path / "nothing.npy")
    with pytest.raises(LogError, match="a folder"):
        read(tmp_path)


@given(st.data())
def test_any_flipped_byte_gives_a_named_error_or_a_recording(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("flipped")
    small = POSES[:6]
    kind = data.draw(st.sampled_from(["npy", "npz", "mat", "csv"]))
    path = folder / f"run.{kind}"
    if kind == "npy":
        np.save(path, small)
    elif kind == "npz":
        np.savez(path, t=T[:6], poses=small)
    elif kind == "mat":
        savemat(path, {"t": T[:6], "poses": small})
    else:
        np.savetxt(path, np.column_stack([T[:6], small.reshape(6, -1)]), delimiter=",", fmt="%.4g")
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    try:
        recording = read(path, ReadOptions(dt=STEP))
    except LogError as error:
        if "run." not in str(error):
            pytest.fail(f"the error does not name the file: {error}")
    else:
        assert not np.isinf(recording.poses).any()
        assert recording.seen.sum() >= 2
        assert (np.diff(recording.t) > 0).all()


def test_numbers_that_do_not_fit_are_unseen_and_told(tmp_path):
    wide = POSES.astype(np.longdouble)
    wide[3, 0, 0] = np.longdouble(10) ** 400
    np.save(tmp_path / "wide.npy", wide)
    run = read(tmp_path / "wide.npy", ReadOptions(dt=STEP))
    assert np.argwhere(~run.seen).tolist() == [[3, 0]]
    assert any("row 3: x of robot 0 is inf" in note for note in run.notes)


def test_times_that_are_not_finite_are_refused_by_row(tmp_path):
    t, poses = rolling(30, 2)
    t[4:6] = np.inf
    np.savez(tmp_path / "run.npz", poses=poses, t=t)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(LogError, match="row 4"):
            read(tmp_path / "run.npz", ReadOptions(layout="T,3,N"))
