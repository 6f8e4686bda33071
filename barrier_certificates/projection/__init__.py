"""The safe velocity nearest to the desired one, exactly, and what to do where there is none.

`Projector` solves ``min ‖v − v̂‖²`` over the rows of a team: `working_set` finds the optimum, or
that there is none, from a handful of the rows; `scaled_program` puts a program of large numbers
into a unit in which tolerances mean something; `infeasible` is the *policy* for states without a
safe velocity; `projection_info` is the report. Whoever solved, every row is checked before an
answer is returned.
"""

from barrier_certificates.projection.infeasible import Policy
from barrier_certificates.projection.projection_info import ProjectionInfo, Status
from barrier_certificates.projection.projector import Projector

__all__ = ["Policy", "ProjectionInfo", "Projector", "Status"]
