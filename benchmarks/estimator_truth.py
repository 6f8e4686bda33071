"""The table of the docs: error of every estimator of γ against flocks of known γ."""

from __future__ import annotations

import sys

from posflock_robotarium.alignment.truth import EstimatorError, errors

NAMES = {"headings": "headings", "motion": "Savitzky-Golay", "differences": "raw differences"}
LEAST_PARALLEL = 0.999


def table(found: list[EstimatorError]) -> list[str]:
    """Return the lines of a Markdown table."""
    lines = [
        "| motion | speed (m/s) | true γ | " + " | ".join(NAMES.values()) + " |",
        "|---|---|---|---|---|---|",
    ]
    for k in range(0, len(found), 3):
        row = found[k : k + 3]
        truth = row[0].truth
        cells = [
            f"undefined, {e.left_out:.0%} left out"
            if e.estimate != e.estimate
            else f"{e.estimate:.4f}, {e.left_out:.0%} left out"
            if e.truth != e.truth
            else f"{e.error:+.5f}"
            for e in row
        ]
        lines.append(f"| {row[0].motion} | {row[0].speed:g} | {truth:.4f} | {' | '.join(cells)} |")
    return [line.replace("-0.00000", "0.00000").replace("+0.00000", "0.00000") for line in lines]


def main() -> int:
    found = errors()
    print("\n".join(table(found)))
    parallel = [e for e in found if e.motion == "parallel" and e.estimator == "motion"]
    worst = min(e.estimate for e in parallel)
    print(f"\nSavitzky-Golay γ of parallel robots: {worst:.5f}, required {LEAST_PARALLEL}")
    return 0 if worst >= LEAST_PARALLEL else 1


if __name__ == "__main__":
    sys.exit(main())
