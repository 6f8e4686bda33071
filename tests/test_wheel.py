"""The wheel alone: what it holds, what it says of itself, and what a stranger can do with it."""

import configparser
import re
import runpy
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from unittest import mock

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def settings():
    found = configparser.ConfigParser(interpolation=None)
    found.read(ROOT / "setup.cfg", encoding="utf-8")
    return found


def names(requirements: str) -> set[str]:
    lines = re.sub(r"#.*", "", requirements).split("\n")
    return {re.split(r"[ <>=;\[]", line.strip())[0] for line in lines if line.strip()}


def test_the_slim_way_installs_all_but_what_says_that_it_is_missing(settings):
    page = (ROOT / "docs/reference/dependencies.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"^pip install (numpy .*)$", page, re.M)
    by_default = names(settings["options"]["install_requires"])
    assert by_default - set(line.split()) == {"cvxpy", "osqp", "clarabel", "h5py"}
    for name in by_default:
        assert name in page, f"docs/reference/dependencies.md does not say why {name} is there"
    for extra in settings["options.extras_require"]:
        assert f"`{extra}`" in page, extra


def test_every_link_of_the_readme_leads_home_from_a_package_index(settings):
    pytest.importorskip("setuptools", reason="Python brings it no longer")
    with mock.patch("setuptools.setup"):
        build = runpy.run_path(str(ROOT / "setup.py"))
    targets = re.findall(r"\]\(([^)\s]+)\)", build["long_description"]())
    assert len(targets) > 10
    assert all("://" in target or target.startswith("#") for target in targets)
    assert f"{settings['metadata']['url']}/docs/pictures/report.png" in targets


@pytest.mark.slow
def test_a_stranger_with_the_wheel_alone_gets_to_a_report():
    """Builds, checks, installs and tries; then looks into both archives."""
    # A folder of that name, which others build into, counts as a package, too.
    pytest.importorskip("build.__main__", reason="make wheel brings what builds and checks")
    minor = f"3.{sys.version_info[1]}"
    subprocess.run([sys.executable, ".ci/wheel.py", "--python", minor], cwd=ROOT, check=True)
    subprocess.run(
        [sys.executable, ".ci/wheel.py", "--python", minor, "--slim"], cwd=ROOT, check=True
    )
    (wheel,), (source,) = (ROOT / "dist").glob("*.whl"), (ROOT / "dist").glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    for package in ("barrier_certificates", "rps_compat", "posflock_robotarium"):
        for path in (ROOT / package).rglob("*"):
            if path.is_file() and path.suffix not in (".pyc", ".pyo"):
                assert path.relative_to(ROOT).as_posix() in held
    with tarfile.open(source) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    tracked = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    expected = {name for name in tracked.stdout.splitlines() if name != ".gitignore"}
    assert expected <= held, expected - held
