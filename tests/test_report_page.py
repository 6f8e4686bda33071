"""The page: self-contained, small, agreeing with the analysis, and deaf to hostile strings."""

import base64
import dataclasses
import html.parser
import json
import re
from importlib import resources

import numpy as np
import pytest

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.report import Run, analyse
from posflock_robotarium.report.outputs import (
    latex_table,
    write_curves,
    write_report,
    write_summary,
)
from posflock_robotarium.report.page import render, write_page
from posflock_robotarium.report.words import unbroken

HOSTILE = """</script><script>alert(1)</script><img src=x onerror=alert(2)>"'&{{7*7}}<!--"""


def analysis_of(motion="parallel", duration=10.0, **changes):
    flock = known_flock(motion, 0.1, duration=duration)
    return analyse(dataclasses.replace(flock.recording, **changes), radius=flock.radius)


@pytest.fixture(scope="module")
def analysis():
    return analysis_of()


class Document(html.parser.HTMLParser):
    """What a browser would see: elements, attributes, text outside scripts."""

    def __init__(self, page):
        super().__init__()
        self.elements, self.attributes, self.words, self._inside = [], [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.elements.append(tag)
        self.attributes += [(tag, name, value) for name, value in attrs]
        self._inside.append(tag)

    def handle_endtag(self, tag):
        while self._inside and self._inside.pop() != tag:
            pass

    def handle_data(self, data):
        if not {"script", "style"} & set(self._inside):
            self.words.append(data)


def data_of(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.S)[1])


def test_every_string_of_a_log_is_escaped():
    names = {"name": HOSTILE, "sources": (f"/tmp/{HOSTILE}.npy",), "notes": (HOSTILE,)}
    parameters = {HOSTILE: HOSTILE, "ended": {"how": HOSTILE, "reason": HOSTILE}}
    hostile = analysis_of(**names, parameters=parameters)
    clean = analysis_of()
    for runs, plain in (([hostile], [clean]), ([hostile, hostile], [clean, clean])):
        seen, expected = Document(render(runs)), Document(render(plain))
        # Hostile strings are words on the page, and nothing else: no element more.
        assert seen.elements.count("script") == expected.elements.count("script") == 6
        assert "img" not in seen.elements
        assert not [name for _, name, _ in seen.attributes if name.startswith("on")]
        assert HOSTILE in "".join(seen.words)
        assert data_of(render(runs))["runs"][0]["name"] == HOSTILE


def test_a_hostile_file_name_reaches_the_page_as_text(tmp_path):
    path = tmp_path / """<img src=x onerror='alert(1)'>&"x"""
    with PoseLog(path, 2, 60, {"neighbour_radius": 0.75, "x<y": "</script>"}) as log:
        for k in range(60):
            log.append(k * 0.033, [[0.1 * k * 0.033] * 2, [0, 0.4], [0, 0]], np.zeros((2, 2)))
    [page, *_] = write_report([analyse(path)], tmp_path / "out", figures=False, latex=True)
    document = Document(page.read_text())
    assert "img" not in document.elements
    assert "<img src=x" in "".join(document.words)
    assert not list((tmp_path / "out").glob("*<*"))


def test_the_page_is_one_file_that_asks_for_nothing(analysis):
    page = render([analysis])
    document = Document(page)
    for _, name, value in document.attributes:
        if name in ("src", "href", "action", "data"):
            assert value.startswith(("#", "data:")), (name, value)
    [policy] = [v for _, name, v in document.attributes if name == "content" and "src" in v]
    assert policy.startswith("default-src 'none'; ")
    assert "@import" not in page
    assert not re.search(r"url\((?!data:)", page)


def test_no_line_of_a_verdict_ends_between_a_number_and_its_unit(analysis):
    assert re.search(r"\d\u00a0% of the run", render([analysis]))
    assert unbroken("3 measures, 0.1 m/s, 2 mm of 5 s") == (
        "3 measures, 0.1\u00a0m/s, 2\u00a0mm of 5\u00a0s"
    )


def test_the_policy_names_the_scripts_that_are_there(analysis):
    import hashlib

    page = render([analysis])
    scripts = re.findall(r"<script>(.*?)</script>", page, re.S)
    assert len(scripts) == 5  # uPlot, look, arena, recorded, report
    for script in scripts:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"sha256-{digest}" in page


