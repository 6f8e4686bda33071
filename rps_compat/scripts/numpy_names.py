"""Names of numpy that the testbed's version has no more, has not yet, or has and newer ones lack.

The lists are compared with numpy itself, from 1.14 to 2.5, by ``tools/library_names.py``.
"""

from __future__ import annotations

#: Gone → what to write. A leading dot is a name of the same module; ``{}`` stands for it.
GONE = {
    # Python's own types, which had aliases here.
    "float": "float",
    "int": "int",
    "complex": "complex",
    "object": "object",
    "str": "str",
    "unicode": "str",
    # Types under other names.
    "float_": ".float64",
    "complex_": ".complex128",
    "cfloat": ".complex128",
    "singlecomplex": ".complex64",
    "longfloat": ".longdouble",
    "longcomplex": ".clongdouble",
    "clongfloat": ".clongdouble",
    "string_": ".bytes_",
    "bytes0": ".bytes_",
    "unicode_": ".str_",
    "str0": ".str_",
    "bool8": ".bool_",
    "int0": ".intp",
    "uint0": ".uintp",
    "void0": ".void",
    "object0": ".object_",
    "typeDict": ".sctypeDict",
    # Numbers.
    "Inf": ".inf",
    "Infinity": ".inf",
    "infty": ".inf",
    "PINF": ".inf",
    "NINF": "(-{}.inf)",
    "NaN": ".nan",
    "NAN": ".nan",
    "PZERO": "0.0",
    "NZERO": "(-0.0)",
    # Functions under other names.
    "mat": ".asmatrix",
    "round_": ".round",
    "product": ".prod",
    "cumproduct": ".cumprod",
    "sometrue": ".any",
    "alltrue": ".all",
    "issubsctype": ".issubdtype",
    "rank": ".ndim",
    "alen": "len",
    "issubclass_": "issubclass",
    # Moved.
    "AxisError": "{}.exceptions.AxisError",
    "ComplexWarning": "{}.exceptions.ComplexWarning",
    "ModuleDeprecationWarning": "{}.exceptions.ModuleDeprecationWarning",
    "RankWarning": "{}.exceptions.RankWarning",
    "TooHardError": "{}.exceptions.TooHardError",
    "VisibleDeprecationWarning": "{}.exceptions.VisibleDeprecationWarning",
    "DataSource": "{}.lib.npyio.DataSource",
    "add_docstring": "{}.lib.add_docstring",
    "add_newdoc": "{}.lib.add_newdoc",
    "byte_bounds": "{}.lib.array_utils.byte_bounds",
    "tracemalloc_domain": "{}.lib.tracemalloc_domain",
    "compare_chararrays": "{}.char.compare_chararrays",
    "format_parser": "{}.rec.format_parser",
}
#: Gone, and no name can take its place → what to do; "" where there is nothing like it.
GONE_OTHERWISE = {
    "asfarray": "write asarray(…, dtype=float)",
    "asscalar": "write array.item()",
    "msort": "write sort(…, axis=0)",
    "cast": "write asarray(…, dtype=…)",
    "find_common_type": "write result_type(…)",
    "fastCopyAndTranspose": "write array.T.copy()",
    "recfromcsv": "write genfromtxt(…, delimiter=',')",
    "recfromtxt": "write genfromtxt(…)",
    "mafromtxt": "write genfromtxt(…, usemask=True)",
    "ndfromtxt": "write genfromtxt(…, usemask=False)",
    "nbytes": "write dtype(…).itemsize",
    "sctype2char": "write dtype(…).char",
    "obj2sctype": "write dtype(…).type",
    "issctype": "write issubclass(…, generic)",
    "maximum_sctype": "name the type itself",
    "sctypes": "name the types themselves",
    "sctypeNA": "name the types themselves",
    "typeNA": "name the types themselves",
    "MachAr": "write finfo(…)",
    "math": "import math",
    "safe_eval": "write ast.literal_eval(…)",
    "loads": "write pickle.loads(…)",
    "source": "write inspect.getsource(…)",
    "lookfor": "look in the documentation",
    "who": "write dir()",
    "disp": "write print(…)",
    "set_string_function": "write set_printoptions(…)",
    "geterrobj": "write errstate(…)",
    "seterrobj": "write errstate(…)",
    "deprecate": "write warnings.warn(…)",
    "deprecate_with_doc": "write warnings.warn(…)",
    "kernel_version": "write platform.release()",
    "CLIP": "write 'clip'",
    "RAISE": "write 'raise'",
    "WRAP": "write 'wrap'",
    "pkgload": "import it",
    "PackageLoader": "import it",
    # Finance, which became a library that the testbed has not.
    "fv": "", "ipmt": "", "irr": "", "mirr": "", "nper": "", "npv": "", "pmt": "", "ppmt": "",
    "pv": "", "rate": "",
    # Test runners, and packages of packages that are no more.
    "Tester": "", "bench": "", "add_newdocs": "", "numarray": "", "oldnumeric": "",
    # Names of the C code.
    "set_numeric_ops": "", "get_array_wrap": "", "add_newdoc_ufunc": "", "int_asbuffer": "",
    "use_hugepage": "", "ALLOW_THREADS": "", "BUFSIZE": "", "MAXDIMS": "", "MAY_SHARE_BOUNDS": "",
    "MAY_SHARE_EXACT": "", "ERR_CALL": "", "ERR_DEFAULT": "", "ERR_IGNORE": "", "ERR_LOG": "",
    "ERR_PRINT": "", "ERR_RAISE": "", "ERR_WARN": "", "FLOATING_POINT_SUPPORT": "",
    "FPE_DIVIDEBYZERO": "", "FPE_INVALID": "", "FPE_OVERFLOW": "", "FPE_UNDERFLOW": "",
    "SHIFT_DIVIDEBYZERO": "", "SHIFT_INVALID": "", "SHIFT_OVERFLOW": "", "SHIFT_UNDERFLOW": "",
    "UFUNC_BUFSIZE_DEFAULT": "", "UFUNC_PYVALS_NAME": "",
}  # fmt: skip
#: The same for other modules of numpy: module → names.
GONE_ELSEWHERE = {
    "numpy.ctypeslib": {
        "ctypes_load_library": ".load_library",
        "prep_array": "", "prep_pointer": "", "prep_simple": "",
    },
    "numpy.ma": {
        "dump": "", "dumps": "", "load": "", "loads": "", "rank": ".ndim",
    },
    "numpy.testing": {
        "Tester": "", "raises": "", "rand": "", "run_module_suite": "",
    },
}  # fmt: skip
#: Names that `numpy.lib` kept; everything else that it handed on is to be taken from numpy.
LIB_KEPT = frozenset(
    {
        "Arrayterator", "NumpyVersion", "add_docstring", "add_newdoc", "array_utils", "format",
        "introspect", "mixins", "npyio", "recfunctions", "scimath", "stride_tricks", "test",
        "tracemalloc_domain", "user_array",
    }
)  # fmt: skip
#: Modules that are gone.
GONE_MODULES = (
    "array_api",
    "testing.decorators",
    "testing.nosetester",
    "testing.utils",
)

#: The testbed has it, and a newer numpy has not → what both have, or "".
LATER = {
    "in1d": ".isin",
    "row_stack": ".vstack",
    "trapz": ".trapezoid",
    "chararray": "{}.char.chararray",
}
#: Newer than the testbed's: module → name → since which version.
NEWER = {
    "numpy.strings": {"slice": "2.3"},
    "numpy.char": {"slice": "2.5"},
    "numpy.testing": {"BLAS_SUPPORTS_FPE": "2.3"},
}
