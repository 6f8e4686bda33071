"""The experiments that come with this package, wherever it is installed.

They are files to read, copy and change, not modules to import: the script that is submitted has to
be one that its user owns. In the source tree they lie in `experiments/`; a wheel holds the same
files as `files/` beside this module, put there when it is built.
"""

from pathlib import Path

from posflock_robotarium.flocking.errors import OutputError, ParameterError
from rps_compat.whole_files import write_whole, written_together

__all__ = ["NINE_ROBOTS", "copy_examples", "example_files", "examples_folder"]

#: Where a wheel has them.
_INSTALLED = Path(__file__).with_name("files")
#: Where the source tree has them.
_CHECKED_OUT = Path(__file__).resolve().parents[2] / "experiments"
#: The paper's experiment, as it is submitted.
NINE_ROBOTS = "robotarium_9bot.py"


def examples_folder() -> Path:
    """Return the folder that holds the experiments.

    Raises
    ------
    ParameterError
        Where they did not come along with the package.
    """
    for folder in (_INSTALLED, _CHECKED_OUT):
        if (folder / NINE_ROBOTS).is_file():
            return folder
    raise ParameterError(
        f"{NINE_ROBOTS} is not in {_INSTALLED}: this installation is not complete;"
        " pip install --force-reinstall posflock-robotarium"
    )


def example_files() -> list[Path]:
    """Return the experiments' paths from their folder, sorted."""
    folder = examples_folder()
    return sorted(
        file.relative_to(folder)
        for file in folder.rglob("*")
        if file.is_file() and not {"__pycache__", ".ipynb_checkpoints"} & set(file.parts)
    )


def copy_examples(folder: Path) -> list[Path]:
    """Copy the experiments into a folder, all or none; return the paths of the copies.

    What is there already and equal stays as it is, so that a second call does no harm.

    Parameters
    ----------
    folder : Path
        Made where there is none.

    Raises
    ------
    OutputError
        Where a file of the same name has another content: it may be somebody's work.
    """
    source, names = examples_folder(), example_files()
    contents = {name: (source / name).read_bytes() for name in names}
    for name, content in contents.items():
        place = folder / name
        if place.exists() and (not place.is_file() or place.read_bytes() != content):
            raise OutputError(
                f"{place} is there already and differs from the example; nothing was copied:"
                " name another folder with -o"
            )
    with written_together(folder) as draft:
        for name, content in contents.items():
            write_whole(draft / name, content)
    return [folder / name for name in names]
