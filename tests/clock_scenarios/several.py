"""Several threads: each wakes at its own time, and nobody's sleep pushes another's clock."""

import concurrent.futures
import queue
import threading
import time
from multiprocessing.pool import ThreadPool

from common import now, scenario, since, started, step

from rps_compat.clock import real


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
    return round(now.clock.elapsed, 1)


@scenario
def main_hangs_in_an_unknown_wait():
    lock = real.allocate_lock()
    lock.acquire()
    started(lambda: (time.sleep(0.2), lock.release()))
    lock.acquire()
    return round(now.clock.elapsed, 1)


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

        begun, real_begun = now.clock.elapsed, real.monotonic()
        thread = started(compute)
        while not done:
            wait(0.05)
        thread.join()
        out.append(now.clock.elapsed - begun <= real.monotonic() - real_begun + 0.06)
    return out, list(now.clock.real_reasons)


@scenario
def a_quick_computation_takes_no_time():
    seen = []

    def compute():
        for _ in range(20):
            sum(range(20_000))
            seen.append(round(now.clock.elapsed, 6))
            time.sleep(0.01)

    started(compute).join()
    return seen == [round(0.01 * k, 6) for k in range(20)], list(now.clock.real_reasons)


@scenario
def restless_threads_do_not_stop_time():
    """Threads that give way, sleep for no time, or wake each other, and never come to rest."""
    out, stop = [], []

    def give_way(pause):
        while not stop:
            time.sleep(pause)

    def toss(get, put):
        while not stop:
            put.put(get.get())

    def wait_for_nothing():
        while not stop:
            threading.Event().wait(1e-9)

    here, there = queue.Queue(), queue.Queue()
    for made in (
        [(give_way, 0)], [(give_way, 1e-9)], [(toss, here, there), (toss, there, here)],
        [(wait_for_nothing,)],
    ):  # fmt: skip
        stop.clear()
        threads = [started(*spec) for spec in made]
        here.put(1)
        begun = now.clock.elapsed
        for _ in range(10):
            step(0.05)
        out.append(round(now.clock.elapsed - begun, 3))
        stop.append(1)
        here.put(1)
        there.put(1)
        for thread in threads:
            thread.join()
        here, there = queue.Queue(), queue.Queue()
    return out


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
