"""Names of Python's own modules that the testbed's Python 3.10 has no more, not yet, or for long.

The lists are compared with the library, from Python 3.6 to 3.13, by ``tools/library_names.py``;
names of 3.14 are taken from its documentation. Modules that came or went as a whole stand in
:mod:`rps_compat.scripts.libraries`.
"""

from __future__ import annotations

#: Newer than 3.10: module → since which version → names.
NEWER = {
    "ast": {"3.11": "TryStar", "3.12": "ParamSpec TypeAlias TypeVar TypeVarTuple type_param"},
    "asyncio": {
        "3.11": "Barrier BrokenBarrierError Runner TaskGroup Timeout timeout timeout_at",
        "3.12": "create_eager_task_factory eager_task_factory",
        "3.13": "EventLoop QueueShutDown",
    },
    "asyncio.exceptions": {"3.11": "BrokenBarrierError"},
    "base64": {"3.13": "z85decode z85encode"},
    "builtins": {"3.11": "BaseExceptionGroup ExceptionGroup", "3.13": "PythonFinalizationError"},
    "calendar": {
        "3.12": "APRIL AUGUST DECEMBER Day FEBRUARY JANUARY JULY JUNE MARCH MAY Month NOVEMBER"
        " OCTOBER SEPTEMBER",
    },
    "collections.abc": {"3.12": "Buffer"},
    "concurrent.futures": {"3.14": "InterpreterPoolExecutor"},
    "configparser": {"3.13": "MultilineContinuationError UNNAMED_SECTION"},
    "contextlib": {"3.11": "chdir"},
    "copy": {"3.13": "replace"},
    "csv": {"3.12": "QUOTE_NOTNULL QUOTE_STRINGS"},
    "ctypes": {"3.11": "BigEndianUnion LittleEndianUnion", "3.12": "SIZEOF_TIME_T c_time_t"},
    "datetime": {"3.11": "UTC"},
    "enum": {
        "3.11": "CONFORM CONTINUOUS EJECT EnumCheck EnumType FlagBoundary KEEP NAMED_FLAGS ReprEnum"
        " STRICT StrEnum UNIQUE global_enum global_str member nonmember property"
        " show_flag_values verify",
        "3.13": "EnumDict",
    },
    "functools": {"3.14": "Placeholder"},
    "glob": {"3.13": "translate"},
    "hashlib": {"3.11": "file_digest"},
    "heapq": {"3.14": "heapify_max heappop_max heappush_max heappushpop_max heapreplace_max"},
    "http": {"3.11": "HTTPMethod"},
    "importlib.resources": {"3.13": "Anchor"},
    "inspect": {
        "3.11": "getmembers_static ismethodwrapper",
        "3.12": "AGEN_CLOSED AGEN_CREATED AGEN_RUNNING AGEN_SUSPENDED BufferFlags getasyncgenlocals"
        " getasyncgenstate markcoroutinefunction",
    },
    "itertools": {"3.12": "batched"},
    "locale": {"3.11": "getencoding"},
    "logging": {"3.11": "getLevelNamesMapping", "3.12": "getHandlerByName getHandlerNames"},
    "math": {"3.11": "cbrt exp2", "3.12": "sumprod", "3.13": "fma"},
    "mimetypes": {"3.13": "guess_file_type"},
    "operator": {"3.11": "call", "3.14": "is_none is_not_none"},
    "os": {
        "3.11": "login_tty",
        "3.12": "setns unshare",
        "3.13": "grantpt posix_openpt process_cpu_count ptsname timerfd_create timerfd_gettime"
        " timerfd_gettime_ns timerfd_settime timerfd_settime_ns unlockpt",
    },
    "os.path": {"3.12": "isjunction splitroot", "3.13": "isdevdrive"},
    "pathlib": {"3.13": "UnsupportedOperation"},
    "platform": {"3.13": "android_ver ios_ver"},
    "queue": {"3.13": "ShutDown"},
    "random": {"3.12": "binomialvariate"},
    "re": {"3.11": "NOFLAG", "3.13": "PatternError"},
    "socketserver": {"3.12": "ForkingUnixDatagramServer ForkingUnixStreamServer"},
    "sqlite3": {"3.11": "Blob"},
    "statistics": {"3.13": "kde kde_random"},
    "string": {"3.14": "templatelib"},
    "sys": {
        "3.11": "exception",
        "3.12": "activate_stack_trampoline deactivate_stack_trampoline getunicodeinternedsize"
        " is_stack_trampoline_active",
    },
    "termios": {"3.11": "tcgetwinsize tcsetwinsize"},
    "threading": {"3.12": "setprofile_all_threads settrace_all_threads"},
    "tty": {"3.12": "cfmakecbreak cfmakeraw"},
    "turtle": {"3.12": "teleport"},
    "types": {"3.12": "get_original_bases", "3.13": "CapsuleType"},
    "typing": {
        "3.11": "LiteralString Never NotRequired Required Self TypeVarTuple Unpack assert_never"
        " assert_type clear_overloads dataclass_transform get_overloads reveal_type",
        "3.12": "TypeAliasType override",
        "3.13": "NoDefault ReadOnly TypeIs get_protocol_members is_protocol",
    },
    "unittest": {"3.11": "enterModuleContext"},
    "unittest.mock": {"3.13": "ThreadingMock"},
    "warnings": {"3.13": "deprecated"},
}  # fmt: skip
#: Modules within packages that are newer than 3.10.
NEWER_MODULES = {"wsgiref.types": "3.11", "string.templatelib": "3.14"}

