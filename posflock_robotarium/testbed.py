"""The real testbed as data: what it accepts, where its limits are.

Read in the Robotarium's published guide, simulators and firmware, and in logs that users
published in 2026.  Everything that judges a submission (verify, bundle, rehearse) takes its
numbers from here; what is installed there stands in :mod:`rps_compat.scripts.libraries`.
"""

#: Endings that may be uploaded.
ENDINGS = (
    ".py .m .mat .npy .jpg .jpeg .png .gif .tiff .bmp .mexa64".split()  # noqa: SIM905
)

MAX_ROBOTS = 20
#: Seconds after which any experiment ends.
MAX_DURATION = 900.0
#: A run that takes this many times its declared duration is refused.
OVERRUN = 1.5
TIME_STEP = 0.033
#: Seconds without a command after which a robot brakes.
WATCHDOG = 0.5
#: Advice for the distance of two robots' centres, metres.
SPACING = 0.15
#: Driving to the initial conditions took this long in ten published runs: least, median, most.
INITIAL_DRIVE = (34.0, 91.0, 192.0)
#: Violations of a kind beyond which the published verifiers refuse a script.
TOLERATED_VIOLATIONS = 100
