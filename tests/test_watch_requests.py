"""What a page may ask: read in one place, and refused whatever is not exactly that."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.watch.pace import WatchPace
from posflock_robotarium.watch.requests import (
    Again,
    Go,
    PageRequest,
    Pause,
    RequestError,
    Retune,
    Speed,
    Step,
    Stop,
    UseProfile,
    read_request,
)
from posflock_robotarium.watch.settings import Settings

GOOD = [
    Pause(), Go(), Step(3), Speed(None), Speed(0.25), UseProfile("harsh"), Again(), Stop(),
    Retune(radius=1.0), Retune(model=Model.VELOCITY), Retune(0.0, 0.5, 2.0, Model.POSITION),
]  # fmt: skip


@pytest.mark.parametrize("request_", GOOD, ids=lambda request: request.text())
def test_a_request_is_read_as_it_was_written(request_):
    assert read_request(request_.text()) == request_


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("go", "as JSON"),
        ("[]", "JSON object"),
        ("[" * 900, "as JSON"),
        ("{}", "do: expected one of pause"),
        ('{"do": ["go"]}', "do: expected one of pause"),
        ('{"do": "exec", "code": "1"}', "got 'exec'"),
        ('{"do": "go", "fast": true}', "go: does not know 'fast'; it takes nothing"),
        ('{"do": "step", "steps": 1.5}', "whole number from 1 to 1000"),
        ('{"do": "step", "steps": true}', "whole number"),
        ('{"do": "step", "steps": 100000}', "whole number"),
        ('{"do": "speed", "factor": 3}', "expected one of 0.25"),
        ('{"do": "speed", "factor": true}', "expected one of 0.25"),
        ('{"do": "profile"}', "profile: "),
        ('{"do": "profile", "name": 1}', "a profile's name"),
        ('{"do": "law", "radius": 0.1}', "from 0.2 to 2 m"),
        ('{"do": "law", "radius": NaN}', "from 0.2 to 2 m"),
        ('{"do": "law", "persistence": "0.2"}', "from 0.01 to 1 1/s"),
        ('{"do": "law", "model": "boids"}', "velocity, position, position-no-threshold"),
        (json.dumps({"do": "profile", "name": "x" * 1000}), "at most 1000"),
    ],
)
def test_what_no_page_may_ask_is_refused_with_what_was_expected(text, said):
    with pytest.raises(RequestError, match=said):
        read_request(text)


JSON = st.none() | st.booleans() | st.floats() | st.integers(-2, 2000) | st.text(max_size=8)
JSON |= st.lists(JSON, max_size=2)
NAMES = st.sampled_from(["do", "steps", "factor", "name", "radius", "model", "persistence"])
WORDS = st.sampled_from([request.do for request in GOOD])


@given(st.dictionaries(NAMES, JSON | WORDS) | JSON)
def test_any_json_is_a_request_or_refused(data):
    try:
        request = read_request(json.dumps(data))
    except RequestError:
        return
    assert isinstance(request, PageRequest)
    assert read_request(request.text()) == request


def test_settings_follow_requests_and_pass_through_json():
    settings = Settings()
    for request in (Speed(4.0), Retune(radius=1.0), Retune(model=Model.VELOCITY), Step()):
        settings = settings.after(request)
    assert settings == Settings(4.0, True, "ideal", Retune(radius=1.0, model=Model.VELOCITY))
    assert Settings.from_dict(json.loads(json.dumps(settings.as_dict()))) == settings
    assert settings.after(Again()) == settings


def test_a_pace_waits_for_the_slot_of_a_step_and_catches_nothing_up():
    pace = WatchPace(2.0)
    assert pace.wait(10.0) == 0.0
    pace.stepped(0.0, 0.04, 10.0)
    assert pace.wait(10.0) == pytest.approx(0.02)
    pace.stepped(0.04, 0.04, 10.021)  # a little late: the next slot stays where it was
    assert pace.wait(10.021) == pytest.approx(0.019)
    pace.stepped(0.08, 0.04, 20.0)  # very late
    assert pace.wait(20.0) == 0.0
    pace.run_at(None)
    pace.stepped(0.12, 0.04, 20.0)
    assert pace.wait(20.0) == 0.0


def test_a_held_pace_waits_for_ever_but_for_the_steps_it_may_do():
    pace = WatchPace(None, paused=True)
    assert pace.wait(0.0) == float("inf")
    pace.step(2)
    for k in range(2):
        assert pace.wait(float(k)) == 0.0
        pace.stepped(0.033 * k, 0.033, float(k))
    assert pace.wait(2.0) == float("inf")
    pace.go()
    assert pace.wait(2.0) == 0.0


def test_the_speed_that_is_reached_is_measured():
    pace = WatchPace(None)
    for k in range(100):
        pace.stepped(0.033 * k, 0.033, 0.011 * k)
    assert pace.reached == pytest.approx(3.0)
    pace.pause()
    assert pace.reached is None
