"""The functions of the real world, taken before anything stands in for them.

Everything in this package that really waits, locks or reads a clock does so by these names.
"""

import _thread
import os
import queue
import select
import selectors
import signal
import subprocess
import threading
import time as _time
from typing import Any

time, time_ns = _time.time, _time.time_ns
monotonic, perf_counter = _time.monotonic, _time.perf_counter
process_time, sleep = _time.process_time, _time.sleep
localtime, gmtime, ctime, asctime = _time.localtime, _time.gmtime, _time.ctime, _time.asctime
strftime = _time.strftime
clock_gettime: Any = getattr(_time, "clock_gettime", None)
clock_gettime_ns: Any = getattr(_time, "clock_gettime_ns", None)
CLOCK_REALTIME = getattr(_time, "CLOCK_REALTIME", None)
#: The system's clocks that count real time from some moment.
MONOTONIC_CLOCKS = {
    getattr(_time, name)
    for name in ("CLOCK_MONOTONIC", "CLOCK_MONOTONIC_RAW", "CLOCK_BOOTTIME", "CLOCK_TAI")
    if hasattr(_time, name)
}

allocate_lock = _thread.allocate_lock
reentrant_lock: Any = _thread.RLock
start_new_thread, get_ident = _thread.start_new_thread, _thread.get_ident
condition_wait = threading.Condition.wait
thread_start, thread_join = threading.Thread.start, threading.Thread.join
thread_life = threading.Thread._bootstrap_inner  # type: ignore[attr-defined]

select_select, waitpid = select.select, os.waitpid
popen_wait, popen_poll = subprocess.Popen.wait, subprocess.Popen.poll
popen_communicate = subprocess.Popen.communicate
PythonSimpleQueue = queue._PySimpleQueue  # type: ignore[attr-defined]
#: How each kind of selector waits, by its class.
selector_waits = {
    kind: kind.select
    for kind in (
        getattr(selectors, name, None)
        for name in ("SelectSelector", "PollSelector", "EpollSelector", "KqueueSelector")
    )
    if kind is not None
}
alarm: Any = getattr(signal, "alarm", None)
setitimer: Any = getattr(signal, "setitimer", None)
getitimer: Any = getattr(signal, "getitimer", None)
pause: Any = getattr(signal, "pause", None)
