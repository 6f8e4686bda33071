"""What the kernel lets a script use."""

import subprocess
import sys

import pytest

FORKS = """
import os, resource, signal, time  # all before it is another user
from rps_compat.running import limits

if os.getuid() == 0:  # whom the kernel does not hold
    os.setgid(65534)
    os.setuid(65534)
limits.TASKS = 8
limits.limit_process(None, 1 << 20)
started = []
try:
    while len(started) < 200:
        process = os.fork()
        if process == 0:
            time.sleep(60)
            os._exit(0)
        started.append(process)
except BlockingIOError:
    print("held")
for process in started:
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="counts processes in /proc")
def test_the_kernel_holds_the_number_of_processes():
    done = subprocess.run([sys.executable, "-c", FORKS], capture_output=True, text=True, check=True)
    assert done.stdout == "held\n"
