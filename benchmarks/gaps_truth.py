"""The table of the docs: γ of flocks of known γ, seen badly, and the error that is stated."""

from __future__ import annotations

import sys

from posflock_robotarium.alignment.disturbed import DisturbedError, errors_of


def table(found: list[DisturbedError]) -> list[str]:
    """Return the lines of a Markdown table: a row a disturbance, a column a motion."""
    motions = list(dict.fromkeys(each.motion for each in found))
    truths = {each.motion: each.truth for each in found}
    heads = [f"{motion}, γ {truths[motion]:.4f}" for motion in motions]
    lines = ["| what happened to the log | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1)]
    lines[1] += "|"
    for name in dict.fromkeys(each.disturbance for each in found):
        cells = [
            f"{each.error:+.4f} (±{each.stated:.4f})" + ("" if each.holds else " **!**")
            for each in found
            if each.disturbance == name
        ]
        lines.append(f"| {name} | {' | '.join(cells)} |".replace("-0.0000", "0.0000"))
    return [line.replace("+0.0000", "0.0000") for line in lines]


def main() -> int:
    found = errors_of()
    print("\n".join(table(found)))
    beyond = [each for each in found if not each.holds]
    print(f"\n{len(found) - len(beyond)} of {len(found)} errors are within what is stated")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
