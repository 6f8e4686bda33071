"""What threads, queues, event loops and timers see of simulated time; run by test_clock.py.

Run by itself, ``python tests/clock_scenarios.py [--repeat N] [NAME ...]``, it prints one JSON list a
scenario, ``[name, what it returned]``. Each scenario runs under a clock of its own; one that hangs
ends the process, which tells where. A step is `step()`, 0.1 s.
"""

import argparse
import asyncio
import concurrent.futures
import contextlib
import datetime
import faulthandler
import functools
import json
import multiprocessing
import os
import pickle
import queue
import sched
import select
import selectors
import signal
import socket
import subprocess
import sys
import threading
import time
import timeit
from multiprocessing.pool import ThreadPool

from rps_compat.clock import SimulatedClock, Stuck, real

HANGS = 60
SCENARIOS = {}
clock = None


def scenario(function):
    SCENARIOS[function.__name__] = function
    return function


def step(seconds=0.1):
    clock.advance(seconds)


def since(start):
    return round(time.monotonic() - start, 3)


def started(function, *arguments, daemon=False):
    thread = threading.Thread(target=function, args=arguments, daemon=daemon)
    thread.start()
    return thread


# --- One thread ---------------------------------------------------------------------------------


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
            time.mktime(time.localtime()) + now.microsecond / 1e6, datetime.datetime.today().timestamp(),
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
        return left.code, round(clock.elapsed, 3)
    return "went on"


# --- Several threads ----------------------------------------------------------------------------


@scenario
def a_sleeping_thread_pushes_nobody():
    def keys():
        while True:
            time.sleep(0.03)

    started(keys, daemon=True)
    start, steps = time.monotonic(), 0
    while time.monotonic() - start < 5:
        step()
        steps += 1
    return steps in (50, 51), since(start) <= 5.101


@scenario
def each_wakes_at_its_own_time():
    start, seen = time.monotonic(), []

    def sleeper(name, period):
        for _ in range(4):
            time.sleep(period)
            seen.append((name, since(start)))

    threads = [started(sleeper, *spec) for spec in (("a", 0.25), ("b", 0.15), ("c", 0.04))]
    for _ in range(12):
        step()
    for thread in threads:
        thread.join()
    return seen


@scenario
def timers():
    start, seen = time.monotonic(), []

    def tick():
        seen.append(since(start))
        if len(seen) < 5:
            threading.Timer(0.25, tick).start()

    never = threading.Timer(1000, seen.append, ["never"])
    never.start()
    threading.Timer(0.25, tick).start()
    for _ in range(20):
        step()
    never.cancel()
    never.join()
    return seen, since(start)


@scenario
def producer_and_consumer():
    goods, start, got = queue.Queue(maxsize=2), time.monotonic(), []

    def produce():
        for item in range(5):
            time.sleep(0.3)
            goods.put(item)
        goods.put(None)

    def consume():
        while (item := goods.get(timeout=5)) is not None:
            time.sleep(0.5)
            got.append((item, since(start)))

    threads = [started(produce), started(consume)]
    for thread in threads:
        thread.join()
    return got


@scenario
def main_waits_for_others():
    start, event, out = time.monotonic(), threading.Event(), []
    thread = started(lambda: (time.sleep(3), event.set()))
    out += [event.wait(1), event.wait(10), since(start)]
    thread.join()
    slow = started(time.sleep, 10)
    slow.join(timeout=4)
    out += [slow.is_alive(), since(start)]
    slow.join()
    return [*out, slow.is_alive(), since(start)]


@scenario
def barriers():
    start, out, barrier = time.monotonic(), [], threading.Barrier(3)

    def come(delay):
        time.sleep(delay)
        try:
            barrier.wait(timeout=2)
            out.append(("through", since(start)))
        except threading.BrokenBarrierError:
            out.append(("broken", since(start)))

    for delays in ((0.5, 1), (0.5, 1, 1.5)):
        threads = [started(come, delay) for delay in delays]
        for thread in threads:
            thread.join()
        barrier.reset()
    return out


