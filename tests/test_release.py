"""What has to agree before a release, and what 1.x has promised."""

import re
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import pytest

import posflock_robotarium

ROOT = Path(__file__).resolve().parents[1]
VERSION = posflock_robotarium.__version__


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_is_the_same_wherever_it_stands():
    assert re.fullmatch(r"\d+\.\d+\.\d+", VERSION)
    assert version("posflock-robotarium") == VERSION, "install again: make does that by itself"
    heading = re.search(
        r"^## (?!Unreleased)(\S+) \((\d{4}-\d\d-\d\d)\)$", text("CHANGELOG.md"), re.M
    )
    assert heading is not None
    citation = text("CITATION.cff")
    assert (heading[1], re.search(r"^version: (.*)$", citation, re.M)[1]) == (VERSION, VERSION)
    assert f'date-released: "{heading[2]}"' in citation
    for page in ("README.md", "docs/reference/dependencies.md"):
        wheels = re.findall(r"posflock_robotarium-([\d.]+)-py3-none-any\.whl", text(page))
        assert set(wheels) == {VERSION}


def test_what_nobody_could_know_stands_in_one_place_and_first_on_the_release_list():
    (address,) = re.findall(r"^url = (\S+)$", text("setup.cfg"), re.M)
    if ".example" in address:
        assert address in text("docs/how-to/release.md").split("Then, for every release")[0]
    host = address.removeprefix("https://")
    folders = ("barrier_certificates", "rps_compat", "posflock_robotarium", "docs", "experiments")
    files = [path for path in ROOT.iterdir() if path.is_file()]
    files += [path for folder in folders for path in (ROOT / folder).rglob("*")]
    endings = {".py", ".md", ".cfg", ".toml", ".cff", ".html", ".j2", ".js", ".ipynb"}
    named = {
        path.relative_to(ROOT).as_posix()
        for path in files
        if path.suffix in endings and host in path.read_text("utf-8")
    }
    assert named <= {"setup.cfg", "docs/how-to/release.md", "CITATION.cff"}
    assert text("setup.cfg").count(address) == 1


def test_what_1_x_keeps_is_there():
    page = text("docs/reference/public-surface.md")
    rows = re.findall(
        r"^\| `((?:barrier_certificates|rps_compat|posflock_robotarium)[\w.]*)` \| (.*) \|$",
        page,
        re.M,
    )
    assert len(rows) > 15
    for name, words in rows:
        module = import_module(name)
        assert module.__doc__
        public = getattr(module, "__all__", [n for n in vars(module) if not n.startswith("_")])
        for promised in re.findall(r"`(\w+)`", words):
            assert promised in public, f"{name}.{promised}"
            assert hasattr(module, promised)


@pytest.mark.parametrize(
    "target", ["lint", "test", "demo", "test-numpy1", "test-portable", "wheel"]
)
def test_hosted_machines_do_what_the_makefile_says(target):
    assert f"make {target}" in text(".github/workflows/tests.yml")
    assert re.search(rf"^{target}:", text("Makefile"), re.M)


def test_every_python_that_is_supported_is_tried_by_hosted_machines():
    claimed = re.findall(r"Python :: (3\.\d+)", text("setup.cfg"))
    tried = re.search(r"python: \[(.*)\]", text(".github/workflows/tests.yml"))[1]
    assert claimed == re.findall(r"3\.\d+", tried)