_ABC = "write collections.abc."
#: Gone by 3.10: module → name → what to write, as in :mod:`~rps_compat.scripts.numpy_names`.
GONE = {
    "base64": {"decodestring": ".decodebytes", "encodestring": ".encodebytes"},
    "calendar": {"monthlen": "write calendar.monthrange(…)[1]", "nextmonth": "", "prevmonth": ""},
    "cgi": {
        "escape": "write html.escape(…)", "parse_qs": "write urllib.parse.parse_qs(…)",
        "parse_qsl": "write urllib.parse.parse_qsl(…)",
    },
    "codecs": {"unicode_internal_decode": "", "unicode_internal_encode": ""},
    "collections": {
        name: f"{{}}.abc.{name}"
        for name in [
            "AsyncGenerator", "AsyncIterable", "AsyncIterator", "Awaitable", "ByteString",
            "Callable", "Collection", "Container", "Coroutine", "Generator", "Hashable",
            "ItemsView", "Iterable", "Iterator", "KeysView", "Mapping", "MappingView",
            "MutableMapping", "MutableSequence", "MutableSet", "Reversible", "Sequence", "Set",
            "Sized", "ValuesView",
        ]
    },
    "fractions": {"gcd": "write math.gcd(…)"},
    "os": {"stat_float_times": ""},
    "platform": {
        "dist": "", "linux_distribution": "", "popen": "write subprocess.run(…)", "DEV_NULL":
        "write os.devnull",
    },
    "plistlib": {
        "readPlist": "write plistlib.load(…)", "writePlist": "write plistlib.dump(…)",
        "readPlistFromBytes": ".loads", "writePlistToBytes": ".dumps", "Data": "write bytes",
        "Dict": "write dict", "Plist": "write dict",
    },
    "sys": {
        "callstats": "", "get_coroutine_wrapper": "", "set_coroutine_wrapper": "",
        "getcheckinterval": ".getswitchinterval", "setcheckinterval": "write sys.setswitchinterval",
    },
    "time": {"clock": ".perf_counter"},
    "typing": {"GenericMeta": ""},
    "wave": {"openfp": ".open"},
}  # fmt: skip
#: Modules that are gone by 3.10 → what to do.
GONE_MODULES = {
    "dummy_threading": "import threading",
    "formatter": "",
    "macpath": "import os.path",
    "parser": "import ast",
    "symbol": "",
}
#: The testbed has it, and a newer Python has not: module → name → what both have, or "".
LATER = {
    "asyncio": {"coroutine": "write async def"},
    "binascii": {"a2b_hqx": "", "b2a_hqx": "", "rlecode_hqx": "", "rledecode_hqx": ""},
    "configparser": {"LegacyInterpolation": "", "SafeConfigParser": ".ConfigParser"},
    "gettext": {
        "bind_textdomain_codeset": "", "ldgettext": ".dgettext", "ldngettext": ".dngettext",
        "lgettext": ".gettext", "lngettext": ".ngettext",
    },
    "importlib": {"find_loader": "write importlib.util.find_spec(…)"},
    "importlib.abc": {"Finder": ".MetaPathFinder"},
    "importlib.metadata": {"SelectableGroups": ".EntryPoints"},
    "importlib.resources": {"Resource": "write str"},
    "importlib.util": {"module_for_loader": "", "set_loader": "", "set_package": ""},
    "inspect": {
        "ArgSpec": "write FullArgSpec", "formatargspec": "write str(inspect.signature(…))",
        "getargspec": "write getfullargspec(…)",
    },
    "locale": {
        "format": ".format_string", "resetlocale": "write locale.setlocale(locale.LC_ALL, '')",
    },
    "logging.handlers": {"ST_DEV": "", "ST_INO": "", "ST_MTIME": ""},
    "re": {"T": "", "TEMPLATE": "", "template": ".compile"},
    "smtpd": {"MailmanProxy": ""},
    "sqlite3": {"enable_shared_cache": ""},
    "ssl": {
        "RAND_pseudo_bytes": ".RAND_bytes", "match_hostname": "",
        "wrap_socket": "write SSLContext.wrap_socket(…)",
    },
    "turtle": {"settiltangle": ".tiltangle"},
    "typing": {"io": "", "re": ""},
    "unittest": {"findTestCases": "", "getTestCaseNames": "", "makeSuite": ""},
}  # fmt: skip
