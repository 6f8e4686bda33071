"""Films, other tools' formats, and the commands that make them."""

import dataclasses
import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from posflock_robotarium.alignment.truth import known_flock
from posflock_robotarium.cli import app
from posflock_robotarium.flocking.errors import LogError, OutputError, ParameterError
from posflock_robotarium.flocking.pose_log import PoseLog
from posflock_robotarium.logs.convert import convert
from posflock_robotarium.report import analyse, read
from posflock_robotarium.report.video import find_ffmpeg, write_video
from posflock_robotarium.report.words import number_text


@pytest.fixture(scope="module")
def recording():
    flock = known_flock("rotating", 0.1, duration=4.0)
    samples, _, robots = flock.recording.poses.shape
    command = np.zeros((samples, 2, robots))
    command[:, 0] = 0.1
    return dataclasses.replace(flock.recording, commands=command)


@pytest.fixture
def log(tmp_path, recording):
    """The same run as our own pose log."""
    path = tmp_path / "ring"
    parameters = {"neighbour_radius": 0.72, "api_generation": 2, "seed": 1}
    with PoseLog(path, recording.robots, len(recording.t), parameters) as writer:
        for k, t in enumerate(recording.t):
            writer.append(t, recording.poses[k], recording.commands[k], status="optimal")
    return path.with_suffix(".npy")


@pytest.mark.parametrize("ending", ["mat", "csv", "npz"])
def test_what_is_converted_is_read_back_to_the_last_bit(tmp_path, recording, ending):
    again = read(convert(recording, tmp_path / f"run.{ending}"))
    np.testing.assert_array_equal(again.poses, recording.poses)
    np.testing.assert_array_equal(again.t, recording.t)
    if ending != "csv":
        np.testing.assert_array_equal(again.commands, recording.commands)


@pytest.mark.parametrize("ending", ["mat", "csv", "npz"])
def test_a_converted_log_reports_the_same_without_being_told_more(tmp_path, ending):
    flock = known_flock("rotating", 0.1, duration=4.0).recording
    described = {
        "neighbour_radius": 0.72,
        "time_step": 0.033,
        "arena": [-1.0, 1.0, -0.9, 0.9],
        "api_generation": 1,
        "simulated": True,
        "note": 'θ, "quoted" # and\nbroken\u2028',
        "ended": {"how": "interrupted", "reason": "a human"},
    }
    with PoseLog(tmp_path / "run", flock.robots, len(flock.t) + 5, described) as writer:
        for k, t in enumerate(flock.t):
            command = np.full((2, flock.robots), 0.1)
            status = ("trivial", "optimal", "relaxed")[k % 3]
            writer.append(
                t, flock.poses[k], command, status=status, intervention=k * 1e-4, clearance=0.1
            )
        writer.close("interrupted", "a human")
    original = analyse(tmp_path / "run.npy")
    again = analyse(convert(original.recording, tmp_path / f"run.{ending}"))
    assert again.recording.parameters == original.recording.parameters
    assert again.recording.parameters["note"] == described["note"]
    assert again.options == original.options
    assert (again.robot, again.origin) == (original.robot, original.origin)
    if ending != "csv":  # a table of poses: neither commands nor what the certificate did
        assert again.numbers.keys() == original.numbers.keys()
        assert again.verdicts == original.verdicts
    for key, number in again.numbers.items():
        np.testing.assert_equal(number.value, original.numbers[key].value, err_msg=key)


def test_damaged_parameters_are_named(tmp_path, recording):
    described = dataclasses.replace(recording, parameters={"neighbour_radius": 0.72})
    table = convert(described, tmp_path / "run.csv")
    table.write_text(table.read_text().replace("}\n", "\n", 1))
    with pytest.raises(LogError, match="line 1: not readable as JSON"):
        read(table)
    np.savez(
        tmp_path / "run.npz",
        t=recording.t,
        poses=recording.poses,
        posflock_parameters=np.array([0.5, 300.0]),
    )
    with pytest.raises(LogError, match="posflock_parameters: expected bytes"):
        read(tmp_path / "run.npz")


