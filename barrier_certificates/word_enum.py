"""Enums whose members are words: what `enum.StrEnum` is from Python 3.11 on."""

from enum import Enum


class WordEnum(str, Enum):
    """An enum of words: a member equals its word, and is printed and stored as it."""

    def __str__(self) -> str:
        return str(self.value)
