"""Axes that put off making artists until somebody sees them.

Scripts plot in every step: a trail, a label, a marker. Matplotlib takes half a millisecond and more
to make one artist, ten times a step of the simulator, and headless nobody looks. So from the
fourth call on, ``plot``, ``scatter``, ``text`` and ``arrow`` only note what was asked, with the
data as they are now. All is made, in order, when the axes are drawn or their contents asked for.
What the calls return stands for the artist, and becomes it at the first use of an attribute; an
artist that is removed before anybody saw it is never made.

The first three calls are carried out at once, so that a wrong argument fails where it is written.
"""

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib import axes as mpl_axes
from matplotlib.collections import PathCollection
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrow
from matplotlib.text import Text

#: Calls of each method that are carried out at once.
EAGER = 3

_CLASSES = {"plot": Line2D, "scatter": PathCollection, "text": Text, "arrow": FancyArrow}


class _Call:
    """A call that was put off; `artist` is what it made, once it is made."""

    __slots__ = ("args", "artist", "axes", "gone", "kwargs", "method")

    def __init__(self, axes: "Axes", method: str, args: Any, kwargs: Any) -> None:
        self.axes, self.method = axes, method
        self.args = [_frozen(argument) for argument in args]
        self.kwargs = {name: _frozen(value) for name, value in kwargs.items()}
        self.artist: Any = None
        self.gone = False

    def make(self) -> Any:
        """Make the artist, and all that were put off before it."""
        if self.gone:
            raise ValueError(f"the artist of this {self.method}() was removed")
        if self.artist is None:
            self.axes.catch_up()
        return self.artist

    def carry_out(self) -> None:
        """Make the artist; for one that was removed, only take its colour from the cycle."""
        if self.gone:
            axes: Any = self.axes
            cycle = axes._get_lines if self.method == "plot" else axes._get_patches_for_fill
            cycle.get_next_color()
            return
        made = getattr(mpl_axes.Axes, self.method)(self.axes, *self.args, **self.kwargs)
        self.artist = made[0] if self.method == "plot" and len(made) == 1 else made

    def colored(self) -> bool:
        """Whether the call says its colour, so that leaving it out shifts no colour cycle."""
        if self.method in ("text", "arrow") or {"c", "color", "facecolors"} & self.kwargs.keys():
            return True
        return self.method == "plot" and any(
            isinstance(word, str) and set(word) & set("bgrcmykw") for word in self.args
        )


def _frozen(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.copy()
    return copy.deepcopy(value) if isinstance(value, list) else value


class PutOff:
    """Stands for the artist of a call that was put off.

    Parameters
    ----------
    call : _Call
        What was asked for, to be done when the artist is seen or used.
    """

    def __init__(self, call: _Call) -> None:
        object.__setattr__(self, "_call", call)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._call.make(), name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._call.make(), name, value)

    def remove(self) -> None:
        """Remove the artist; if nobody saw it, it is never made."""
        call = self._call
        if call.artist is None and not call.gone:
            call.axes.forget(call)
        else:
            call.make().remove()

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        return _CLASSES[self._call.method]

    def __eq__(self, other: object) -> bool:
        if isinstance(other, PutOff) or type(other) is PutOff:
            return self is other
        made = self._call.artist
        return made is not None and made is other

    def __hash__(self) -> int:
        return id(self)


class PutOffLines(list[Any]):
    """Stands for the list that ``plot`` returns.

    Parameters
    ----------
    call : _Call
        What was asked for, to be done when a line is seen or used.
    """

    def __init__(self, call: _Call) -> None:
        super().__init__()
        self._call: _Call | None = call

    def _fill(self) -> None:
        call, self._call = self._call, None
        if call is not None:
            if _single(call.args):
                self.append(PutOff(call))
            else:
                made = call.make()
                self.extend(made if isinstance(made, list) else [made])

    def __iter__(self) -> Iterator[Any]:
        self._fill()
        return super().__iter__()

    def __len__(self) -> int:
        self._fill()
        return super().__len__()

    def __getitem__(self, index: Any) -> Any:
        self._fill()
        return super().__getitem__(index)

    def pop(self, index: Any = -1) -> Any:
        """Take out one line.

        Parameters
        ----------
        index : int
            Which line; the last by default.
        """
        self._fill()
        return super().pop(index)


def _made(handles: Any) -> Any:
    if isinstance(handles, list | tuple):
        return [handle._call.make() if type(handle) is PutOff else handle for handle in handles]
    return handles


