"""One simulated clock for everything in which a script may wait; see clock_scenarios."""

import datetime
import json
import queue
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from rps_compat.clock import SimulatedClock, Stuck
from rps_compat.clock.stand_ins import _stand_ins, in_force

SCENARIOS = Path(__file__).parent / "clock_scenarios"

# What each scenario must return; a tuple in one is a list here.
EXPECTED = {
    "sleeps_and_looks": [2.6, True],
    "all_clocks_agree": [True, [800], 1970, "1970"],
    "names_taken_by_users": [2.0, 2.0, "Moment", True, True, True],
    "waits_of_one_thread_end": [
        False, 1.0, False, 2.0, False, 3.0, False, 4.0, False,
        5.0, 6.0, 7.0, 8.0, [[], [], []], 9.0,
    ],
    "wrong_arguments_are_refused": [
        *["ValueError"] * 2, "TypeError", *["ValueError"] * 3,
        *["RuntimeError"] * 5, "itimer_error",
    ],
    "scheduler_of_the_standard_library": [1.0, 2.0, 3.0, 4.0],
    "alarms": [[1.0, 4.0, 4.5, 5.0, 10.0], [0, 1, 5.0, 0.5, 5.0]],
    "an_alarm_without_a_handler_ends_the_script": [142, 2.0],
    "a_sleeping_thread_pushes_nobody": [True, True],
    "each_wakes_at_its_own_time": [
        ["c", 0.04], ["c", 0.08], ["c", 0.12], ["b", 0.15], ["c", 0.16], ["a", 0.25], ["b", 0.3],
        ["b", 0.45], ["a", 0.5], ["b", 0.6], ["a", 0.75], ["a", 1.0],
    ],
    "timers": [[0.25, 0.5, 0.75, 1.0, 1.25], 2.0],
    "producer_and_consumer": [[0, 0.8], [1, 1.3], [2, 1.8], [3, 2.3], [4, 2.8]],
    "main_waits_for_others": [False, True, 3.0, True, 7.0, False, 13.0],
    "barriers": [*[["broken", 2.5]] * 2, *[["through", 4.0]] * 3],
    "pools_of_threads": [3, 1, 5.0, ["timeout", 8.0], 1, 2, 3, 40.0, 1, 2, 3, True],
    "locks_go_to_who_waited_longest": [True, True],
    "locks_are_taken_several_times": [True, True, True, [False, False], True, True, True],
    "another_thread_drives": [40, 5.95, 13],
    "main_polls_without_a_clock": None,  # in real time: see test_main_is_not_waited_for
    "main_hangs_in_an_unknown_wait": None,
    "who_computes_holds_time": [[True, True], ["threads that compute"]],
    "a_quick_computation_takes_no_time": [True, []],
    "restless_threads_do_not_stop_time": [0.5] * 4,
    "threads_below_threading": [True, 2.0],
    "a_frozen_thread_still_sees_its_clock_move": 50,
    "waits_for_ever": ["waits for ever: the main thread waits"] * 5,
    "waits_too_long": [
        "waits for ever: no step for 900 s of the run, the main thread waits", 901,
        "waits for ever: no step for 900 s of the run, the main thread waits", 1802,
    ],
    "asyncio_in_the_main_thread": [2.5, 4.0, 1, 1, 6.0, 9.0, 10.0, "late"],
    "asyncio_in_another_thread": [5, "late", 2.0, [0.1]],
    "other_processes_keep_real_time": ["b'1'", *["True"] * 5],
    "multiprocessing_waits": ["child", True, "told", 0],
    "a_forked_process_has_a_clock_of_its_own": 7,
    "sockets_and_selectors_keep_real_time": [True, True, [], True, 1, 1],
    "nobody_types": [[], 50.0, True, 50.0],
}  # fmt: skip


#: Processes that share the scenarios: most of their time is waiting for the real clock.
SIDE_BY_SIDE = 4


