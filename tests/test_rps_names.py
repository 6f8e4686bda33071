"""Every published name of the utilities is there, with its signature, and costs little."""

import importlib
import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rps_compat
from rps_compat import deviations
from rps_compat.deferred import Deferred, MissingExtraError

PUBLISHED = json.loads(
    (Path(__file__).parent / "golden" / "utilities_signatures.json").read_text(encoding="utf-8")
)
MODULES = [(generation, name) for generation, names in PUBLISHED.items() for name in names]
FUNCTIONS = [
    (generation, module, name, signatures[0], signatures[1:])
    for generation, modules in PUBLISHED.items()
    for module, published in modules.items()
    for name, signatures in published["functions"].items()
]


def module_of(generation, name):
    return importlib.import_module(f"rps_compat.{generation}.utilities.{name}")


def parameters(function):
    """As in the published record, without what annotations look like."""
    described = []
    for parameter in inspect.signature(function).parameters.values():
        default = "" if parameter.default is parameter.empty else f"={parameter.default!r}"
        described.append(parameter.name + default)
    return f"({', '.join(described)})"


@pytest.mark.parametrize(("generation", "name"), MODULES)
def test_star_imports_bring_what_scripts_take_for_granted(generation, name):
    namespace = {}
    exec(f"from {module_of(generation, name).__name__} import *", namespace)
    published = PUBLISHED[generation][name]
    public = [f for f in published["functions"] if not f.startswith("_")]
    assert set(published["also"]) | set(public) <= set(namespace)


@pytest.mark.parametrize(("generation", "module", "name", "signature", "returned"), FUNCTIONS)
def test_signatures_are_the_published_ones(generation, module, name, signature, returned):
    function = getattr(module_of(generation, module), name)
    if ": " not in signature:
        assert parameters(function) == signature
    else:  # annotated; of these, what counts is the names
        published = [part.partition(":")[0] for part in signature.strip("(").split(", ")]
        assert set(inspect.signature(function).parameters) <= set(published)
    if returned:
        made = function()
        for inner, (inner_name, inner_signature) in zip(
            made if isinstance(made, tuple) else (made,), returned, strict=True
        ):
            assert inner.__name__ == inner_name
            assert parameters(inner) == inner_signature


def table_of_generation_2():
    """Return what the page shows: of each module its calls, with the calls of what they make."""
    page = (Path(__file__).parents[1] / "docs/reference/utilities.md").read_text(encoding="utf-8")
    section = page.split("## Every name of generation 2\n")[1].split("\n## ")[0]
    found = {}
    for header, *rows in (t.splitlines() for t in section.split("\n\n") if t.startswith("|")):
        shown = found[header.split("`")[1]] = {}
        for row in rows[1:]:
            call, *cells = row.strip("|").split(" | ")
            made = cells[0] if "makes" in header else ""
            shown[call.strip(" `").replace("π", repr(np.pi))] = re.findall("`(.*?)`", made)
    return found


def test_the_table_of_generation_2_shows_every_name_as_it_is():
    expected = {}
    for path in (Path(rps_compat.__file__).parent / "v2/utilities").glob("[!_]*.py"):
        module, shown = module_of("v2", path.stem), expected.setdefault(path.stem, {})
        for name, function in inspect.getmembers(module, inspect.isfunction):
            if function.__module__ == module.__name__ and name[0] != "_":
                made = function() if name.startswith("create_") else ()
                made = made if isinstance(made, tuple) else (made,)
                inner = [f"{one.__name__}{parameters(one)}" for one in made]
                shown[f"{name}{parameters(function)}"] = inner
    assert table_of_generation_2() == expected


@pytest.mark.parametrize("generation", ["v1", "v2"])
def test_importing_the_utilities_imports_neither_pyplot_nor_solvers(generation):
    names = ", ".join(f"rps_compat.{generation}.utilities.{m}" for m in PUBLISHED[generation])
    program = f"import sys, {names}; print(*sorted(sys.modules))"
    loaded = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.split()
    heavy = {"matplotlib.pyplot", "cvxopt", "cvxpy", "osqp", "clarabel"}
    assert not heavy & set(loaded)


def test_plt_of_a_star_import_is_pyplot_once_it_is_used():
    misc = module_of("v1", "misc")
    figure = misc.plt.figure()
    assert figure is importlib.import_module("matplotlib.pyplot").gcf()


def test_cvxopt_names_are_cvxopts_own_once_they_are_used():
    cvxopt = pytest.importorskip("cvxopt")
    certificates = module_of("v1", "barrier_certificates")
    identity = certificates.matrix([[1.0, 0.0], [0.0, 1.0]])
    assert isinstance(identity, cvxopt.matrix)
    assert isinstance(identity, certificates.matrix)
    answer = certificates.qp(
        identity, certificates.matrix([-1.0, 0.0]), options={"show_progress": False}
    )
    assert answer["x"][0] == pytest.approx(1.0)


def test_a_missing_package_is_named_with_the_way_to_it():
    absent = Deferred("no-such-package", "no_such_package", "thing")
    with pytest.raises(
        MissingExtraError, match=r"thing belongs to no-such-package, .* pip install"
    ):
        absent(1)


def test_deviations_are_told_for_functions_that_exist():
    for deviation in deviations.DEVIATIONS.values():
        generation = f"v{deviation.generation}"
        robotarium = module_of_robotarium(deviation.generation).Robotarium
        for function in deviation.functions:
            assert (
                any(function in m["functions"] for m in PUBLISHED[generation].values())
                or function == "Robotarium"
                or hasattr(robotarium, function)
            )


def module_of_robotarium(generation):
    return importlib.import_module(f"rps_compat.v{generation}.robotarium")


def test_deviations_switch_back_after_the_block():
    name = "certificates change their input"
    assert not deviations.as_published(name)
    with deviations.all_as_published():
        assert deviations.as_published(name)
        assert not deviations.as_published("wrong shapes")
    assert not deviations.as_published(name)


def test_every_deviation_stands_in_the_documentation():
    docs = Path(__file__).parents[1] / "docs" / "reference"
    pages = (docs / "utilities.md", docs / "api-compatibility.md")  # functions, and the class
    page = "".join(path.read_text(encoding="utf-8") for path in pages)
    for name, deviation in deviations.DEVIATIONS.items():
        assert f"| {name} ({deviation.generation}) |" in page


def test_recorded_cases_that_deviate_are_told_by_deviation():
    told = json.loads(
        (Path(__file__).parent / "golden" / "utilities_deviations.json").read_text(encoding="utf-8")
    )
    for generation, by_deviation in told.items():
        for name, cases in by_deviation.items():
            deviation = deviations.DEVIATIONS[name]
            assert deviation.generation == int(generation[1])
            assert {case.split("/")[1] for case in cases} <= set(deviation.functions)
