"""Event loops, and waits that last for ever."""

import asyncio
import itertools
import os
import queue
import threading
import time

from common import now, scenario, since, started, step

from rps_compat.clock import Stuck


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
            ticks.append(round(now.clock.elapsed, 3))
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
    apart = {round(b - a, 2) for a, b in itertools.pairwise(ticks)}
    return [*out, sorted(apart)]


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

    told = [_told(loop), round(now.clock.elapsed)]
    step()
    told += [_told(lambda: started(loop, daemon=True).join()), round(now.clock.elapsed)]
    return told
