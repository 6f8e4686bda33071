"""The submitted experiment in this process, without the figures that it draws at its end."""

import runpy
import sys
from pathlib import Path

import pytest

EXPERIMENT = Path(__file__).resolve().parents[1] / "experiments" / "robotarium_9bot.py"


def fly_here(folder, *options):
    """Run the experiment in a folder; our `rps` stands in, as where no other is installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "argv", [str(EXPERIMENT), *options])
        told = "posflock_robotarium.report.nine_robots.report_experiment"
        patch.setattr(told, lambda path: None)
        runpy.run_path(str(EXPERIMENT), run_name="__main__")
