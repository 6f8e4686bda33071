"""Teams for tests of batches, and the comparison with a certificate for each."""

from dataclasses import replace

import numpy as np

from barrier_certificates.batch import STATUSES, BatchCertificate
from barrier_certificates.unicycle import UnicycleCertificate

ARENA = (-1.6, 1.6, -1.0, 1.0)
LIMITS = {"speed_limit": 0.15, "turn_rate_limit": 0.55, "time_step": 0.033}
NINE = UnicycleCertificate(0.2, 2000.0, wall_gain=100.0, boundary=ARENA, **LIMITS)


def states(kind: str, teams: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return unicycle commands (B, 2, 9) and poses (B, 3, 9), wheels asked for a lot."""
    rng = np.random.default_rng(seed)
    grid = np.array(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0])).reshape(2, -1)
    apart, shake = {"packed": (0.215, 0.007), "spread": (0.6, 0.1), "tight": (0.2002, 1e-4)}.get(
        kind, (0.22, 0.01)
    )
    points = apart * grid + rng.uniform(-shake, shake, (teams, 2, 9))
    if kind == "corner":
        points += np.array([1.6 - 0.1 - 0.23, 1.0 - 0.1 - 0.23])[:, None]
    if kind == "random":  # many of them overlap
        points = rng.uniform(-1.0, 1.0, points.shape) * np.array([1.7, 1.05])[:, None]
    heading = rng.uniform(-np.pi, np.pi, (teams, 1, 9))
    ahead = np.concatenate([np.cos(heading), np.sin(heading)], axis=1)
    poses = np.concatenate([points - 0.05 * ahead, heading], axis=1)
    return rng.uniform(-1.0, 1.0, points.shape) * np.array([0.2, 2.0])[:, None], poses


def assert_as_alone(certificate, desired, poses, engine: str, steps: int = 1) -> None:
    """Compare the batch with a certificate a team, moved along the answers."""
    batch = BatchCertificate(certificate, engine=engine)
    alone = [replace(certificate) for _ in poses]
    for _ in range(steps):
        commands, info = batch(desired, poses)
        for team, single in enumerate(alone):
            command, told = single(desired[team], poses[team])
            np.testing.assert_allclose(commands[team], command, rtol=0, atol=1e-8)
            assert STATUSES[int(info.status[team])] == told.status
            assert info.unsafe_start[team] == told.unsafe_start
            for name in ("violation", "intervention", "clearance", "smallest_h"):
                expected = getattr(told, name)
                np.testing.assert_allclose(getattr(info, name)[team], expected, atol=1e-8)
        heading = poses[:, 2]
        way = np.stack([commands[:, 0] * np.cos(heading), commands[:, 0] * np.sin(heading)], axis=1)
        poses = poses + 0.033 * np.concatenate([way, commands[:, 1:]], axis=1)


def main() -> None:
    """Compare in plain Python, where compiling is switched off."""
    for kind in ("spread", "packed", "corner", "random"):
        assert_as_alone(NINE, *states(kind, 2), "numba", steps=2)
    print("as alone")


if __name__ == "__main__":
    main()