@pytest.fixture(scope="module")
def returned():
    """Run all scenarios in processes of their own, which end themselves should one hang."""
    names = list(EXPECTED)
    running = [
        subprocess.Popen(
            [sys.executable, SCENARIOS, *names[k::SIDE_BY_SIDE]],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for k in range(SIDE_BY_SIDE)
    ]  # fmt: skip
    said = [process.communicate(timeout=240) for process in running]
    lines = [line for out, _ in said for line in out.splitlines() if line.startswith("[")]
    return dict(json.loads(line) for line in lines), "\n".join(
        f"{out[-500:]}{error[-1000:]}" for out, error in said
    )


@pytest.mark.parametrize("name", EXPECTED)
def test_scenario(returned, name):
    results, said = returned
    assert name in results, said
    if EXPECTED[name] is not None:
        assert results[name] == EXPECTED[name]


def test_every_scenario_is_tested():
    known = subprocess.run(
        [sys.executable, SCENARIOS, "--list"], capture_output=True, text=True, check=True
    ).stdout
    assert set(known.split()) == EXPECTED.keys()


def test_main_is_not_waited_for(returned):
    """Who sleeps wakes although the main thread neither steps nor waits; by the real clock then."""
    for name, slept in (
        ("main_polls_without_a_clock", 0.3),
        ("main_hangs_in_an_unknown_wait", 0.2),
    ):
        assert slept <= returned[0][name] < 20


def stood_in_for():
    """Return what stands where stand-ins go, and whether it is the owner's own."""
    return [
        (owner, name, vars(owner).get(name) if isinstance(owner, type) else getattr(owner, name))
        for owner, name, _ in _stand_ins()
    ] + [datetime.datetime.__dict__[name] for name in ("now", "utcnow")]


def test_everything_is_taken_back():
    before = stood_in_for()
    assert len(before) > 40
    handler = signal.getsignal(signal.SIGALRM)
    outer, inner = SimulatedClock(), SimulatedClock(start=0.0)
    with in_force(outer):
        between = stood_in_for()
        assert all(a != b for a, b in zip(before, between, strict=True))
        with pytest.raises(KeyError), in_force(inner):
            {}[time.time() < 1]
        assert stood_in_for() == between
        assert time.time() > 1e9
        start = time.monotonic()
        time.sleep(100)
        assert 100 <= time.monotonic() - start < 100.001
    assert stood_in_for() == before
    assert signal.getsignal(signal.SIGALRM) == handler
    assert abs(time.time() - datetime.datetime.now().timestamp()) < 1
    assert inner.elapsed < 0.001 < 100 <= outer.elapsed


def test_nothing_stays_behind_in_the_time_functions():
    with in_force(SimulatedClock(start=0.0)):
        taken = (time.time, time.time_ns, time.monotonic, time.perf_counter, time.localtime)
        now = datetime.datetime.now
        lock, many, goods = threading.Lock(), threading.RLock(), queue.SimpleQueue()
    real = (time.time(), time.time_ns(), time.monotonic(), time.perf_counter(), time.localtime())
    for function, value in zip(taken, real, strict=True):
        assert function() >= value
    assert now().timestamp() == pytest.approx(time.time(), abs=5)
    for one in (lock, many):
        with one:
            pass
        assert one.acquire(timeout=0.01)
        threading.Thread(target=lambda one=one: one.acquire(timeout=0.01)).start()
        one.release()
    with pytest.raises(queue.Empty):
        goods.get(timeout=0.01)


def test_threads_that_ran_before_keep_real_time():
    seen, go, stop = queue.Queue(), threading.Event(), threading.Event()

    def worker():
        go.wait()
        start = time.monotonic()
        time.sleep(0.05)
        seen.put(stop.wait(0.05))
        seen.put(time.monotonic() - start)

    thread = threading.Thread(target=worker)
    thread.start()
    clock = SimulatedClock()
    with in_force(clock):
        go.set()
        assert seen.get() is False
        assert 0.1 <= seen.get() < 20
        thread.join()
    assert clock.elapsed < 20


def test_threads_that_live_on_wait_on_in_real_time():
    woken, late = threading.Event(), queue.Queue()
    with in_force(SimulatedClock()):
        event = threading.Event()
        threading.Thread(target=lambda: (time.sleep(0.05), woken.set()), daemon=True).start()
        threading.Thread(target=lambda: late.put(event.wait()), daemon=True).start()
    assert woken.wait(20)
    event.set()
    assert late.get(timeout=20) is True


def test_an_exception_in_a_wait_leaves_no_trace():
    clock = SimulatedClock()

    def interrupt(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        with in_force(clock):
            for wait in (lambda: time.sleep(9), threading.Event().wait, queue.Queue().get):
                signal.alarm(1)
                with pytest.raises(KeyboardInterrupt):
                    wait()
            start = clock.elapsed
            time.sleep(1)
            assert clock.elapsed == pytest.approx(start + 1)
            assert clock.me().wait is clock.me().engine is None
    finally:
        signal.signal(signal.SIGALRM, before)


def test_a_clock_that_charges_counts_computing_and_sleeping():
    clock = SimulatedClock(charge=True)
    with in_force(clock):
        clock.resume()
        clock.advance(0.033)
        assert clock.elapsed == pytest.approx(0.033, abs=0.02)
        begun, cpu = time.monotonic(), time.process_time()
        while time.process_time() - cpu < 0.05:
            pass
        assert 0.05 <= clock.spent() < 0.2
        time.sleep(0.1)
        assert 0.15 <= clock.spent() < 0.3
        clock.advance(0.033)  # it took longer than that, and is not charged again
        assert clock.spent() < 0.05
        assert 0.15 <= time.monotonic() - begun < 0.4
        looks = [time.monotonic() for _ in range(1000)]
        assert looks == sorted(looks)


def test_negative_steps_do_not_pass():
    clock = SimulatedClock()
    clock.advance(-1)
    with in_force(clock):
        clock.advance(-1)
    assert clock.elapsed == 0


def test_a_clock_without_a_longest_wait_lets_time_pass():
    clock = SimulatedClock()
    with in_force(clock):
        time.sleep(1e6)
    limited = SimulatedClock(longest_wait=10)
    with in_force(limited), pytest.raises(Stuck, match=r"no step for 10 s .* test_clock.py, line"):
        time.sleep(11)
    assert clock.elapsed == 1e6
