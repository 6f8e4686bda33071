"""What was recorded of the published API is answered the same here, or is a listed deviation.

The vectors are replayed twice: as the published simulators answer, defects included, where nearly
nothing may differ; and as we answer, where only functions of a listed deviation may.
"""

import collections
import importlib
import inspect
import itertools
import json

import numpy as np
import pytest
from golden_replay import replay
from golden_vectors import GOLDEN, Vectors

import rps_compat
from rps_compat import deviations

VECTORS = {generation: Vectors(generation) for generation in (1, 2)}


def group_of(case):
    return case["id"].rsplit("/", 1)[0]


GROUPS = collections.defaultdict(list)
for generation, vectors in VECTORS.items():
    for case in vectors.cases:
        if case.get("tag") != "upstream_bug":
            GROUPS[generation, group_of(case)].append(case)

# Cases that answer differently even where everything else is wanted as published.
ALWAYS = {
    "barrier_certificates/create_unicycle_differential_drive_barrier_certificate_with_boundary/091",
    "controllers/create_pose_controller_hybrid/089",
    "barrier_certificates/create_si_barrier_certificate/014",
    "barrier_certificates/create_si_barrier_certificate/018",
    "barrier_certificates/create_si_barrier_certificate_with_boundary/014",
    "barrier_certificates/create_si_barrier_certificate_with_boundary/015",
    "barrier_certificates/create_si_barrier_certificate_with_boundary/017",
    "robotarium/script_constructor/001",  # no robots at all
    "robotarium/script_constructor/004",  # 22 robots, 5 poses
    "robotarium/script_constructor/014",  # poses of two rows
}


@pytest.fixture
def installed(request):
    rps_compat.install(generation=request.param)
    yield request.param
    rps_compat.uninstall()


@pytest.mark.parametrize(
    ("installed", "group"), GROUPS, indirect=["installed"], ids=lambda value: str(value)
)
def test_recorded_answers(installed, group):
    vectors, cases = VECTORS[installed], GROUPS[installed, group]
    with deviations.all_as_published():
        differing = {case["id"]: why for case in cases if (why := replay(case, vectors))}
    unexpected = {name: why for name, why in differing.items() if name not in ALWAYS}
    assert not unexpected


@pytest.mark.parametrize(
    ("installed", "group"), GROUPS, indirect=["installed"], ids=lambda value: str(value)
)
def test_only_listed_functions_deviate(installed, group):
    vectors, cases = VECTORS[installed], GROUPS[installed, group]
    differing = [case["id"] for case in cases if replay(case, vectors)]
    listed = {
        function
        for deviation in deviations.DEVIATIONS.values()
        if deviation.generation == installed
        for function in deviation.functions
    }
    function = group.split("/")[1].replace("script_constructor", "Robotarium")
    assert not differing or function in listed


def turned(to, headings, rates):
    """A case as if recorded: velocities along +x for robots with `headings`, and turn rates."""
    name = "create_si_to_uni_dynamics"
    robots = len(headings)
    velocities, poses = np.zeros((2, robots)), np.zeros((3, robots))
    velocities[0], poses[2] = 0.1, headings
    answer = np.array([0.1 * np.cos(headings), rates])
    arrays = {"velocities": velocities, "poses": poses, "answer": answer}
    to.arrays.update(arrays)
    call = {"args": ["@velocities", "@poses"], "kwargs": {}, "returns": ["@answer"]}
    return {
        "id": name, "kind": "function", "module": "rps.utilities.transformations",
        "factory": name, "factory_args": [], "factory_kwargs": {}, "returned_index": None,
        "calls": [call], "rtol": 1e-9, "atol": 1e-12,
    }  # fmt: skip


@pytest.mark.parametrize("installed", [1, 2], indirect=True)
def test_either_side_of_a_jump_is_right_and_a_wrong_side_is_not(installed):
    vectors = Vectors(installed)
    at_the_jump, off_it = np.array([np.pi, -np.pi, np.pi]), np.array([3.0, -3.0, np.pi - 1e-6])
    for signs in itertools.product((1.0, -1.0), repeat=3):
        assert replay(turned(vectors, at_the_jump, 2 * np.pi * np.array(signs)), vectors) == ""
        right = signs == (-1.0, 1.0, -1.0)
        rates = 2 * np.abs(off_it) * signs
        assert (replay(turned(vectors, off_it, rates), vectors) == "") is right
    # At the jump, too, a robot turns fully to one side, and nothing between will do.
    for rates in ([0.0, 1.0, 1.0], [1.0, 1.0, 0.999], [1.0, 1.0, -1.001]):
        assert replay(turned(vectors, at_the_jump, 2 * np.pi * np.array(rates)), vectors)
    # Nor does a jump of one robot excuse another.
    assert replay(turned(vectors, np.array([np.pi, 3.0]), [2 * np.pi, 6.0]), vectors)


@pytest.mark.parametrize("installed", [1, 2], indirect=True)
def test_every_published_name_is_there(installed):
    signatures = json.loads((GOLDEN / f"v{installed}_signatures.json").read_text())
    for name, published in signatures.items():
        module = importlib.import_module(name)
        starred = {}
        exec(f"from {name} import *", starred)
        for also in (
            *published["also_exported"],
            *published["imported_modules"],
            *published["functions"],
            *published["classes"],
        ):
            assert hasattr(module, also), f"{name} has no {also}"
            if not also.startswith("_"):
                assert also in starred, f"from {name} import * does not give {also}"


@pytest.mark.parametrize("installed", [1, 2], indirect=True)
def test_every_published_parameter_has_its_place_and_default(installed):
    signatures = json.loads((GOLDEN / f"v{installed}_signatures.json").read_text())
    for name, published in signatures.items():
        module = importlib.import_module(name)
        for class_name, recorded in published["classes"].items():
            ours = getattr(module, class_name)
            for method, signature in recorded["methods"].items():
                if method in ("__eq__", "__repr__"):
                    continue
                parameters = inspect.signature(getattr(ours, method)).parameters
                wanted = [p for p in signature["parameters"] if p["name"] != "self"]
                found = [p for p in parameters.values() if p.name != "self"]
                if (installed, method) == (1, "__init__"):  # the last release has two more
                    late = [p for p in found if p.name in ("use_distance_sensors", "obstacles")]
                    assert found[len(wanted) :] == late
                    found = found[: len(wanted)]
                assert [p.name for p in found] == [p["name"] for p in wanted], (class_name, method)
                for our, their in zip(found, wanted, strict=True):
                    assert our.kind.name == their["kind"]
                    if "default" in their:
                        assert repr(our.default).replace(", dtype=float64", "") == their[
                            "default"
                        ].replace(", dtype=float64", ""), (class_name, method, our.name)
