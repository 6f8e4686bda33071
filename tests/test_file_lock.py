"""One writer a file: whoever comes second is told, unless nobody can know."""

import os

import numpy as np
import pytest

from barrier_certificates import file_lock
from posflock_robotarium.flocking.row_file import RowFile
from posflock_robotarium.sweep.store import Store
from rps_compat.run_folder import claimed_folder

pytestmark = pytest.mark.skipif(not file_lock.KNOWN, reason="this system has no locks")


@pytest.fixture
def two_descriptors(tmp_path):
    """One folder, opened twice."""
    opened = [os.open(tmp_path, os.O_RDONLY) for _ in range(2)]
    yield opened
    for file in opened:
        os.close(file)


def test_the_second_is_kept_out_until_the_first_has_closed(tmp_path, two_descriptors):
    first, second = two_descriptors
    assert file_lock.try_lock(first)
    assert not file_lock.try_lock(second)
    assert file_lock.try_lock(first)  # its own


def test_closing_gives_the_lock_back(tmp_path, two_descriptors):
    held = os.open(tmp_path, os.O_RDONLY)
    assert file_lock.try_lock(held)
    os.close(held)
    assert file_lock.try_lock(two_descriptors[0])


def no_locks_here(file, how):
    raise OSError(37, "No locks available")


def test_a_disk_without_locks_keeps_nobody_out(monkeypatch, two_descriptors):
    monkeypatch.setattr(file_lock.locks, "flock", no_locks_here)
    assert all(file_lock.try_lock(file) for file in two_descriptors)


def test_a_system_without_locks_keeps_nobody_out(monkeypatch, two_descriptors):
    monkeypatch.setattr(file_lock, "locks", None)
    assert all(file_lock.try_lock(file) for file in two_descriptors)


def test_runs_logs_and_studies_go_on_where_the_disk_has_no_locks(monkeypatch, tmp_path):
    monkeypatch.setattr(file_lock.locks, "flock", no_locks_here)
    assert claimed_folder(tmp_path / "run", tmp_path / "script.py").is_dir()
    with Store(tmp_path / "study") as store:
        store.append([{"key": "a"}])
    file = RowFile(tmp_path / "log.npy", np.zeros(1, dtype=[("t", "<f8")]), 1)
    file.append(np.zeros(1, dtype=[("t", "<f8")]).view(np.uint8))
    file.finish()
    file.close()
    assert np.load(tmp_path / "log.npy").shape == (1,)