def test_mcap_holds_foxgloves_messages(tmp_path, recording):
    reader = pytest.importorskip("mcap.reader")
    path = convert(recording, tmp_path / "run.mcap")
    with path.open("rb") as file:
        source = reader.make_reader(file)
        schemas = {schema.name: schema for schema in source.get_summary().schemas.values()}
        messages = [
            (schema.name, message.log_time, json.loads(message.data))
            for schema, _, message in source.iter_messages()
        ]
    assert set(schemas) == {"foxglove.PosesInFrame", "foxglove.SceneUpdate", "posflock.Commands"}
    for schema in schemas.values():
        assert schema.encoding == "jsonschema"
        assert json.loads(schema.data)["type"] == "object"
    assert len(messages) == 3 * len(recording.t)
    row = 50
    poses = [m for name, _, m in messages if name == "foxglove.PosesInFrame"][row]
    stamp = poses["timestamp"]["sec"] + 1e-9 * poses["timestamp"]["nsec"]
    assert stamp == pytest.approx(recording.t[row], abs=1e-9)
    third = poses["poses"][3]
    assert third["position"]["x"] == recording.poses[row, 0, 3]
    heading = 2 * np.arctan2(third["orientation"]["z"], third["orientation"]["w"])
    assert np.exp(1j * heading) == pytest.approx(np.exp(1j * recording.poses[row, 2, 3]))
    scene = next(m for name, _, m in messages if name == "foxglove.SceneUpdate")
    assert [entity["id"] for entity in scene["entities"]][:2] == ["robot 1", "robot 2"]


def test_messages_are_what_their_schemas_say(tmp_path, recording):
    """Every property of a message is one of its schema's, and of the type that it says."""
    reader = pytest.importorskip("mcap.reader")
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int}

    def check(value, schema, where):
        if "properties" in schema:
            assert set(value) <= set(schema["properties"]), where
            for key, item in value.items():
                check(item, schema["properties"][key], f"{where}.{key}")
        elif schema.get("type") == "array":
            for item in value:
                check(item, schema["items"], where)
        elif schema["type"] == "number":
            assert isinstance(value, (int, float)), where
        assert isinstance(value, kinds.get(schema.get("type"), object)), where

    with convert(recording, tmp_path / "run.mcap").open("rb") as file:
        for schema, _, message in reader.make_reader(file).iter_messages(end_time=10**8):
            check(json.loads(message.data), json.loads(schema.data), schema.name)


def test_conversion_refuses_what_it_cannot_write(tmp_path, recording):
    with pytest.raises(ParameterError, match="mat, csv, npz, mcap"):
        convert(recording, tmp_path / "run.xlsx")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        convert(recording, tmp_path / "file" / "run.csv")


def blue_share(picture):
    """Share of pixels in the robots' colour."""
    pixels = np.asarray(picture.convert("RGB")).astype(int)
    return float((np.abs(pixels - [0, 114, 178]).max(axis=-1) < 40).mean())


def test_a_gif_shows_every_robot_moving(tmp_path, recording):
    told = []
    path = write_video(
        recording, tmp_path / "run.gif", fps=5, progress=lambda a, b: told.append((a, b))
    )
    with Image.open(path) as film:
        assert film.n_frames == 20
        assert film.info["duration"] == 200
        first = film.convert("RGB")
        film.seek(19)
        last = film.convert("RGB")
        # Ten robots of 11 by 10 cm, less arrowheads, in a picture of about 3.4 by 2.3 m.
        assert 0.006 < blue_share(last) < 0.02
        assert (np.asarray(first) != np.asarray(last)).any()
    assert told[-1] == (20, 20)


def test_an_mp4_has_as_many_frames_as_it_should(tmp_path, recording):
    try:
        ffmpeg = find_ffmpeg()
    except OutputError as error:
        pytest.skip(str(error))
    path = write_video(recording, tmp_path / "run.mp4", fps=10, speed=2)
    command = [ffmpeg, "-loglevel", "error", "-i", path, "-f", "image2", tmp_path / "%03d.png"]
    subprocess.run(command, check=True)
    frames = sorted(tmp_path.glob("*.png"))
    assert len(frames) == 20
    with Image.open(frames[10]) as picture:
        assert picture.size == (840, 560)
        assert 0.006 < blue_share(picture) < 0.02


def test_without_ffmpeg_the_error_says_what_to_do(monkeypatch, tmp_path, recording):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(OutputError, match=r"posflock-robotarium\[video\].*write a \.gif"):
        write_video(recording, tmp_path / "run.mp4")


@pytest.mark.parametrize("wrong", [{"fps": 0}, {"fps": -1}, {"speed": 0}, {"speed": float("nan")}])
def test_films_of_no_rate_are_refused(tmp_path, recording, wrong):
    with pytest.raises(ParameterError):
        write_video(recording, tmp_path / "run.gif", **wrong)


def test_films_end_in_a_known_name(tmp_path, recording):
    with pytest.raises(ParameterError, match=r"\.mp4 or \.gif"):
        write_video(recording, tmp_path / "run.avi")
    with pytest.raises(ParameterError, match="raise --speed"):
        write_video(recording, tmp_path / "run.gif", speed=1e-4)


