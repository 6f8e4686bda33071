"""Files are whole or absent, whatever ends the write; and nothing is written in another way."""

import ast
import os
import signal
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from posflock_robotarium.flocking.errors import OutputError
from rps_compat.whole_files import (
    atomic_folder,
    atomic_write,
    remove_drafts,
    write_whole,
    written_together,
)

ROOT = Path(__file__).parents[1]
PACKAGES = ("barrier_certificates", "rps_compat", "posflock_robotarium")


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def half_written(path, error, way=None):
    """Write a file, in a folder of files that belong together if asked, and fail."""
    if way is None:
        with atomic_write(path) as draft:
            draft.write_text("half")
            raise error
    with way(path.parent) as draft:
        write_whole(draft / path.name, "half")
        raise error


def test_a_file_is_there_when_it_is_whole(tmp_path):
    path = tmp_path / "numbers.txt"
    with atomic_write(path) as draft:
        draft.write_text("half")
        assert not path.exists()
        assert draft.suffix == ".txt"
        draft.write_text("whole")
    assert path.read_text() == "whole"
    assert names_in(path.parent) == ["numbers.txt"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, OSError(28, "No space left")])
def test_an_error_leaves_what_was_there(error, tmp_path):
    path = write_whole(tmp_path / "table.csv", "good")
    with pytest.raises((KeyboardInterrupt, ValueError, OutputError)):
        half_written(path, error)
    assert path.read_text() == "good"
    assert names_in(tmp_path) == ["table.csv"]


def test_what_the_disk_refuses_is_an_error_with_the_files_name(tmp_path):
    (tmp_path / "file").touch()
    for path in (tmp_path / "file" / "page.html", tmp_path):
        with pytest.raises(OutputError, match=str(path)):
            write_whole(path, "text")


