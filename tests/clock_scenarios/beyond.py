"""Other processes, sockets and the keyboard."""

import contextlib
import functools
import multiprocessing
import os
import queue
import select
import selectors
import socket
import subprocess
import sys
import threading
import time

from common import scenario, since, started, step

from rps_compat.clock import real


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