@scenario
def pools_of_threads():
    start, out = time.monotonic(), []

    def job(seconds):
        time.sleep(seconds)
        return seconds

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        futures = [pool.submit(job, seconds) for seconds in (1, 2, 3, 40)]
        done, others = concurrent.futures.wait(futures, timeout=5)
        out += [len(done), len(others), since(start)]
        try:
            futures[3].result(timeout=3)
        except concurrent.futures.TimeoutError:
            out.append(("timeout", since(start)))
        out += sorted(f.result() for f in concurrent.futures.as_completed(futures[:3], timeout=1))
    out.append(since(start))
    with ThreadPool(3) as pool:
        out += pool.map(job, [1, 2, 3])
        late = pool.apply_async(job, [2])
        steps = 0
        while not late.ready():
            step()
            steps += 1
    return [*out, 20 <= steps <= 21]


@scenario
def locks_go_to_who_waited_longest():
    """The stepper holds the lock in every step, and gives it back for no time at all."""
    out = []
    for kind in (threading.Lock, threading.RLock):
        lock, turns, stop = kind(), [0], threading.Event()

        def count(lock=lock, turns=turns, stop=stop):
            while not stop.is_set():
                with lock:
                    turns[0] += 1
                time.sleep(0.05)

        thread = started(count)
        for _ in range(50):
            with lock:
                step()
        stop.set()
        thread.join()
        out.append(25 <= turns[0] <= 60)
    return out


@scenario
def locks_are_taken_several_times():
    lock, condition = threading.RLock(), threading.Condition()
    out = [lock.acquire(), lock.acquire(), lock.acquire(False)]
    blocked = queue.Queue()
    thread = started(lambda: blocked.put((lock.acquire(timeout=1), lock.acquire(timeout=2))))
    thread.join()
    out.append(blocked.get())
    for _ in range(3):
        lock.release()
    with condition, condition, condition:
        waker = started(lambda: (time.sleep(1), condition.acquire(), condition.notify_all(),
                                 condition.release()))  # fmt: skip
        out += [condition.wait(5), condition._is_owned()]
    waker.join()
    thread = started(lambda: blocked.put(lock.acquire(timeout=1)))
    return [*out, blocked.get(timeout=3)]


@scenario
def another_thread_drives():
    start, steps = time.monotonic(), []

    def control():
        for _ in range(40):
            step()
            steps.append(since(start))
            time.sleep(0.05)

    thread = started(control)
    looks = 0
    while thread.is_alive():
        time.sleep(0.5)
        looks += 1
    return len(steps), steps[-1], looks


@scenario
def main_polls_without_a_clock():
    event = threading.Event()
    started(lambda: (time.sleep(0.3), event.set()))
    while not event.is_set():
        pass
    return round(clock.elapsed, 1)


@scenario
def main_hangs_in_an_unknown_wait():
    lock = real.allocate_lock()
    lock.acquire()
    started(lambda: (time.sleep(0.2), lock.release()))
    lock.acquire()
    return round(clock.elapsed, 1)


@scenario
def who_computes_holds_time():
    """Neither steps nor waits outrun a thread that computes for 0.3 s of CPU time."""
    out = []
    for wait in (step, time.sleep):
        done = []

        def compute(done=done):
            end = time.thread_time() + 0.3
            while time.thread_time() < end:
                pass
            done.append(1)

        begun, real_begun = clock.elapsed, real.monotonic()
        thread = started(compute)
        while not done:
            wait(0.05)
        thread.join()
        out.append(clock.elapsed - begun <= real.monotonic() - real_begun + 0.06)
    return out, list(clock.real_reasons)


@scenario
def a_quick_computation_takes_no_time():
    seen = []

    def compute():
        for _ in range(20):
            sum(range(20_000))
            seen.append(round(clock.elapsed, 6))
            time.sleep(0.01)

    started(compute).join()
    return seen == [round(0.01 * k, 6) for k in range(20)], list(clock.real_reasons)


@scenario
def threads_below_threading():
    import _thread

    start, done = time.monotonic(), threading.Event()
    _thread.start_new_thread(lambda: (time.sleep(2), done.set()), ())
    return done.wait(5), since(start)


