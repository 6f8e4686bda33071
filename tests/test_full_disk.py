"""A full disk is an error that names the file, whatever a library makes of it."""

import os
import shutil
import subprocess
import sys

import pytest

CAN_MOUNT = (
    sys.platform == "linux"
    and shutil.which("unshare") is not None
    and subprocess.run(
        ["unshare", "--map-root-user", "--mount", "true"], capture_output=True, check=False
    ).returncode
    == 0
)

PROGRAM = """
import sys
from pathlib import Path
from posflock_robotarium.figures.style import new_figure, save
from posflock_robotarium.flocking.errors import OutputError

figure = new_figure(3.0, 2.0)
figure.subplots().set(title="a title", xlabel="and a label")
try:
    save(figure, Path(sys.argv[1]), "figure")
except OutputError as error:
    print(error)
"""


@pytest.mark.skipif(not CAN_MOUNT, reason="no small file system can be mounted here")
@pytest.mark.parametrize("kilobytes", [4, 20, 24])
def test_a_figure_on_a_full_disk_is_an_error_with_its_name(kilobytes, tmp_path):
    script = f"mount -t tmpfs -o size={kilobytes}k tmpfs {tmp_path} && exec {sys.executable} -"
    done = subprocess.run(
        ["unshare", "--map-root-user", "--mount", "sh", "-c", f"{script} {tmp_path}/out"],
        input=PROGRAM,
        capture_output=True,
        text=True,
        cwd="/",
        env={**os.environ, "PYTHONPATH": os.getcwd()},
        check=False,
    )
    assert done.stderr == ""
    assert done.stdout.startswith(f"{tmp_path}/out")
    assert "No space left on device" in done.stdout
