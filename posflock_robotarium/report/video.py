"""A replay as a film: MP4 by ffmpeg, GIF by Pillow.

The arena is drawn once. Each frame restores that background and draws only what moves (blitting),
then goes straight into the encoder: memory does not grow with the length of the film.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from barrier_certificates.ties import TIE
from posflock_robotarium.figures.style import BLUE, GREY
from posflock_robotarium.flocking.errors import OutputError, ParameterError
from posflock_robotarium.logs.plausibility import believed
from posflock_robotarium.logs.readers import Run
from rps_compat.testbed import GTERNAL, ROBOT_LENGTH, ROBOT_WIDTH, RobotModel
from rps_compat.whole_files import atomic_write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image as Picture

Floats = NDArray[np.float64]
Frame = NDArray[np.uint8]

SIZE = {".mp4": (840, 560), ".gif": (640, 426)}
"""Pixels."""

RATE = {".mp4": 20.0, ".gif": 12.5}
"""Frames a second."""

TRAIL = 10.0
"""Seconds of trail behind each robot."""

LARGEST_FILM = 36_000
"""Frames beyond which a film is refused (20 minutes at 30 a second)."""


def write_video(
    recording: Run,
    path: Path,
    *,
    fps: float | None = None,
    speed: float = 1.0,
    robot: RobotModel = GTERNAL,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Film a run.

    Parameters
    ----------
    recording : Run
        Poses over time; a gap is shown as the last pose before it; a robot is not shown while it is
        not seen.
    path : Path
        Ends in ``.mp4`` or ``.gif``.
    fps : float, optional
        Frames a second; 20 for MP4, 12.5 for GIF.
    speed : float
        Seconds of the run a second of film.
    robot : RobotModel
        Whose arena is drawn.
    progress : callable, optional
        Called with frames done and frames in all.

    Returns
    -------
    Path
        Where the film was written.

    Raises
    ------
    ParameterError
        For another ending, or a rate that is not positive.
    OutputError
        When the film cannot be written, or no ffmpeg is there for MP4.
    """
    recording, kind = believed(recording), path.suffix.lower()
    if kind not in SIZE:
        raise ParameterError(f"{path}: expected a name that ends in .mp4 or .gif")
    rate = RATE[kind] if fps is None else fps
    if not (np.isfinite(rate) and 0 < rate <= 100 and np.isfinite(speed) and speed > 0):
        raise ParameterError(f"{rate} frames a second at speed {speed}; expected both above 0")
    times = np.arange(recording.t[0], recording.t[-1] + TIE, speed / rate)
    if len(times) > LARGEST_FILM:
        raise ParameterError(f"{len(times)} frames; raise --speed or lower --fps")
    drawn = _frames(recording, times, robot, SIZE[kind])
    encode = _encode_mp4 if kind == ".mp4" else _encode_gif
    with atomic_write(path) as draft:
        encode(drawn, draft, rate, len(times), progress)
    return path


def _frames(
    recording: Run, times: Floats, robot: RobotModel, size: tuple[int, int]
) -> Iterator[Frame]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.transforms import Bbox

    width, height = size
    figure, axes = _arena(robot, size)
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves it untyped
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)

    trails = LineCollection([], colors=GREY, linewidths=1.0, alpha=0.7)
    # All bodies, then all arrowheads on them, in one collection: its overhead is paid once.
    robots = PolyCollection(
        [],
        facecolors=[BLUE] * recording.robots + ["white"] * recording.robots,
        edgecolors=["black"] * recording.robots + ["none"] * recording.robots,
        linewidths=0.5,
    )
    for collection in (trails, robots):
        axes.add_collection(collection, autolim=False)
    clock = figure.text(0.015, 0.955, "", fontsize=13, family="monospace")
    corner = Bbox.from_bounds(0, int(0.94 * height), int(0.3 * width), int(0.06 * height))
    told = None
    rows = np.clip(np.searchsorted(recording.t, times + TIE, side="right") - 1, 0, None)
    for time, row in zip(times, rows, strict=True):
        robots.set_verts(_bodies(recording.poses[row]))
        trails.set_segments(_trails(recording, time, int(row)))
        if told != (told := f"{time:6.1f} s"):
            clock.set_text(told)
            canvas.restore_region(background)
            figure.draw_artist(clock)
            clock_drawn = canvas.copy_from_bbox(corner)
        canvas.restore_region(background)
        canvas.restore_region(clock_drawn)
        axes.draw_artist(trails)
        axes.draw_artist(robots)
        yield np.asarray(canvas.buffer_rgba())


