"""A flock may be given another law between two steps, and certificates be heard: from outside."""

from dataclasses import replace

import numpy as np
import pytest

from barrier_certificates.hearing import heard_by
from barrier_certificates.single_integrator import SingleIntegratorCertificate
from posflock_robotarium.flocking.attendance import attended_by
from posflock_robotarium.flocking.errors import ParameterError
from posflock_robotarium.flocking.flock import Flock
from posflock_robotarium.flocking.law import PAPER_EXPERIMENT
from posflock_robotarium.flocking.paper_models import Model
from posflock_robotarium.flocking.placement import random_poses

STEP = 0.033
WIDER = replace(PAPER_EXPERIMENT, radius=1.2, persistence=0.5)


@pytest.fixture
def poses():
    return random_poses(5, np.random.default_rng(3), side=1.0)


def commands(flock, poses, steps=40):
    told = []
    for _ in range(steps):
        speed, turn = flock.step(poses).command
        told.append([speed, turn])
        ahead = np.array([np.cos(poses[2]), np.sin(poses[2])])
        poses = poses + STEP * np.array([*(speed * ahead), turn])
    return np.array(told)


@pytest.mark.parametrize("model", Model)
def test_a_flock_retuned_before_its_first_step_is_one_made_so(model, poses):
    retuned = Flock()
    retuned.retune(WIDER, model)
    np.testing.assert_array_equal(
        commands(retuned, poses), commands(Flock(WIDER, model=model), poses)
    )


def test_the_models_differ_and_each_log_says_which(poses):
    found = {model: commands(Flock(model=model), poses, 400) for model in Model}
    assert not np.allclose(found[Model.VELOCITY], found[Model.POSITION])
    assert not np.allclose(found[Model.POSITION], found[Model.POSITION_NO_THRESHOLD])
    assert Flock(model=Model.VELOCITY).parameters()["model"] == "velocity"
    assert Flock().parameters()["model"] == "position"


def test_a_law_changed_in_flight_holds_from_the_next_step_on(poses):
    plain, changed = Flock(), Flock()
    first, second = commands(plain, poses, 20), commands(changed, poses, 20)
    np.testing.assert_array_equal(first, second)
    links = changed.links
    changed.retune(WIDER, Model.POSITION)
    np.testing.assert_array_equal(changed.links, links)
    assert not np.array_equal(commands(plain, poses, 1), commands(changed, poses, 1))
    (kept,) = changed.retuned
    assert kept["time"] == pytest.approx(20 * STEP)
    assert kept["law"]["radius"] == 1.2


def test_a_law_that_cannot_be_followed_changes_nothing(poses):
    flock = Flock()
    with pytest.raises(ParameterError, match="less than the radius"):
        flock.retune(replace(PAPER_EXPERIMENT, radius=0.1), Model.POSITION)
    assert flock.law is PAPER_EXPERIMENT
    assert flock.retuned == []
    np.testing.assert_array_equal(commands(flock, poses), commands(Flock(), poses))


def test_who_attends_is_shown_each_flock_when_it_is_made_and_before_each_step(poses):
    shown = []
    with attended_by(shown.append):
        flock = Flock()
        commands(flock, poses, 3)
    Flock()
    assert shown == [flock] * 4


def test_who_hears_certificates_hears_every_answer_and_no_other():
    heard = []
    certificate = SingleIntegratorCertificate(safety_radius=0.2, barrier_gain=10.0)
    asked = np.array([[0.1, -0.1], [0.0, 0.0]])
    near = np.array([[-0.11, 0.11], [0.0, 0.0]])
    with heard_by(heard.append):
        safe, info = certificate(asked, near)
    certificate(asked, near)
    (answer,) = heard
    assert answer.info is info
    np.testing.assert_array_equal(answer.velocity, safe)
    np.testing.assert_array_equal(answer.desired, asked)
    assert info.active == ("robots 0 and 1",)
