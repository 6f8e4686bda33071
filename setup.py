"""What setup.cfg cannot say: the experiments go along in the wheel, and the README leads home.

The wheel holds a copy of `experiments/` as `posflock_robotarium/examples/files`, which the source
tree does not: there `posflock_robotarium.examples` finds the folder itself. Where a package index
shows the README nobody sees the files around it, so that its links and pictures are given the
project's address.
"""

import configparser
import re
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
EXPERIMENTS = ROOT / "experiments"
ENDINGS = {".py", ".toml", ".ipynb", ".md"}


def long_description() -> str:
    """Return the README with every link within the project made absolute."""
    settings = configparser.ConfigParser(interpolation=None)
    settings.read(ROOT / "setup.cfg", encoding="utf-8")
    home = settings["metadata"]["url"].rstrip("/")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.sub(r"\]\((?!\w+:|#)([^)\s]+)\)", rf"]({home}/\1)", text)


class BuildWithExperiments(build_py):
    """Builds as ever, and puts the experiments beside the module that finds them."""

    def run(self) -> None:
        """Copy the packages, then the experiments."""
        super().run()
        if not self.editable_mode:
            for source, target in self._experiments():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, target)

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        """List what is built."""
        built = [] if self.editable_mode else [str(target) for _, target in self._experiments()]
        return [*super().get_outputs(include_bytecode), *built]

    def _experiments(self) -> list[tuple[Path, Path]]:
        place = Path(self.build_lib, "posflock_robotarium", "examples", "files")
        return [
            (file, place / file.relative_to(EXPERIMENTS))
            for file in sorted(EXPERIMENTS.rglob("*"))
            if file.suffix in ENDINGS and "__pycache__" not in file.parts
        ]


setup(
    cmdclass={"build_py": BuildWithExperiments},
    long_description=long_description(),
    long_description_content_type="text/markdown",
)
