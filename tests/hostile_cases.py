"""A machine with something to lose, and what hostile and careless scripts do to it.

Each script of ``tests/hostile`` does one thing that it must not do, and marks its line with the
finding that is to come of it. Those in ``tests/hostile/native`` do it in ways of which Python tells
nobody: what becomes of them is a table in SECURITY.md.
"""

import contextlib
import os
import re
import shutil
import socket
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from posflock_robotarium.verify import verify
from posflock_robotarium.verify.findings import Verdict
from posflock_robotarium.verify.trials import ForkServer, Limits
from rps_compat.containment.caches import cache_folder
from rps_compat.containment.namespaces import Containment, works

HERE = Path(__file__).parent
SCRIPTS = sorted((HERE / "hostile").glob("*.py"))
NATIVE = sorted((HERE / "hostile" / "native").glob("*.py"))
LIMITS = Limits(stall=5.0, memory=512 << 20, disk=64 << 20)
#: What marks the line of the deed: a minus where the finding names it, a tilde where it cannot.
_MARK = re.compile(r"# <([-~]) (\S+)$", re.M)
_ROW = re.compile(r"^\|.*\[`(\w+)\.py`\].*\| (\w+) \| (\w+) \|$", re.M)


def containments() -> dict[str, Containment | None]:
    """Return the two halves, and what gives each here; None where the kernel refuses."""
    best = next(how for how in Containment if works(how))
    return {"namespaces": best if best.has_namespaces else None, "hook": Containment.HOOK}


def expected(script: Path) -> tuple[str, int | None]:
    """Return the code of the finding that is to come of a script, and its line."""
    for number, line in enumerate(script.read_text().splitlines(), 1):
        match = _MARK.search(line)
        if match:
            return match[2], number if match[1] == "-" else None
    raise AssertionError(f"{script.name} marks no line")


def table() -> dict[str, tuple[str, str]]:
    """Return what SECURITY.md says of native scripts: with namespaces, and without."""
    rows = _ROW.findall((HERE.parent / "SECURITY.md").read_text(encoding="utf-8"))
    return {name: (namespaces, hook) for name, namespaces, hook in rows}


@dataclass
class Machine:
    """Files, a port, a process and a name of shared memory that no script may reach.

    The files are not in /tmp: a script has one of its own in a namespace, so that nothing would be
    shown by what happens there.
    """

    _before: dict[str, str] = field(default_factory=dict)

    def __enter__(self) -> "Machine":
        cache_folder().mkdir(parents=True, exist_ok=True)
        self.outside = Path(tempfile.mkdtemp(prefix="outside-", dir=cache_folder()))
        self.victim = self.outside / "victim.txt"
        self._tcp = socket.create_server(("127.0.0.1", 0))
        self._tcp.setblocking(False)
        self._udp = socket.socket(type=socket.SOCK_DGRAM)
        self._udp.bind(self._tcp.getsockname())
        self._udp.setblocking(False)
        self._other = subprocess.Popen(["sleep", "1000"])
        self._shared = f"posflock-{os.getpid()}-{self._tcp.getsockname()[1]}"
        told = {
            "HOSTILE_OUTSIDE": str(self.outside),
            "HOSTILE_PORT": str(self._tcp.getsockname()[1]),
            "HOSTILE_PROCESS": str(self._other.pid),
            "HOSTILE_SHARED": self._shared,
        }
        self._before = {name: os.environ.get(name, "") for name in told}
        os.environ.update(told)
        self.restore()
        return self

    def __exit__(self, *_: object) -> None:
        for name in self._before:
            del os.environ[name]
        self._tcp.close()
        self._udp.close()
        self._other.kill()
        self._other.wait()
        shutil.rmtree(self.outside, ignore_errors=True)

    def restore(self) -> None:
        """Make everything as it was before any script."""
        self.outside.mkdir(exist_ok=True)
        for path in self.outside.iterdir():
            path.unlink()
        self.victim.write_text("mine")
        os.utime(self.victim, (1e9, 1e9))
        Path("/dev/shm", self._shared).unlink(missing_ok=True)

    def damage(self) -> list[str]:
        """Say what has been done to it."""
        found = []
        if not self.victim.exists():
            found.append("a file was removed")
        else:
            state = self.victim.stat()
            if (self.victim.read_text(), state.st_mtime, state.st_nlink) != ("mine", 1e9, 1):
                found.append("a file was changed")
        if self.outside.exists() and {p.name for p in self.outside.iterdir()} - {self.victim.name}:
            found.append("a file was made")
        for name, call in (("connected to", self._tcp.accept), ("sent", self._heard)):
            heard = 0
            with contextlib.suppress(BlockingIOError):
                while True:
                    call()
                    heard += 1
            found += [f"was {name}"] * bool(heard)
        if self._other.poll() is not None:
            found.append("a process was ended")
            self._other = subprocess.Popen(["sleep", "1000"])
            os.environ["HOSTILE_PROCESS"] = str(self._other.pid)
        if Path("/dev/shm", self._shared).exists():
            found.append("shared memory was made")
        return found

    def _heard(self) -> None:
        self._udp.recv(100)

    def left_running(self) -> list[int]:
        """Return processes, other than this one's, that were told of this machine."""
        self._other.kill()
        mark = f"HOSTILE_OUTSIDE={self.outside}".encode()
        deadline = time.monotonic() + 5.0
        while (found := [n for n in _processes() if _says(n, mark)]) and (
            time.monotonic() < deadline
        ):
            time.sleep(0.05)
        return found


def _processes() -> list[int]:
    return [int(p.name) for p in Path("/proc").iterdir() if p.name.isdigit()]


def _says(number: int, mark: bytes) -> bool:
    try:
        return number != os.getpid() and mark in Path(f"/proc/{number}/environ").read_bytes()
    except OSError:
        return False


def wrong(script: Path, server: ForkServer, machine: Machine) -> list[str]:
    """Verify a script; say what is wrong with the verdict, and with the machine afterwards."""
    code, line = expected(script)
    machine.restore()
    report = verify(script, trials=0, limits=LIMITS, server=server)
    found = [finding for finding in report.findings if finding.verdict > Verdict.PASS]
    said = []
    if [finding.code.value for finding in found] != [code]:
        said.append(f"expected {code}, got {[f'{f.code}: {f.message}' for f in found]}")
    elif line is not None and found[0].line != line:
        said.append(f"expected line {line}, got {found[0].line}")
    return said + machine.damage()


def becomes(script: Path, server: ForkServer, machine: Machine) -> str:
    """Verify a native script; say in a word of SECURITY.md what became of what it tried."""
    machine.restore()
    verify(script, trials=0, limits=LIMITS, server=server)
    return "done" if machine.damage() else "stopped"