def array(text, kind):
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def test_what_is_embedded_is_what_was_analysed(analysis):
    data = data_of(render([analysis]))
    [run] = data["runs"]
    poses = array(run["poses"], "<u2").reshape(-1, 3, 10).astype(float) / 65534
    low, span = np.array(run["low"])[:, np.newaxis], np.array(run["span"])[:, np.newaxis]
    np.testing.assert_allclose(
        poses[:, :2] * span + low, analysis.recording.poses[:, :2], atol=1e-4
    )
    turned = np.exp(1j * (poses[:, 2] * 2 * np.pi - analysis.recording.poses[:, 2]))
    np.testing.assert_allclose(turned, 1, atol=1e-4)
    curves = {s["key"]: s for panel in data["panels"] for s in panel["series"]}
    for key in ("gamma_motion", "speed", "smallest_distance"):
        values = array(curves[key]["values"], "<f4")
        np.testing.assert_allclose(values, analysis.curves[key], rtol=1e-6)


def test_nine_robots_for_two_minutes_stay_under_three_megabytes():
    flock = known_flock("rotating", 0.1, robots=10, duration=120.0)
    recording = dataclasses.replace(
        flock.recording,
        commands=np.full((len(flock.recording.t), 2, 10), 0.1),
        intervention=np.zeros(len(flock.recording.t)),
    )
    assert len(render([analyse(recording, radius=flock.radius)]).encode()) < 3e6


def test_long_runs_are_thinned_and_keep_their_worst_moment():
    samples, robots = 27_000, 12
    t = np.arange(samples) * 0.033
    poses = np.zeros((samples, 3, robots))
    poses[:, 0] = 0.2 * np.arange(robots)
    away = np.abs(np.arange(samples) - 12_345)  # as fast as wheels turn, and back
    poses[:, 0, 3] = poses[:, 0, 2] + np.minimum(0.2, 0.05 + 0.005 * away)
    analysis = analyse(Run("long", t, poses), radius=0.75)
    page = render([analysis])
    assert len(page.encode()) < 3e6
    data = data_of(page)
    assert data["runs"][0]["stride"] > 1
    curves = {s["key"]: s for panel in data["panels"] for s in panel["series"]}
    assert array(curves["smallest_distance"]["values"], "<f4").min() == pytest.approx(0.05)


def test_several_runs_share_a_page(analysis):
    other = dataclasses.replace(
        analysis, recording=dataclasses.replace(analysis.recording, name="b")
    )
    third = dataclasses.replace(
        analysis, recording=dataclasses.replace(analysis.recording, name="c")
    )
    page = render([analysis, other, third])
    data = data_of(page)
    assert [run["name"] for run in data["runs"]] == [analysis.name, "b", "c"]
    assert all(len(panel["series"]) == 3 for panel in data["panels"])
    assert len(page.encode()) < 3e6
    with pytest.raises(ParameterError, match="no run"):
        render([])


def test_gaps_reach_the_page():
    flock = known_flock("parallel", 0.1, duration=5.0)
    keep = np.r_[0:60, 100:150]
    recording = dataclasses.replace(
        flock.recording, t=flock.recording.t[keep], poses=flock.recording.poses[keep]
    )
    page = render([analyse(recording, radius=100.0)])
    assert data_of(page)["gaps"] == [pytest.approx(3.3)]
    assert "1 gap, " in page


def test_the_csv_is_exact_and_leaves_undefined_cells_empty(tmp_path):
    analysis = analysis_of("stopped", duration=3.0)
    lines = write_curves([analysis], tmp_path / "m.csv").read_text().splitlines()
    header = lines[0].split(",")
    assert header[0] == "t"
    column = header.index("gamma_headings")
    values = [float(line.split(",")[column]) for line in lines[1:]]
    np.testing.assert_array_equal(values, analysis.curves["gamma_headings"])
    assert any(line.split(",")[header.index("gamma_motion")] == "" for line in lines[1:])


def test_the_summary_has_units_estimators_and_no_nan(tmp_path):
    analysis = analysis_of("stopped", duration=30.0)
    text = write_summary([analysis], None, tmp_path / "s.json").read_text()
    summary = json.loads(text, parse_constant=lambda word: pytest.fail(word))
    assert summary["numbers"]["gamma_motion"]["value"] is None
    assert summary["numbers"]["speed"]["unit"] == "m/s"
    assert "11 samples" in summary["estimators"]["savitzky_golay"]
    assert summary["options"]["radius"] == 100.0


