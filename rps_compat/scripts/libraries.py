"""What is installed on the testbed: Python, its standard library, and the libraries beside it.

Read in the Robotarium's published list of libraries.  Everything that asks whether an import works
there, or what an uploaded file would hide, asks here.
"""

from __future__ import annotations

import sys

#: The version of Python that runs submissions.
PYTHON = (3, 10)

#: Distributions that are installed, with the published versions ("" where none was published).
LIBRARIES = {
    "numpy": "2.2.6",
    "scipy": "1.15.3",
    "matplotlib": "3.10.8",
    "cvxopt": "1.3.2",
    "scikit-learn": "1.7.2",
    "networkx": "3.4.2",
    "shapely": "2.1.2",
    "torch": "2.10.0",
    "opencv-python": "4.13.0.90",
    "pillow": "12.1.0",
    "sympy": "1.14.0",
    "PyYAML": "",
    "requests": "",
    "Jinja2": "",
    "gym": "0.26.2",
    "gtsam": "",
}

#: What a script imports → the distribution that brings it.
IMPORT_NAMES = {
    "numpy": "numpy",
    "scipy": "scipy",
    "matplotlib": "matplotlib",
    "mpl_toolkits": "matplotlib",
    "pylab": "matplotlib",
    "cvxopt": "cvxopt",
    "sklearn": "scikit-learn",
    "networkx": "networkx",
    "shapely": "shapely",
    "torch": "torch",
    "cv2": "opencv-python",
    "PIL": "pillow",
    "sympy": "sympy",
    "yaml": "PyYAML",
    "requests": "requests",
    "jinja2": "Jinja2",
    "gym": "gym",
    "gtsam": "gtsam",
    # What those bring along.
    "dateutil": "matplotlib",
    "packaging": "matplotlib",
    "cycler": "matplotlib",
    "kiwisolver": "matplotlib",
    "contourpy": "matplotlib",
    "fontTools": "matplotlib",
    "pyparsing": "matplotlib",
    "six": "matplotlib",
    "joblib": "scikit-learn",
    "threadpoolctl": "scikit-learn",
    "mpmath": "sympy",
    "markupsafe": "Jinja2",
    "urllib3": "requests",
    "idna": "requests",
    "certifi": "requests",
    "charset_normalizer": "requests",
    "cloudpickle": "gym",
    "gym_notices": "gym",
    "filelock": "torch",
    "fsspec": "torch",
    "typing_extensions": "torch",
}

#: Known not to be there, with what to use instead.
ABSENT = {
    "osqp": "solve the QP with cvxopt or scipy.optimize",
    "cvxpy": "state the QP to cvxopt directly, or use scipy.optimize",
    "clarabel": "solve the QP with cvxopt or scipy.optimize",
    "daqp": "solve the QP with cvxopt or scipy.optimize",
    "piqp": "solve the QP with cvxopt or scipy.optimize",
    "quadprog": "solve the QP with cvxopt or scipy.optimize",
    "qpsolvers": "solve the QP with cvxopt or scipy.optimize",
    "pandas": "use numpy, or the csv module",
    "numba": "write the loop with numpy arrays",
    "jax": "use torch, or numpy",
    "tqdm": "print now and then instead",
    "rich": "print instead",
    "typer": "scripts get no arguments; use constants at the top",
    "seaborn": "use matplotlib",
    "h5py": "save with numpy.save",
    "tensorflow": "use torch",
}

#: The simulator's own package: present, and never to be uploaded.
SIMULATOR = "rps"
#: Our stand-in for it: local only.
STAND_IN = "rps_compat"

#: Modules that came to the standard library after the testbed's Python → with which.
NEWER_MODULES = {"tomllib": "3.11", "annotationlib": "3.14", "compression": "3.14"}
#: Modules that left the standard library after the testbed's Python, which still has them.
GONE_SINCE = frozenset(
    {
        "aifc", "asynchat", "asyncore", "audioop", "binhex", "cgi", "cgitb", "chunk", "crypt",
        "distutils", "imghdr", "imp", "lib2to3", "mailcap", "msilib", "nis", "nntplib",
        "ossaudiodev", "pipes", "smtpd", "sndhdr", "spwd", "sunau", "telnetlib", "uu", "xdrlib",
    }
)  # fmt: skip
#: The testbed's standard library: nothing uploaded may be called like one of these.
STANDARD_LIBRARY = (frozenset(sys.stdlib_module_names) | GONE_SINCE) - set(NEWER_MODULES)


def is_available(module: str) -> bool:
    """Return whether the testbed can import a module.

    Parameters
    ----------
    module : str
        Name of a top-level module.
    """
    return module in STANDARD_LIBRARY or module in IMPORT_NAMES or module == SIMULATOR


def shadowed_by(module: str) -> str | None:
    """Return what an uploaded file ``module.py`` would hide, in words; None if nothing.

    Parameters
    ----------
    module : str
        Name of the file without ``.py``.
    """
    if module in STANDARD_LIBRARY:
        return f"Python's own module {module!r}"
    if module in IMPORT_NAMES:
        return f"the testbed's library {module!r}"
    if module == SIMULATOR:
        return "the Robotarium's own package 'rps'"
    return None