def _single(args: list[Any]) -> bool:
    """Whether a call of ``plot`` with these arguments makes exactly one line."""
    data = [argument for argument in args if not isinstance(argument, str)]
    formats = len(args) - len(data)
    if not 1 <= len(data) <= 2 or formats > 1:
        return False
    return all(np.ndim(argument) <= 1 for argument in data)


class Axes(mpl_axes.Axes):
    """Matplotlib's axes, but `plot`, `scatter`, `text` and `arrow` are put off.

    Parameters
    ----------
    *args, **kwargs
        As for `matplotlib.axes.Axes`.

    Attributes
    ----------
    puts_off : bool
        Whether calls are put off at all; in a window they are not.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._pending: list[_Call] = []
        self._calls = dict.fromkeys(_CLASSES, 0)
        self.puts_off = True
        super().__init__(*args, **kwargs)

    @property
    def _children(self) -> list[Any]:
        if self._pending:
            self.catch_up()
        made: list[Any] = self.__dict__["_made"]
        return made

    @_children.setter
    def _children(self, artists: list[Any]) -> None:
        self.__dict__["_made"] = artists

    def catch_up(self) -> None:
        """Carry out what was put off, in order."""
        pending, self._pending = self._pending, []
        for call in pending:
            call.carry_out()

    def forget(self, call: _Call) -> None:
        """Drop a call that was put off, all but the colour that it takes from the cycle.

        Parameters
        ----------
        call : _Call
            The call; nobody has used its artist.
        """
        call.gone, colored = True, call.colored()
        call.args, call.kwargs = [], {}
        if colored:
            self._pending.remove(call)

    def _put_off(self, method: str, args: Any, kwargs: Any) -> _Call | None:
        self._calls[method] += 1
        if self._calls[method] <= EAGER or not self.puts_off or "data" in kwargs:
            return None
        call = _Call(self, method, args, kwargs)
        self._pending.append(call)
        return call

    def plot(self, *args: Any, **kwargs: Any) -> Any:
        """Plot lines or markers, now or when they are seen.

        Parameters
        ----------
        *args, **kwargs
            As for the same method of `matplotlib.axes.Axes`.
        """
        call = self._put_off("plot", args, kwargs)
        return super().plot(*args, **kwargs) if call is None else PutOffLines(call)

    def scatter(self, *args: Any, **kwargs: Any) -> Any:
        """Plot markers, now or when they are seen.

        Parameters
        ----------
        *args, **kwargs
            As for the same method of `matplotlib.axes.Axes`.
        """
        call = self._put_off("scatter", args, kwargs)
        return super().scatter(*args, **kwargs) if call is None else PutOff(call)

    def text(self, *args: Any, **kwargs: Any) -> Any:
        """Write, now or when it is seen.

        Parameters
        ----------
        *args, **kwargs
            As for the same method of `matplotlib.axes.Axes`.
        """
        call = self._put_off("text", args, kwargs)
        return super().text(*args, **kwargs) if call is None else PutOff(call)

    def arrow(self, *args: Any, **kwargs: Any) -> Any:
        """Draw an arrow, now or when it is seen.

        Parameters
        ----------
        *args, **kwargs
            As for the same method of `matplotlib.axes.Axes`.
        """
        call = self._put_off("arrow", args, kwargs)
        return super().arrow(*args, **kwargs) if call is None else PutOff(call)

    def legend(self, *args: Any, **kwargs: Any) -> Any:
        """Make a legend, which needs the artists themselves.

        Parameters
        ----------
        *args, **kwargs
            As for the same method of `matplotlib.axes.Axes`.
        """
        made = [_made(argument) for argument in args]
        return super().legend(*made, **{name: _made(value) for name, value in kwargs.items()})

    def _sci(self, im: Any) -> None:
        if type(im) is PutOff:  # plt.scatter makes its artist the current image
            self._current_image = im
        else:
            super()._sci(im)

    def _unstale_viewLim(self) -> None:  # noqa: N802 - matplotlib's own
        if self._pending and (self.get_autoscalex_on() or self.get_autoscaley_on()):
            self.catch_up()
        super()._unstale_viewLim()  # type: ignore[misc]

    def clear(self) -> None:
        """Remove all artists, made or put off."""
        for call in self._pending:
            call.gone = True
        self._pending = []
        super().clear()