def test_latex_escapes_names():
    table = latex_table([analysis_of(name="a_b & 50% $x$ \\input{secret}")])
    assert r"a\_b \& 50\,\% \$x\$ \textbackslash{}input\{secret\}" in table
    assert table.count(r"\\") >= 10


def test_latex_writes_exponents_and_signs_as_mathematics():
    analysis = analysis_of()
    tiny = {"speed": -7.61e-10, "smallest_distance": 1e-9}
    numbers = {
        key: dataclasses.replace(number, value=tiny.get(key, number.value))
        for key, number in analysis.numbers.items()
    }
    table = latex_table([dataclasses.replace(analysis, numbers=numbers)])
    assert r"mean speed & $-7.61\cdot10^{-10}$ m/s \\" in table
    assert "two robots & $<$ 0.01 mm" in table
    assert not set("^·−<") & set(re.sub(r"\$.*?\$", "", table))


def test_the_whole_report_lies_in_its_folder(tmp_path, analysis):
    written = write_report([analysis], tmp_path / "deep" / "report", latex=True)
    figures = ("snapshots", "alignment", "distances", "motion")
    assert {path.name for path in written} == {
        "report.html",
        "metrics.csv",
        "summary.json",
        "table.tex",
        "parallel_0.1.analysis.npz",
        *(f"{figure}.{kind}" for figure in figures for kind in ("png", "pdf")),
    }
    assert all(path.stat().st_size > 500 for path in written)
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == set(written)


def test_a_second_report_leaves_nothing_of_the_first_and_all_that_is_the_users(tmp_path, analysis):
    named = dataclasses.replace(analysis.recording, name="other")
    other = dataclasses.replace(analysis, recording=named)
    write_report([analysis, other], tmp_path, latex=True)
    for name in ("notes.txt", "mine.analysis.npz", "figures/mine.png"):
        (tmp_path / name).write_text("mine")
    write_report([analysis], tmp_path, figures=False)
    assert {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")} == {
        "report.html", "metrics.csv", "summary.json", "parallel_0.1.analysis.npz",
        "notes.txt", "mine.analysis.npz", "figures/mine.png",
    }  # fmt: skip


@pytest.mark.parametrize("listed", [["notes.txt"], ["../kept.analysis.npz"], [1], "x", None])
def test_no_list_makes_a_report_remove_what_is_not_a_reports(tmp_path, analysis, listed):
    (tmp_path / "kept.analysis.npz").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    (out / "summary.json").write_text(json.dumps({"files": listed}))
    write_report([analysis], out, figures=False)
    assert (out / "notes.txt").exists()
    assert (tmp_path / "kept.analysis.npz").exists()


def test_a_folder_that_cannot_be_written(tmp_path, analysis):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        write_report([analysis], tmp_path / "file")
    with pytest.raises(OutputError):
        write_page([analysis], tmp_path / "file" / "page.html")


def test_one_page_counts_robots_in_one_way():
    flock = known_flock("parallel", 0.1, duration=10.0)
    poses = flock.recording.poses.copy()
    poses[200:260, :, 2] = np.nan
    analysis = analyse(dataclasses.replace(flock.recording, poses=poses), radius=flock.radius)
    pair = next(event.robots for event in analysis.events if len(event.robots) == 2)
    page = render([analysis])
    assert f"<td>{pair[0]} and {pair[1]}</td>" in page
    assert '<tr><th scope="row">2</th>' in page[page.index('id="h-left-out"') :]
    assert "robot 2, " in page


def test_no_two_landmarks_have_one_name():
    template = resources.files("posflock_robotarium.report") / "assets" / "report.html.j2"
    marked = re.findall(r"<(?:section|\w+[^>]*role=\"region\")[^>]*", template.read_text("utf-8"))
    names = [re.search(r'aria-label(?:ledby)?="([^"]+)"', tag)[1] for tag in marked]
    twice = {name for name in names if names.count(name) > 1}
    assert twice <= {"h-numbers"}  # of one run, or of several: never both