def posflock(*words):
    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def test_the_report_command_writes_its_folder(log, tmp_path):
    out = tmp_path / "out"
    result = posflock("report", log, "-o", out, "--no-figures", "--latex")
    assert result.exit_code == 0
    assert "Did the flock align? No." in result.output
    assert {path.name for path in out.iterdir()} == {
        "report.html",
        "metrics.csv",
        "summary.json",
        "table.tex",
        "ring.analysis.npz",
    }


def test_what_cannot_be_read_is_one_line_and_exit_code_2(tmp_path):
    command = [sys.executable, "-m", "posflock_robotarium", "report", tmp_path / "no.npy"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == f"posflock: {tmp_path / 'no.npy'}: no such file\n"
    assert not list(tmp_path.iterdir())


def test_the_report_command_prints_json(log, tmp_path):
    result = posflock("report", log, "-o", tmp_path / "out", "--no-figures", "--json")
    summary = json.loads(result.stdout)
    expected = analyse(log).numbers["gamma_motion"].value
    assert summary["numbers"]["gamma_motion"]["value"] == expected


def test_a_foreign_array_needs_its_step_and_radius(tmp_path, recording):
    np.save(tmp_path / "poses.npy", recording.poses)
    with pytest.raises(LogError, match="--dt"):
        posflock("report", tmp_path / "poses.npy")
    with pytest.raises(LogError, match="--radius"):
        posflock("report", tmp_path / "poses.npy", "--questions", "flocking", "--dt", "0.033")
    words = ["--dt", "0.033", "--radius", "0.72", "--no-figures", "-o", tmp_path / "out"]
    assert posflock("report", tmp_path / "poses.npy", *words).exit_code == 0


def test_runs_compared_from_logs_and_saved_analyses(log, tmp_path):
    saved = analyse(log).save(tmp_path / "before.analysis.npz")
    result = posflock("compare", log, saved, "--labels", "simulation,testbed", "-o", tmp_path / "c")
    assert result.exit_code == 0
    assert "testbed − simulation" in result.output
    line = next(line for line in result.output.splitlines() if line.startswith("γ from motion"))
    assert line.split()[-1] == "0.000"
    assert (tmp_path / "c" / "report.html").is_file()
    comparison = json.loads(posflock("compare", log, saved, "--json").stdout)
    assert comparison["numbers"]["robots"]["values"] == [10, 10]


def test_parts_of_one_run_are_joined(tmp_path, recording):
    half = len(recording.t) // 2
    for name, part in (("a", slice(0, half)), ("b", slice(half, None))):
        np.savez(tmp_path / f"{name}.npz", t=recording.t[part], poses=recording.poses[part])
    words = ["--join", "--radius", "0.72", "--no-figures", "--json", "-o", tmp_path / "out"]
    summary = json.loads(posflock("report", tmp_path / "a.npz", tmp_path / "b.npz", *words).stdout)
    assert summary["numbers"]["samples"]["value"] == len(recording.t)


def test_replay_and_convert_commands(log, tmp_path):
    result = posflock("replay", log, "--video", tmp_path / "run.gif", "--fps", "2")
    assert "wrote" in result.output
    assert (tmp_path / "run.gif").stat().st_size > 1000
    posflock("convert", log, "--to", "csv", "-o", tmp_path / "run.csv")
    assert read(tmp_path / "run.csv").robots == 10
    with pytest.raises(ParameterError, match="none of npy, mat, csv"):
        posflock("convert", log, "--to", "doc")


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.99991234, "", "0.999912"),
        (0.123456, "m/s", "0.123 m/s"),
        (0.0004871, "m", "0.487 mm"),
        (float("nan"), "m", "–"),
        (1.0, "share", "100.0 %"),
        (np.pi / 2, "rad", "1.57 rad (90°)"),
        (-0.25, "m", "−0.250 m"),
        (3, "", "3"),
        (1234567.8, "", "1.23·10⁶"),
        (-7.61e-10, "m/s", "−7.61·10⁻¹⁰ m/s"),
        (7.61e-10, "m", "< 0.01 mm"),
        (float("inf"), "", "∞"),
    ],
)
def test_numbers_as_people_read_them(value, unit, text):
    assert number_text(value, unit) == text


def test_damaged_rows_can_be_left_out_by_every_command(tmp_path, recording):
    poses = recording.poses.copy()
    poses[5:8, 0, 1] = np.nan
    np.savez(tmp_path / "run.npz", t=recording.t, poses=poses)
    posflock("convert", tmp_path / "run.npz", "--to", "csv")
    assert not read(tmp_path / "run.csv").seen[5:8, 1].any()
    posflock("convert", tmp_path / "run.npz", "--to", "csv", "--drop-damaged")
    assert len(read(tmp_path / "run.csv").t) == len(recording.t) - 3
    words = ["--radius", "0.72", "--drop-damaged"]
    posflock("compare", tmp_path / "run.npz", tmp_path / "run.csv", *words)