@scenario
def a_frozen_thread_still_sees_its_clock_move():
    seen = queue.Queue()
    started(lambda: seen.put(len({time.monotonic() for _ in range(50)})))
    return seen.get()


# --- For ever -----------------------------------------------------------------------------------


def _told(function):
    try:
        function()
    except Stuck as stuck:
        return str(stuck).replace(os.path.basename(__file__), "FILE").split(" at FILE")[0]
    return "ended"


@scenario
def waits_for_ever():
    first, second = threading.Lock(), threading.Lock()

    def deadlock():
        def other():
            with second:
                time.sleep(0.1)
                with first:
                    pass

        started(other, daemon=True)
        with first:
            time.sleep(0.2)
            with second:
                pass

    return [
        _told(lambda: queue.Queue().get()),
        _told(threading.Event().wait),
        _told(lambda: started(threading.Event().wait, daemon=True).join()),
        _told(deadlock),
        _told(lambda: asyncio.run(_never())),
    ]


async def _never():
    await asyncio.Event().wait()


@scenario
def waits_too_long():
    def loop():
        while True:
            time.sleep(1)

    told = [_told(loop), round(clock.elapsed)]
    step()
    told += [_told(lambda: started(loop, daemon=True).join()), round(clock.elapsed)]
    return told


# --- Event loops --------------------------------------------------------------------------------


@scenario
def asyncio_in_the_main_thread():
    start, out = time.monotonic(), []

    async def control():
        for _ in range(10):
            step()
            await asyncio.sleep(0.05)

    async def main():
        try:
            await asyncio.wait_for(asyncio.sleep(100), 2.5)
        except asyncio.TimeoutError:
            out.append(since(start))
        await asyncio.gather(control(), asyncio.sleep(0.7))
        out.append(since(start))
        done, pending = await asyncio.wait(
            [asyncio.create_task(asyncio.sleep(s)) for s in (1, 50)], timeout=2
        )
        out.extend([len(done), len(pending), since(start)])
        await asyncio.to_thread(time.sleep, 3)
        out.append(since(start))
        try:
            await asyncio.wait_for(asyncio.to_thread(time.sleep, 4), 1)
        except asyncio.TimeoutError:
            out.append(since(start))
        late = asyncio.get_running_loop().run_in_executor(None, time.sleep, 1)
        while not late.done():
            step()
            await asyncio.sleep(0)
        goods = asyncio.Queue()
        asyncio.get_running_loop().call_later(2, goods.put_nowait, "late")
        out.append(await asyncio.wait_for(goods.get(), 5))

    asyncio.run(main())
    return [round(x, 2) if isinstance(x, float) else x for x in out]


@scenario
def asyncio_in_another_thread():
    loop, ticks = asyncio.new_event_loop(), []

    async def tick():
        while len(ticks) < 20:
            ticks.append(round(clock.elapsed, 3))
            await asyncio.sleep(0.1)

    thread = started(loop.run_forever)
    future = asyncio.run_coroutine_threadsafe(tick(), loop)
    for _ in range(15):
        step(0.033)
    start = time.monotonic()
    late = asyncio.run_coroutine_threadsafe(asyncio.sleep(2, "late"), loop)
    out = [len(ticks), late.result(timeout=5), since(start)]
    future.result(timeout=5)
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()
    apart = {round(b - a, 2) for a, b in zip(ticks, ticks[1:], strict=False)}
    return [*out, sorted(apart)]


# --- The world outside --------------------------------------------------------------------------


@scenario
def other_processes_keep_real_time():
    start, out = time.monotonic(), []
    program = [sys.executable, "-c", "import time; time.sleep(0.5); print(1)"]
    out.append(subprocess.run(program, timeout=30, capture_output=True, check=True).stdout.strip())
    out.append(0.45 < time.monotonic() - start < 20)
    start = time.monotonic()
    with contextlib.suppress(subprocess.TimeoutExpired):
        subprocess.run(["sleep", "30"], timeout=0.4, check=False)
        out.append("did not time out")
    out.append(0.35 < time.monotonic() - start < 20)
    for wait in (functools.partial(step, 0.05), functools.partial(time.sleep, 0.05)):
        process, start, turns = subprocess.Popen(["sleep", "0.5"]), time.monotonic(), 0
        while process.poll() is None:
            wait()
            turns += 1
        out.append(3 <= turns <= 400)
    start = time.monotonic()
    started(subprocess.run, ["sleep", "0.4"]).join()
    out.append(0.3 < time.monotonic() - start < 20)
    return [str(item) for item in out]


