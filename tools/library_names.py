"""Compare the tables of library names with the libraries themselves.

    python tools/library_names.py            # builds environments, takes minutes, needs an index

Each environment below has one set of versions. In each, every public name of every public module
is listed; what the testbed's versions lack of older or newer ones, and what newer ones lack of the
testbed's, must stand in `rps_compat.scripts.numpy_names`, `library_names` and `python_names`, and
nothing else may. Run it when a new numpy, scipy, matplotlib or Python appears, with its version
added to `ENVIRONMENTS`, and with ``--golden`` to renew the list that the tests compare with.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from posflock_robotarium.interpreters import find_python
from rps_compat.scripts import library_names, numpy_names, python_names
from rps_compat.scripts.changes import CHANGES, change_of
from rps_compat.scripts.libraries import LIBRARIES, NEWER_MODULES, PYTHON, STANDARD_LIBRARY

GOLDEN = Path(__file__).parents[1] / "tests" / "golden" / "library_names.json"
TESTBED = "testbed"
#: Name → minor version of Python and the libraries' versions; older ones first.
ENVIRONMENTS = {
    "2018": ((3, 6), {"numpy": "1.14.6", "scipy": "1.1.0", "matplotlib": "2.2.5", "pillow": ""}),
    "2019": ((3, 7), {"numpy": "1.17.5", "scipy": "1.3.3", "matplotlib": "3.1.3"}),
    "2020": ((3, 8), {"numpy": "1.19.5", "scipy": "1.5.4", "matplotlib": "3.3.4"}),
    "2021": ((3, 9), {"numpy": "1.21.6", "scipy": "1.7.3", "matplotlib": "3.5.3"}),
    "2022": ((3, 10), {"numpy": "1.24.4", "scipy": "1.9.3", "matplotlib": "3.7.5"}),
    "2023": ((3, 10), {"numpy": "1.26.4", "scipy": "1.11.4", "matplotlib": "3.8.4"}),
    "2024": ((3, 10), {"numpy": "2.0.2", "scipy": "1.13.1", "matplotlib": "3.9.4"}),
    TESTBED: (PYTHON, {name: LIBRARIES[name] for name in ("numpy", "scipy", "matplotlib")}),
    "2025": ((3, 11), {"numpy": "2.3.5", "scipy": "1.16.3", "matplotlib": "3.10.9"}),
    "2026a": ((3, 11), {"numpy": "2.4.6", "scipy": "1.17.1", "matplotlib": "3.11.2"}),
    "2026b": ((3, 12), {"numpy": "2.5.5", "scipy": "1.18.1", "matplotlib": "3.11.2"}),
    "python3.13": ((3, 13), {}),
}
#: Modules whose names scripts use.
MODULES = {
    "numpy": " char ctypeslib exceptions fft lib lib.stride_tricks linalg ma polynomial random rec"
    " strings testing typing",
    "scipy": " cluster cluster.hierarchy cluster.vq constants datasets differentiate fft fftpack"
    " integrate interpolate io io.wavfile linalg misc ndimage odr optimize signal signal.windows"
    " sparse sparse.csgraph sparse.linalg spatial spatial.distance spatial.transform special stats"
    " stats.mstats stats.qmc",
    "matplotlib": " animation artist axes axis cm collections colorbar colors container dates"
    " figure gridspec image legend lines markers mlab patches path pyplot scale style text ticker"
    " transforms tri widgets",
    "mpl_toolkits": "mplot3d axes_grid1 axes_grid axisartist",
}
#: Modules of the standard library whose names are not looked at: platforms' and Python's own.
_APART = frozenset(
    "aifc antigravity cgitb distutils dis encodings fcntl genericpath idlelib lib2to3 modulefinder"  # noqa: SIM905
    " msilib nt ntpath opcode pdb pkgutil posix posixpath pydoc site sre_compile sre_constants"
    " sre_parse sunau symtable test this tkinter tokenize turtledemo webbrowser".split()
)
#: Modules within packages of the standard library that are looked at.
_WITHIN = frozenset(
    "asyncio.exceptions collections.abc concurrent.futures email.utils http.cookiejar"  # noqa: SIM905
    " importlib.abc importlib.metadata importlib.resources importlib.util json.decoder"
    " logging.handlers multiprocessing.pool os.path unittest.mock urllib.parse urllib.request"
    " wsgiref.types xml.etree.ElementTree".split()
)
#: Modules whose constants (names in capitals) depend on how Python was built, and on where.
_PLATFORM = frozenset(
    "errno mmap os select signal socket sqlite3 ssl stat syslog termios token tokenize".split()  # noqa: SIM905
)
#: Names that a module has by accident: what it imports, marks of Python 2, its own helpers.
_BY_ACCIDENT = frozenset(
    "absolute_import division print_function unicode_literals Bytes0 Datetime64 Str0 Uint64"  # noqa: SIM905
    " importlib.metadata.Deprecated importlib.metadata.DeprecatedList"
    " importlib.metadata.DeprecatedNonAbstract importlib.metadata.DeprecatedTuple"
    " importlib.metadata.always_iterable importlib.simple asyncio.async asyncio.compat"
    " asyncio.taskgroups asyncio.test_utils asyncio.timeouts base64.test code.Quitter"
    " dbm.sqlite3 email.feedparser email.parser enum.bin enum.pickle_by_enum_name"
    " enum.pickle_by_global_name enum.global_enum_repr enum.global_flag_repr io.OpenWrapper"
    " keyword.main multiprocessing.semaphore_tracker numpy.lib.math random.main"
    " scipy.cluster.hierarchy.distance scipy.cluster.hierarchy.int_floor"
    " scipy.io.wavfile.SeekEmulatingReader scipy.stats.trapz"
    " sqlite3.Cache sqlite3.Statement typing.CallableMeta typing.TupleMeta typing.TypingMeta"
    " unittest.load_tests unittest.doModuleCleanups uuid.main wsgiref.types xml.etree"
    " matplotlib.style.read_style_directory matplotlib.style.update_nested_dict"
    " matplotlib.style.update_user_library mpl_toolkits.axes_grid numpy.lib.mixins"
    " platform.AndroidVer platform.IOSVersionInfo numpy.lib.stride_tricks.DummyArray"
    " numpy.lib.stride_tricks.broadcast_arrays numpy.lib.stride_tricks.broadcast_shapes"
    " numpy.lib.stride_tricks.broadcast_to unittest.mock.ThreadingMixin tarfile.filemode"
    " http.cookiejar.vals_sorted_by_key zipfile.FastLookup scipy.fft_msg scipy.misc"
    " scipy.show_numpy_config".split()
)
#: Names that a module hands on from elsewhere, and that scripts take from there.
_ALSO = {"matplotlib.pyplot": {"register_cmap"}, "numpy.char": {"slice"}}

PROBE = r"""
import importlib, json, sys, types, warnings
warnings.simplefilter("ignore")
asked = json.loads(sys.stdin.read())
found = {}
for top in asked["standard"]:
    try:
        module = importlib.import_module(top)
    except BaseException:
        continue
    asked["modules"].append(top)