def test_a_link_is_followed_and_permissions_stay(tmp_path):
    target = tmp_path / "far" / "results.json"
    target.parent.mkdir()
    target.write_text("old")
    target.chmod(0o640)
    link = tmp_path / "results.json"
    link.symlink_to(target)
    write_whole(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_a_device_is_written_to_and_stays_one():
    write_whole(Path(os.devnull), "text")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


KILLED = """
import os, signal, sys
from pathlib import Path
from rps_compat.whole_files import {function}
with {function}(Path(sys.argv[1])) as draft:
    {write}
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize(
    ("function", "write"),
    [
        ("atomic_write", "draft.write_text('half')"),
        ("written_together", "(draft / 'a').write_text('half')"),
        ("atomic_folder", "(draft / 'a').write_text('half')"),
    ],
)
def test_a_kill_leaves_a_draft_that_the_next_write_removes(function, write, tmp_path):
    place = tmp_path / "place"
    program = KILLED.format(function=function, write=write)
    done = subprocess.run([sys.executable, "-c", program, str(place)], check=False)
    assert done.returncode == -signal.SIGKILL
    inside = place if function == "written_together" else tmp_path
    (left,) = [name for name in names_in(inside) if name.startswith(".posflock.")]
    assert not place.is_file()
    write_whole(inside / "other", "text")
    assert left not in names_in(inside)


def test_drafts_of_processes_that_run_stay(tmp_path):
    with atomic_write(tmp_path / "file") as draft:
        remove_drafts(tmp_path)
        assert draft.exists()


def test_a_folder_that_is_missing_is_made(tmp_path):
    write_whole(tmp_path / "new" / "er" / "a", "1")
    assert (tmp_path / "new" / "er" / "a").read_text() == "1"


def test_an_error_names_the_file_as_it_would_have_been_called(tmp_path):
    with pytest.raises(OutputError, match=rf"^{tmp_path}/missing/a: cannot be written"):
        half_written(tmp_path / "b", OutputError("unused"), named_wrongly)


@contextmanager
def named_wrongly(folder):
    with written_together(folder) as draft:
        (draft / "missing").touch()  # a file, where the folder would have to be
        write_whole(draft / "missing" / "a", "text")
        yield draft


def test_files_that_belong_together_are_all_new_or_all_old(tmp_path):
    with written_together(tmp_path) as draft:
        write_whole(draft / "page.html", "1")
        (draft / "figures").mkdir()
        write_whole(draft / "figures" / "a.png", "1")
    (tmp_path / "mine.txt").write_text("stays")
    with pytest.raises(ValueError, match="half"):
        half_written(tmp_path / "page.html", ValueError("half"), written_together)
    assert (tmp_path / "page.html").read_text() == "1"
    assert names_in(tmp_path) == ["figures", "mine.txt", "page.html"]


def test_a_folder_is_replaced_at_once_or_not_at_all(tmp_path):
    place = tmp_path / "upload"
    for content in ("1", "2"):
        with atomic_folder(place) as draft:
            (draft / content).write_text(content)
        assert names_in(place) == [content]
    with pytest.raises(ValueError, match="half"):
        half_written(place / "3", ValueError("half"), atomic_folder)
    assert names_in(place) == ["2"]
    assert names_in(tmp_path) == ["upload"]


def test_a_folder_that_a_kill_caught_between_two_names_comes_back(tmp_path):
    place, aside = tmp_path / "upload", tmp_path / ".upload.earlier"
    aside.mkdir()
    (aside / "good").touch()
    with pytest.raises(ValueError, match="half"):
        half_written(place / "bad", ValueError("half"), atomic_folder)
    assert names_in(place) == ["good"]
    assert names_in(tmp_path) == ["upload"]


# --- Nothing is written in another way ------------------------------------------------------------

#: Files whose writes are not whole or absent, and why they need not be.
OTHERWISE = {
    "posflock_robotarium/commands/help_pages.py": "its `write` goes to a page of help, no file",
    "rps_compat/whole_files.py": "it is the way",
    "posflock_robotarium/flocking/row_file.py": "each row outlives a kill; goes to the testbed",
    "posflock_robotarium/flocking/pose_log.py": "its own draft and move; goes to the testbed",
    "posflock_robotarium/sweep/store.py": "segments are appended to",
    "posflock_robotarium/logs/readers/bundles.py": "a folder that ends with its process",
    "posflock_robotarium/submission/private_simulator.py": "a room that ends with its process",
    "posflock_robotarium/submission/rehearse.py": "a room that ends with its process",
    "posflock_robotarium/sweep/scripts.py": "a room that ends with its run",
    "posflock_robotarium/verify/trial.py": "a room that ends with its process",
    "posflock_robotarium/verify/trials.py": "a room that ends with its process",
    "rps_compat/containment/caches.py": "a room that ends with its process",
    "rps_compat/containment/entering.py": "a view of the system that ends with its process",
    "rps_compat/children/family.py": "a room that ends with its process",
    "rps_compat/children/names.py": "a room that ends with its process",
    "rps_compat/children/records.py": "a room that ends with its process",
    "rps_compat/surroundings.py": "a stream that is open already",
}
WAYS = {"atomic_write", "written_together", "atomic_folder"}
WRITERS = {
    "write_text", "write_bytes", "savefig", "to_csv", "tofile", "savetxt", "savez", "savemat",
    "savez_compressed", "write_table", "copyfile", "copy2", "copytree", "mkstemp",
}  # fmt: skip


def writes(call):
    """Whether a call writes a file, as far as its text tells."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name == "open":
        words = [node.value for node in ast.walk(call) if isinstance(node, ast.Constant)]
        modes = [w for w in words if isinstance(w, str) and set(w) <= set("rwaxbt+") and w]
        if ast.unparse(call.func) == "os.open":
            return not any(
                harmless in ast.unparse(call)
                for harmless in ("os.O_RDONLY", "os.O_PATH", "os.devnull")
            )
        return any(set(mode) & set("wax+") for mode in modes)
    if name == "savefig":  # into memory, where the format must be said
        return not any(keyword.arg == "format" for keyword in call.keywords)
    of_numpy = isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value) == "np"
    return name in WRITERS or (name == "save" and of_numpy)


def bare_writes(node, within=False):
    """Yield the lines of calls that write, outside every block that makes it whole or absent."""
    if isinstance(node, ast.With):
        called = {
            getattr(item.context_expr.func, "id", "")
            for item in node.items
            if isinstance(item.context_expr, ast.Call)
        }
        within = within or bool(called & WAYS)
    if isinstance(node, ast.Call) and writes(node) and not within:
        yield node.lineno
    for child in ast.iter_child_nodes(node):
        yield from bare_writes(child, within)


def test_every_file_is_written_whole_or_not_at_all():
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            lines = list(bare_writes(ast.parse(path.read_text(encoding="utf-8"))))
            if lines:
                found[str(path.relative_to(ROOT))] = lines
    assert {name: lines for name, lines in found.items() if name not in OTHERWISE} == {}
    assert set(OTHERWISE) - set(found) == set(), "these need no exception any more"


@pytest.mark.parametrize(
    "text",
    ["Path('a').write_text('b')", "figure.savefig(path)", "open(path, 'w')", "path.open('ab')",
     "np.save(path, a)", "os.open(p, os.O_CREAT)"],
)  # fmt: skip
def test_bare_writes_are_seen(text):
    assert list(bare_writes(ast.parse(text))) == [1]
    assert list(bare_writes(ast.parse(f"with atomic_write(p) as path:\n    {text}"))) == []
