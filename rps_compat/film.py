"""Pictures of a run while it runs: snapshots at given times, and a video."""

import io
import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from barrier_certificates.ties import reached
from rps_compat.errors import RobotariumError
from rps_compat.whole_files import atomic_write, write_whole

#: Frames per second of the run, and of the film: it plays in real time.
FRAMES = {".mp4": 20, ".gif": 10}
#: Length of the bar that tells the scale of a snapshot, m.
_BAR = 0.5
_BAR_LOOK: dict[str, Any] = {
    "xycoords": "axes fraction",
    "textcoords": "axes fraction",
    "arrowprops": {"arrowstyle": "|-|,widthA=0.25,widthB=0.25", "shrinkA": 0, "shrinkB": 0},
    "annotation_clip": False,
}


class FilmError(RobotariumError):
    """A video cannot be made: unknown ending, or no encoder."""


class Film:
    """Takes pictures of one instance at times of the run.

    Parameters
    ----------
    snapshots
        Times in seconds, infinity for the end of the run.
    folder
        Where ``snapshot-TIME.png`` and ``.pdf`` go.
    video
        File to film to, ending in .mp4 or .gif; None films nothing.

    Attributes
    ----------
    files : list of Path
        Pictures taken so far, and the video.
    """

    def __init__(self, snapshots: Sequence[float], folder: Path, video: Path | None) -> None:
        self.files: list[Path] = []
        self._due = sorted(snapshots)
        self._folder = folder
        self._writer: Any = None
        self._frame, self._time = math.inf, 0.0
        self._stack = ExitStack()
        if video is not None:
            self._writer, self._per_second = _writer(video), FRAMES[video.suffix.lower()]
            self._video, self._frame = video, 0.0

    @property
    def idle(self) -> bool:
        """Whether nothing is left to be taken."""
        return not self._due and self._writer is None

    def at(self, time: float, instance: Any) -> None:
        """Take what is due.

        Parameters
        ----------
        time : float
            Time of the run, s.
        instance : Robotarium
            Whose picture is taken.
        """
        self._time = time
        while self._due and reached(time, self._due[0]):
            self._snapshot(instance, self._due.pop(0))
        if reached(time, self._frame):
            if self._frame == 0.0:
                # Left in turn: first the encoder finishes, then the film takes its name.
                draft = self._stack.enter_context(atomic_write(self._video))
                self._stack.enter_context(
                    self._writer.saving(figure_of(instance), str(draft), dpi=100)
                )
                self.files.append(self._video)
            self._writer.grab_frame()
            self._frame += 1 / self._per_second

    def end(self, instance: Any | None) -> None:
        """Take the snapshot of the end, if asked for, and finish the video.

        Parameters
        ----------
        instance : Robotarium or None
            Whose picture is taken; None where there was none.
        """
        if instance is not None and math.inf in self._due:
            self._snapshot(instance, math.inf)
        self._due = []
        self._stack.close()
        self._writer, self._frame = None, math.inf

    def _snapshot(self, instance: Any, time: float) -> None:
        name = "end" if math.isinf(time) else f"{time:g}s"
        with _measured(figure_of(instance), instance._picture.axes, self._time) as figure:
            for kind in ("png", "pdf"):
                drawn = io.BytesIO()  # where a disk is full, matplotlib says something else
                # No dates inside: the same run gives the same bytes.
                dates = {"CreationDate": None, "Producer": None} if kind == "pdf" else None
                figure.savefig(drawn, format=kind, dpi=150, metadata=dates)
                path = self._folder / f"snapshot-{name}.{kind}"
                write_whole(path, drawn.getvalue())
                self.files.append(path)


@contextmanager
def _measured(figure: Any, axes: Any, time: float) -> Iterator[Any]:
    """Give the picture axes in metres, a scale bar and the time, and take all of them off again.

    What the script drew, and what it set itself on the axes, stays as it is.
    """
    place, shown = axes.get_position(original=True), axes.axison
    labels = axes.get_xlabel(), axes.get_ylabel()
    left, right = axes.get_xlim()
    width, height = figure.get_size_inches()
    # Room in inches: 0.8 for the numbers on the left, 0.55 below, 0.45 above.
    axes.set_position((0.8 / width, 0.55 / height, 1 - 0.95 / width, 1 - 1.0 / height))
    axes.set_axis_on()
    axes.set(xlabel=labels[0] or "x (m)", ylabel=labels[1] or "y (m)")
    within = axes.transAxes
    length = _BAR / abs(right - left)
    added = [
        axes.text(0.0, 1.04, f"t = {time:.1f} s", fontsize=11, transform=within),
        axes.annotate("", (1.0 - length, 1.045), (1.0, 1.045), **_BAR_LOOK),
        axes.text(
            1.0 - length / 2, 1.055, f"{_BAR:g} m", ha="center", fontsize=9, transform=within
        ),
    ]
    try:
        yield figure
    finally:
        for artist in added:
            artist.remove()
        axes.set(xlabel=labels[0], ylabel=labels[1])
        axes.set_position(place)
        (axes.set_axis_on if shown else axes.set_axis_off)()


def figure_of(instance: Any) -> Any:
    """Return the figure of an instance, made now if it had none.

    Parameters
    ----------
    instance : Robotarium
        Of either generation.
    """
    return instance._fig if hasattr(type(instance), "TIME_STEP") else instance.figure


def _writer(video: Path) -> Any:
    from matplotlib import animation, rcParams

    suffix = video.suffix.lower()
    if suffix not in FRAMES:
        raise FilmError(f"{video}: expected a name that ends in .mp4 or .gif")
    if suffix == ".gif":
        return animation.PillowWriter(fps=FRAMES[suffix])
    if not animation.FFMpegWriter.isAvailable():
        try:
            import imageio_ffmpeg
        except ImportError:
            raise FilmError(
                f"{video}: no ffmpeg was found; install it, or pip install "
                "'posflock-robotarium[video]', or ask for a .gif"
            ) from None
        rcParams["animation.ffmpeg_path"] = imageio_ffmpeg.get_ffmpeg_exe()
    return animation.FFMpegWriter(fps=FRAMES[suffix], bitrate=1800)