def _child(results, event):
    time.sleep(0.5)  # in no time: it has this process's clock, which is simulated
    results.put("child")
    event.wait(20)
    results.put("told")


@scenario
def multiprocessing_waits():
    context = multiprocessing.get_context("fork")
    results, event = context.Queue(), context.Event()
    process = context.Process(target=_child, args=(results, event))
    process.start()
    out = [results.get(timeout=30)]
    start = time.monotonic()
    with contextlib.suppress(queue.Empty):
        out.append(results.get(timeout=0.3))
    out.append(0.25 < time.monotonic() - start < 20)
    start = time.monotonic()
    waiting = context.Event()
    while time.monotonic() - start < 0.3:
        waiting.wait(0.1)
    event.set()
    out.append(results.get(timeout=30))
    process.join(30)
    return [*out, process.exitcode]


@scenario
def a_forked_process_has_a_clock_of_its_own():
    started(lambda: [time.sleep(0.1) for _ in range(100)], daemon=True)
    step()
    child = os.fork()
    if child == 0:
        start, goods = time.monotonic(), queue.Queue()
        threading.Timer(2, goods.put, [1]).start()
        time.sleep(1)
        os._exit(7 if goods.get(timeout=5) == 1 and since(start) == 2.0 else 8)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@scenario
def sockets_and_selectors_keep_real_time():
    out, (here, there) = [], socket.socketpair()
    here.settimeout(0.2)
    start = time.monotonic()
    with contextlib.suppress(socket.timeout):
        here.recv(1)
    out.append(0.15 < time.monotonic() - start < 20)
    here.setblocking(False)
    start, polls = time.monotonic(), 0
    while time.monotonic() - start < 0.3:
        with contextlib.suppress(BlockingIOError):
            here.recv(1)
        time.sleep(0.05)
        polls += 1
    out.append(polls <= 10)
    with selectors.DefaultSelector() as selector:
        selector.register(here, selectors.EVENT_READ)
        start = time.monotonic()
        out += [selector.select(0.2), 0.15 < time.monotonic() - start < 20]
        started(lambda: (real.sleep(0.2), there.send(b"x")))
        out.append(len(selector.select(20)))
    poll = select.poll()
    poll.register(here, select.POLLIN)
    out.append(len(poll.poll(1000)))
    here.close()
    there.close()
    return out


@scenario
def nobody_types():
    keyboard, other_end = os.pipe()
    before = os.dup(0)
    os.dup2(keyboard, 0)
    try:
        start = time.monotonic()
        found = [select.select([0], [], [], 50)[0], since(start)]
        os.write(other_end, b"q")
        found += [select.select([sys.__stdin__], [], [], 50)[0] == [sys.__stdin__], since(start)]
    finally:
        os.dup2(before, 0)
        for end in (before, keyboard, other_end):
            os.close(end)
    return found


def main():
    global clock
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("names", nargs="*")
    asked = parser.parse_args()
    for name in asked.names or SCENARIOS:
        for _ in range(asked.repeat):
            clock = SimulatedClock(longest_wait=900)
            # A thread of the system's that Python does not know, so that a hang ends the process.
            child_safe = "multiprocessing" not in name and "forked" not in name
            if child_safe:
                faulthandler.dump_traceback_later(HANGS, exit=True)
            with clock.in_force():
                result = SCENARIOS[name]()
            if child_safe:
                faulthandler.cancel_dump_traceback_later()
            print(json.dumps([name, result]), flush=True)


if __name__ == "__main__":
    main()
    os._exit(0)  # threads that wait for ever are part of it