def _arena(robot: RobotModel, size: tuple[int, int]) -> tuple[Figure, Axes]:
    """Return a figure of so many pixels that shows the walls alone."""
    from matplotlib.figure import Figure

    width, height = size
    left, right, bottom, top = robot.boundaries
    figure = Figure(figsize=(9.6, 9.6 * height / width), dpi=width / 9.6)
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.92))
    axes.set(xlim=(left - 0.05, right + 0.05), ylim=(bottom - 0.05, top + 0.05))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], "k", lw=1.5)
    return figure, axes


_BODY = np.array([[1, -1, -1, 1], [1, 1, -1, -1]]) * [[ROBOT_LENGTH / 2], [ROBOT_WIDTH / 2]]
_ARROW = np.array([[0.85, -0.65, -0.3, -0.65], [0, 0.7, 0, -0.7]]) * [
    [ROBOT_LENGTH / 2],
    [ROBOT_WIDTH / 2],
]


def _bodies(poses: Floats) -> list[Floats]:
    """Return the corners of each robot's body, then of each arrowhead, (4, 2) each, metres."""
    x, y, heading = poses
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    place = np.stack([x, y], axis=1)[:, np.newaxis]
    corners = [np.einsum("ijn,jk->nki", turn, shape) + place for shape in (_BODY, _ARROW)]
    return list(np.concatenate(corners))


def _trails(recording: Run, time: float, row: int) -> list[Floats]:
    """Return where each robot has been of late, (K, 2) each, metres."""
    first = int(np.searchsorted(recording.t, time - TRAIL))
    stride = max(1, (row - first) // 60)
    # The samples of a trail stay the same from frame to frame: it grows, it does not shimmer.
    first += -first % stride
    path = recording.poses[np.append(np.arange(first, row, stride), row), :2]
    return list(path.transpose(2, 0, 1))


def find_ffmpeg() -> str:
    """Return an ffmpeg: the one on the PATH, or the one of the extra ``video``.

    Raises
    ------
    OutputError
        When there is neither; says what to install.
    """
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError) as error:
        raise OutputError(
            "no ffmpeg for MP4; install it, or pip install 'posflock-robotarium[video]', "
            "or write a .gif"
        ) from error


def _encode_mp4(
    frames: Iterator[Frame],
    path: Path,
    rate: float,
    total: int,
    progress: Callable[[int, int], None] | None,
) -> None:
    command = [
        find_ffmpeg(),
        "-loglevel",
        "error",
        "-y",
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgba",
        "-s",
        "{}x{}".format(*SIZE[".mp4"]),
        "-r",
        f"{rate:g}",
        "-i",
        "-",
        "-an",
        "-c:v",
        "libx264",
        "-preset",
        "veryfast",
        "-crf",
        "23",
        "-pix_fmt",
        "yuv420p",
        "-movflags",
        "+faststart",
        "-f",
        "mp4",
        str(path.resolve()),
    ]
    # ffmpeg's complaints go to a file: a pipe that nobody reads while frames go in could fill up.
    with tempfile.TemporaryFile() as complaints:
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=complaints)
        assert encoder.stdin is not None
        try:
            for done, frame in enumerate(frames, start=1):
                encoder.stdin.write(frame.data)
                if progress is not None:
                    progress(done, total)
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # it has stopped; its complaint says why
        except BaseException:
            encoder.kill()
            encoder.wait()
            raise
        if encoder.wait() != 0:
            complaints.seek(0)
            said = complaints.read().decode(errors="replace").strip()
            raise OSError(None, f"ffmpeg failed: {said[-500:]}")


def _encode_gif(
    frames: Iterator[Frame],
    path: Path,
    rate: float,
    total: int,
    progress: Callable[[int, int], None] | None,
) -> None:
    from PIL import Image

    palette = _palette()

    def images() -> Iterator[Picture]:
        for done, frame in enumerate(frames, start=1):
            picture = Image.fromarray(frame).convert("RGB")
            if progress is not None:
                progress(done, total)
            yield picture.quantize(palette=palette, dither=Image.Dither.NONE)

    stream = images()
    first = next(stream)
    first.save(
        path,
        format="GIF",
        save_all=True,
        append_images=stream,
        duration=round(1000 / rate),
        loop=0,
        optimize=False,
    )


def _palette() -> Picture:
    """Return the arena's few colours and what lies between them: one palette for all frames."""
    from PIL import Image

    def mixed(a: tuple[int, ...], b: tuple[int, ...]) -> Any:
        return np.linspace(a, b, 8).round().astype(int)

    blue = tuple(int(BLUE[k : k + 2], 16) for k in (1, 3, 5))
    grey = tuple(int(GREY[k : k + 2], 16) for k in (1, 3, 5))
    white, black = (255, 255, 255), (0, 0, 0)
    colours = np.concatenate(
        [mixed(white, black), mixed(white, blue), mixed(white, grey), mixed(blue, black)]
    )
    picture = Image.new("P", (1, 1))
    picture.putpalette(colours.astype(np.uint8).tobytes())
    return picture
