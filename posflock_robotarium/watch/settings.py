"""How a watched run is set: what the command was told, and what pages have changed since."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from posflock_robotarium.watch.requests import (
    Go,
    PageRequest,
    Pause,
    Retune,
    Speed,
    Step,
    UseProfile,
)


@dataclass(frozen=True)
class Settings:
    """What a page can change, as it is set.

    Attributes
    ----------
    speed : float or None
        How many times as fast as real time; None is as fast as it computes.
    paused : bool
        Whether the simulation is held.
    profile : str
        Name of the robots' realism profile.
    law : Retune
        What is asked of the flock; what is None is the script's own.
    """

    speed: float | None = 1.0
    paused: bool = False
    profile: str = "ideal"
    law: Retune = field(default_factory=Retune)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, ready for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Settings:
        """Return the settings that `as_dict` gave, or JSON of it.

        Parameters
        ----------
        data : mapping
            What it gave.
        """
        return replace(cls(**{**data, "law": Retune()}), law=Retune(**data["law"]))

    def after(self, request: PageRequest) -> Settings:
        """Return the settings once a request is obeyed.

        Parameters
        ----------
        request : PageRequest
            What is asked.
        """
        if isinstance(request, (Pause, Step)):
            return replace(self, paused=True)
        if isinstance(request, Go):
            return replace(self, paused=False)
        if isinstance(request, Speed):
            return replace(self, speed=request.factor)
        if isinstance(request, UseProfile):
            return replace(self, profile=request.name)
        if isinstance(request, Retune):
            return replace(self, law=request.over(self.law))
        return self
