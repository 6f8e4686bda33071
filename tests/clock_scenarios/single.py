"""One thread: looks, sleeps, waits that nobody ends, alarms."""

import contextlib
import datetime
import pickle
import queue
import sched
import select
import signal
import threading
import time
import timeit

from common import now, scenario, since, step


@scenario
def sleeps_and_looks():
    start = time.time()
    time.sleep(2.5)
    step()
    return round(time.time() - start, 3), time.monotonic() < time.monotonic()


@scenario
def all_clocks_agree():
    def read():
        now = datetime.datetime.now()
        aware = datetime.datetime.now(datetime.timezone.utc)
        return [
            time.time(), time.time_ns() / 1e9, now.timestamp(), aware.timestamp(),
            time.clock_gettime(time.CLOCK_REALTIME), time.clock_gettime_ns(0) / 1e9,
            time.mktime(time.localtime()) + now.microsecond / 1e6,
            datetime.datetime.today().timestamp(),
            time.mktime(time.strptime(time.ctime())) + now.microsecond / 1e6,
            time.mktime(time.strptime(time.asctime())) + now.microsecond / 1e6,
            time.mktime(time.strptime(time.strftime("%c"))) + now.microsecond / 1e6,
            datetime.datetime.utcnow().replace(tzinfo=datetime.timezone.utc).timestamp(),
        ]  # fmt: skip

    def tick():
        return [
            time.monotonic(), time.perf_counter(), time.monotonic_ns() / 1e9,
            time.perf_counter_ns() / 1e9, time.clock_gettime(time.CLOCK_MONOTONIC),
            timeit.default_timer(),
        ]  # fmt: skip

    apart = max(read()) - min(read()) + max(tick()) - min(tick())
    before = read() + tick()
    time.sleep(800)
    moved = {round(b - a) for a, b in zip(before, read() + tick(), strict=True)}
    return apart < 1e-3, sorted(moved), time.gmtime(0).tm_year, time.strftime("%Y", time.gmtime(0))


@scenario
def names_taken_by_users():
    """Default arguments, ``from`` imports, and what was taken under an earlier clock."""
    space = {}
    exec(
        "from time import sleep, time, monotonic\nfrom datetime import datetime\n"
        "def f(clock=time, pause=sleep):\n    start = clock()\n    pause(2)\n"
        "    return clock() - start\n"
        "class Moment(datetime):\n    pass\n",
        space,
    )
    earlier = names_taken_by_users.__dict__.setdefault("space", space)
    moment = space["Moment"].now()
    now = space["datetime"].now()
    return [
        round(space["f"](), 3), round(earlier["f"](), 3), type(moment).__name__,
        type(now) is datetime.datetime, pickle.loads(pickle.dumps(now)) == now,
        isinstance(now, datetime.datetime),
    ]  # fmt: skip


@scenario
def waits_of_one_thread_end():
    start, out = time.monotonic(), []
    out += [threading.Event().wait(1), since(start)]
    condition = threading.Condition()
    with condition:
        out += [condition.wait_for(lambda: False, timeout=1), since(start)]
    out += [threading.Semaphore(0).acquire(timeout=1), since(start)]
    lock = threading.Lock()
    lock.acquire()
    out += [lock.acquire(timeout=1), since(start), lock.acquire(False)]
    for kind in (queue.Queue, queue.SimpleQueue, queue.PriorityQueue):
        with contextlib.suppress(queue.Empty):
            out.append(kind().get(timeout=1))
        out.append(since(start))
    full = queue.Queue(1)
    full.put(1)
    with contextlib.suppress(queue.Full):
        full.put(2, timeout=1)
    out += [since(start), select.select([], [], [], 1), since(start)]
    return out


@scenario
def wrong_arguments_are_refused():
    refused = []
    lock = threading.Lock()
    for wrong in (
        lambda: time.sleep(-1),
        lambda: time.sleep(float("nan")),
        lambda: time.sleep("1"),
        lambda: lock.acquire(False, 1),
        lambda: lock.acquire(True, -2),
        lambda: threading.RLock().acquire(False, 1),
        lambda: threading.Condition().wait(1),
        lambda: lock.release(),
        lambda: threading.RLock().release(),
        lambda: threading.current_thread().join(),
        lambda: threading.Thread().join(),
        lambda: signal.setitimer(signal.ITIMER_REAL, -1),
    ):
        try:
            wrong()
            refused.append("accepted")
        except (ValueError, TypeError, RuntimeError, OSError) as error:
            refused.append(type(error).__name__)
    return refused


@scenario
def scheduler_of_the_standard_library():
    start, out = time.monotonic(), []
    for made in (sched.scheduler(), sched.scheduler(time.time, time.sleep)):
        made.enter(2, 1, lambda: out.append(since(start)))
        made.enter(1, 1, lambda: out.append(since(start)))
        made.run()
    return out


@scenario
def alarms():
    start, seen = time.monotonic(), []
    before = signal.signal(signal.SIGALRM, lambda *_: seen.append(since(start)))
    try:
        out = [signal.alarm(1)]
        time.sleep(3)
        signal.setitimer(signal.ITIMER_REAL, 1, 0.5)
        while len(seen) < 4:
            signal.pause()
        out.append(signal.alarm(5))
        out.append(round(signal.getitimer(signal.ITIMER_REAL)[0], 3))
        for _ in range(30):
            step(1.0)
        signal.signal(signal.SIGALRM, lambda *_: step(0.5))  # a handler that steps
        signal.setitimer(signal.ITIMER_REAL, 0.5, 0.5)
        begun = time.monotonic()
        time.sleep(5)
        out += [signal.setitimer(signal.ITIMER_REAL, 0)[1], since(begun)]
    finally:
        signal.signal(signal.SIGALRM, before)
    return seen, out


@scenario
def an_alarm_without_a_handler_ends_the_script():
    signal.alarm(2)
    try:
        time.sleep(5)
    except SystemExit as left:
        return left.code, round(now.clock.elapsed, 3)
    return "went on"
