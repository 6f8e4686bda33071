r"""What must hold: linear rows :math:`a^\top v \le b` on the velocities of a team.

A *control barrier function* ``h`` is positive where a team is safe. Keeping :math:`\dot h \ge
-\gamma h^3` at every moment keeps ``h`` positive for ever, and because :math:`\dot h` is linear in
the velocities, the condition is one linear row. Five kinds of rows cover a team in an arena:

=========  ==================================================  ==================================
kind       barrier                                             row
=========  ==================================================  ==================================
pair       h = ‖xᵢ − xⱼ‖² − r²                                 −2D·vᵢ + 2D·vⱼ ≤ γ h³, D = xᵢ − xⱼ
obstacle   h = ‖xᵢ − c‖² − R², c the obstacle's nearest point  −2D·vᵢ + 2D·ċ ≤ γ h³,  D = xᵢ − c
wall       g = distance to the wall − margin                   n·vᵢ ≤ 0.4 γ g³, n out of the arena
link       h = R² − ‖xᵢ − xⱼ‖²                                 2D·vᵢ − 2D·vⱼ ≤ γ h³,  D = xᵢ − xⱼ
limit      (none: what the motors can do)                      n·vᵢ ≤ b, for each side of a polygon
=========  ==================================================  ==================================

Every row is scaled to unit norm, so how far a row is broken is a speed in m/s, whatever its kind,
and one tolerance serves all.

Each kind is a `RowFamily` with a module of its own: `pairs`, `walls`, `obstacles`, `links`,
`limits`; all but the last can allow for a `disturbance` of the wheels. Where robots are not alike,
walls and obstacles take a number for each; pairs and limits are those of `unequal_pairs` and
`unequal_limits`. Which links a team keeps is decided by `kept_links`. `row_book` writes all rows of
a team into arrays that live from step to step, `linked_book` those of a team that stays connected,
and `row_set` is what those arrays are to whoever solves. Nothing here knows a solver.
"""

from barrier_certificates.rows.disturbance import WheelDisturbance
from barrier_certificates.rows.kept_links import ConnectivityParameters
from barrier_certificates.rows.limits import LimitRows, VelocityPolygon
from barrier_certificates.rows.obstacles import Disc, Obstacle, ObstacleRows, Segment
from barrier_certificates.rows.pairs import PairRows
from barrier_certificates.rows.row_book import Margin, RowBook
from barrier_certificates.rows.row_family import Barrier, RowFamily, Scene
from barrier_certificates.rows.row_set import Rows
from barrier_certificates.rows.unequal_limits import UnequalLimitRows
from barrier_certificates.rows.unequal_pairs import UnequalPairRows
from barrier_certificates.rows.walls import WallRows, polygon, rectangle

__all__ = [
    "Barrier",
    "ConnectivityParameters",
    "Disc",
    "LimitRows",
    "Margin",
    "Obstacle",
    "ObstacleRows",
    "PairRows",
    "RowBook",
    "RowFamily",
    "Rows",
    "Scene",
    "Segment",
    "UnequalLimitRows",
    "UnequalPairRows",
    "VelocityPolygon",
    "WallRows",
    "WheelDisturbance",
    "polygon",
    "rectangle",
]