for name in asked["modules"] + ["builtins"]:
    try:
        module = importlib.import_module(name)
    except BaseException:
        continue
    top, listed = name.split(".")[0], getattr(module, "__all__", None)
    names = []
    for entry in set(dir(module)) | set(listed or ()) | set(asked["names"].get(name, ())):
        try:
            value = getattr(module, entry)
        except BaseException:
            continue
        home, kind = getattr(value, "__module__", None), isinstance(value, types.ModuleType)
        if listed and entry in listed:
            its_own = True
        elif name in ("numpy", "numpy.lib", "scipy"):  # whose lists leave out what scripts use
            foreign = isinstance(home, str) and home.split(".")[0] not in (top, "builtins", "numpy")
            its_own = not (foreign or kind)
        elif isinstance(home, str):
            its_own = home in (name, "_" + name) or home.startswith(name + ".")
        else:
            its_own = listed is None and entry.isupper() and len(entry) > 1
        names.append([entry, its_own and not entry.startswith("_")])
    found[name] = dict(names)
print(json.dumps(found))
"""


def probe(python: Path, names: dict[str, list[str]], standard: list[str]) -> dict[str, dict]:
    """List the names of every module that `python` can import: name → whether it is its own."""
    modules = [
        f"{top}.{part}".strip(".")
        for top, parts in MODULES.items()
        for part in ["", *parts.split()]
        if top != "mpl_toolkits" or part
    ]
    modules += [*library_names.GONE_MODULES, *python_names.GONE_MODULES, *NEWER_MODULES]
    modules += [f"numpy.{name}" for name in numpy_names.GONE_MODULES]
    modules += python_names.NEWER_MODULES
    request = {"modules": modules, "names": names, "standard": standard}
    said = subprocess.run(
        [python, "-W", "ignore", "-c", PROBE],
        input=json.dumps(request), capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(said.stdout.splitlines()[-1])


def build(room: Path, name: str) -> Path:
    """Make the environment `name` in `room` and return its interpreter."""
    version, pins = ENVIRONMENTS[name]
    base = find_python(version)
    if base is None:
        raise SystemExit(f"{name} needs Python {version[0]}.{version[1]}, which is not installed")
    if not pins:
        return base
    folder = room / name
    python = folder / "bin" / "python"
    if not python.exists():
        print(f"building {name}: Python {version[0]}.{version[1]}, {pins}", file=sys.stderr)
        wanted = [f"{library}=={v}" if v else library for library, v in pins.items()]
        subprocess.run([base, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *wanted], check=True)
    return python


def differences(room: Path) -> dict[str, str]:
    """Return every name that the testbed and other versions do not share → its kind."""
    standard = [m for m in sorted(STANDARD_LIBRARY) if m not in _APART and m[0] != "_"]
    standard += sorted(_WITHIN)
    pythons = {name: build(room, name) for name in ENVIRONMENTS}
    union: dict[str, set[str]] = {module: set(names) for module, names in _ALSO.items()}
    for python in pythons.values():
        for module, names in probe(python, {}, standard).items():
            union.setdefault(module, set()).update(n for n, own in names.items() if own)
    asked = {module: sorted(names) for module, names in union.items()}
    there = {name: probe(python, asked, standard) for name, python in pythons.items()}
    order, found = list(ENVIRONMENTS), {}
    bed = order.index(TESTBED)
    for module, names in union.items():
        has = {n: module in there[n] for n in order}
        if not has[TESTBED]:
            found[module] = "gone" if any(has[n] for n in order[:bed]) else "newer"
            continue
        for entry in names:
            if {entry, f"{module}.{entry}"} & _BY_ACCIDENT:
                continue
            if module.partition(".")[0] in _PLATFORM and entry.isupper():
                continue
            on = [n for n in order if has[n] and entry in there[n][module]]
            after = [n for n in order[bed + 1 :] if has[n]]
            if TESTBED not in on:
                older = any(order.index(n) < bed for n in on)
                found[f"{module}.{entry}"] = "gone" if older else "newer"
            elif any(n not in on for n in after):
                found[f"{module}.{entry}"] = "later"
    return found


def main() -> None:
    """Print what the tables lack, what they have too much, and what they call otherwise."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--room", type=Path, help="where environments are kept between calls")
    asked.add_argument("--golden", action="store_true", help=f"write {GOLDEN.name}")
    asked.add_argument("--raw", type=Path, help="write what was found as JSON")
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as room:
        found = differences(options.room or Path(room))
    if options.raw:
        options.raw.write_text(json.dumps(found, indent=0, sort_keys=True))
    listed = {path: change.kind.value for path, change in CHANGES.items()}
    newest = f"{max(version for version, _ in ENVIRONMENTS.values())[1] + 1}"
    for path in sorted(found.keys() | listed.keys()):
        change = change_of(path)
        if change is not None and change.since == f"3.{newest}":
            continue  # no environment has that Python yet
        said = None if change is None else change.kind.value
        if found.get(path) != said:
            print(f"{path}: the libraries say {found.get(path)}, the tables {said}")
    if options.golden:
        GOLDEN.write_text(json.dumps(listed, indent=0, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
