"""Artists that are put off look, count and behave as if they had been made at once."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rps_compat.axes import EAGER, Axes

mpl.use("Agg")


def canvas(puts_off):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = Figure(figsize=(3, 2))
    FigureCanvasAgg(figure)
    axes = Axes(figure, 1, 1, 1)
    figure.add_subplot(axes)
    axes.puts_off = puts_off
    axes.set(xlim=(-2, 2), ylim=(-2, 2))
    return axes


def pixels(axes):
    axes.figure.canvas.draw()
    return np.asarray(axes.figure.canvas.buffer_rgba()).copy()


def script(axes):
    """What scripts do with axes, all of it, in a loop."""
    trail, labels, where = [], [], np.zeros(3)
    for k in range(EAGER + 12):
        where[:] = 0.1 * k - 1, 0.5 - 0.1 * k, 0.3
        (line,) = axes.plot(where[:2], [0, 1])
        trail.append(line)
        if len(trail) > 4:
            trail.pop(0).remove()
        axes.plot([0, where[0]], [0, 0], "r--", [0, 0], [0, where[1]], "g:")
        points = axes.scatter(where, where[::-1], s=9)
        points.set_offsets(np.array([where[:2]]))
        label = axes.text(where[0], where[1], f"robot {k}")
        labels.append(label)
        if k % 3 == 0:
            labels.pop().remove()
        axes.scatter(where[0], where[1], c="k").remove()
        axes.arrow(0, 0, where[0] / 2, where[1] / 2, head_width=0.1)
    axes.legend(trail[-2:], ["one", "two"])


def test_the_picture_is_the_same():
    now, later = canvas(False), canvas(True)
    script(now)
    script(later)
    assert (pixels(now) == pixels(later)).all()


def test_contents_are_the_same():
    now, later = canvas(False), canvas(True)
    script(now)
    script(later)
    for kind in ("lines", "collections", "texts", "patches"):
        ours, theirs = list(getattr(later, kind)), list(getattr(now, kind))
        assert [type(a) for a in ours] == [type(a) for a in theirs]


def test_nothing_is_made_before_somebody_looks():
    axes = canvas(True)
    for k in range(100):
        artist = axes.scatter(k, k)
    assert len(axes.__dict__["_made"]) == EAGER
    assert isinstance(axes.plot([0, 1])[0], Line2D)
    assert artist in axes.collections
    assert len(axes.__dict__["_made"]) >= 100


def test_data_are_those_of_the_call():
    axes, where = canvas(True), np.zeros(2)
    for k in range(EAGER + 3):
        where[:] = k
        axes.plot(where, [0, 1], "b-")
    assert [line.get_xdata()[0] for line in axes.lines] == list(range(EAGER + 3))


def test_wrong_arguments_fail_where_they_are_written():
    with pytest.raises(ValueError, match="same first dimension"):
        canvas(True).plot([1, 2, 3], [1, 2])


def test_what_was_removed_is_gone():
    axes = canvas(True)
    for _ in range(EAGER + 1):
        (line,) = axes.plot([0, 1], "r-")
    line.remove()
    assert len(axes.lines) == EAGER
    with pytest.raises(ValueError, match="removed"):
        line.set_data([0], [0])
