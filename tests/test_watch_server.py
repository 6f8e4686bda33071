"""Who may talk to the live page's server, and what it answers: by the library's own test client."""

import json
from pathlib import Path

import pytest

pytest.importorskip("starlette")
pytest.importorskip("httpx2")

from starlette.testclient import TestClient, WebSocketDenialResponse
from starlette.websockets import WebSocketDisconnect

from posflock_robotarium.watch.guard import refusal
from posflock_robotarium.watch.script import WatchJob
from posflock_robotarium.watch.server import application
from posflock_robotarium.watch.settings import Settings
from posflock_robotarium.watch.show import Show, Viewer
from rps_compat.profiles import load_profile

WORD = "a-word-that-nobody-knows"
HOST = "127.0.0.1:8000"


@pytest.fixture
def show(tmp_path):
    job = WatchJob(
        Path("some script.py"), 2, {name: load_profile(name) for name in ("ideal", "harsh")}
    )
    return Show(job, Settings(), tmp_path)


@pytest.fixture
def client(show):
    return TestClient(application(show, WORD), base_url=f"http://{HOST}")


@pytest.mark.parametrize(
    ("path", "host", "origin", "websocket", "refused"),
    [
        (f"/{WORD}/", "127.0.0.1:8000", None, False, None),
        (f"/{WORD}/", "localhost:9000", None, False, None),
        (f"/{WORD}/watch.js", "[::1]:8000", None, False, None),
        (f"/{WORD}/live", HOST, f"http://{HOST}", True, None),
        (f"/{WORD}/live", "localhost:9000", "http://localhost:9000", True, None),
        ("/", HOST, None, False, "whole address"),
        ("/other/", HOST, None, False, "whole address"),
        (f"/{WORD}x/", HOST, None, False, "whole address"),
        (f"/{WORD[:-1]}/", HOST, None, False, "whole address"),
        ("/é/", HOST, None, False, "whole address"),
        (f"/{WORD}/", "attacker.example:8000", None, False, "this machine alone"),
        (f"/{WORD}/", "127.0.0.1.attacker.example", None, False, "this machine alone"),
        (f"/{WORD}/", "localhost:8000@attacker.example", None, False, "this machine alone"),
        (f"/{WORD}/", "", None, False, "this machine alone"),
        (f"/{WORD}/live", HOST, None, True, "only a page of this server"),
        (f"/{WORD}/live", HOST, "null", True, "only a page of this server"),
        (f"/{WORD}/live", HOST, "https://attacker.example", True, "only a page of this server"),
        (f"/{WORD}/live", HOST, "http://127.0.0.1:8001", True, "only a page of this server"),
        (f"/{WORD}/live", "attacker.example", "http://attacker.example", True, "machine alone"),
    ],
)
def test_who_is_refused_and_why(path, host, origin, websocket, refused):
    headers = {"host": host} | ({} if origin is None else {"origin": origin})
    why = refusal(path, headers, WORD, websocket)
    assert (why is None) if refused is None else (refused in why)


def test_the_page_binds_the_browser_to_this_server(client):
    answer = client.get(f"/{WORD}/")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert f"connect-src 'self' ws://{HOST};" in policy
    assert "unsafe" not in policy
    assert answer.headers["referrer-policy"] == "no-referrer"  # the address holds the word
    for name in ("watch.js", "watch.css"):
        assert f'"{name}"' in answer.text
        assert client.get(f"/{WORD}/{name}").status_code == 200
    assert "<style" not in answer.text


@pytest.mark.parametrize("path", ["/", "/wrong/", f"/{WORD}/../etc", "/%2e%2e/"])
def test_without_the_word_nothing_is_served(client, path):
    assert client.get(path).status_code == 403


def test_a_file_that_is_none_is_not_found(client):
    assert client.get(f"/{WORD}/server.py").status_code == 404


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        (f"/{WORD}/live", {"origin": "https://attacker.example"}),
        (f"/{WORD}/live", {}),
        ("/wrong/live", {"origin": f"http://{HOST}"}),
        (f"/{WORD}/live", {"origin": "http://evil.example", "host": "evil.example"}),
    ],
)
def test_a_websocket_from_elsewhere_is_never_accepted(client, path, headers):
    refused = pytest.raises((WebSocketDisconnect, WebSocketDenialResponse))
    with refused, client.websocket_connect(path, headers={"host": HOST} | headers):
        pass


def received(line, kinds):
    """Read messages until one of these kinds comes; return it."""
    for _ in range(20):
        message = json.loads(line.receive_text())
        if message["kind"] in kinds:
            return message["data"]
    raise AssertionError(f"no {kinds} came")


def test_a_page_is_told_everything_and_may_ask(client, show):
    headers = {"host": HOST, "origin": f"http://{HOST}"}
    with client.websocket_connect(f"/{WORD}/live", headers=headers) as line:
        hello = received(line, {"hello"})
        assert hello["script"] == "some script.py"
        assert hello["profiles"] == ["ideal", "harsh"]
        assert received(line, {"state"})["phase"] == "starting"
        line.send_text('{"do": "profile", "name": "harsh"}')
        assert received(line, {"state"})["settings"]["profile"] == "harsh"
        line.send_text('{"do": "profile", "name": "/etc/passwd"}')
        assert "expected one of ideal, harsh" in received(line, {"refused"})
        line.send_text('{"do": "quit"}')
        assert "do: expected one of" in received(line, {"refused"})
    assert show.settings.profile == "harsh"


def test_a_slow_page_misses_old_pictures_and_nothing_else():
    viewer = Viewer()
    for k in range(200):
        viewer.offer("frame", str(k))
        if k % 50 == 0:
            viewer.offer("state", str(k))
    import asyncio

    found = [json.loads(message) for message in asyncio.run(viewer.messages())]
    assert [m["data"] for m in found if m["kind"] == "state"] == [0, 50, 100, 150]
    assert [m["data"] for m in found if m["kind"] == "frame"] == list(range(140, 200))
