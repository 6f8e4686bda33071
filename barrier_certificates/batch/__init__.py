"""Certificates for thousands of teams at once, compiled where numba is installed.

A study, a search for the worst case or a learner steps many small teams, and a step of one team is
a hundred calls of numpy on arrays of nine numbers. `BatchCertificate` takes all teams in one call,
and answers what a single certificate would answer for each. From the outside in:

- `batch_certificate`: arrays in, arrays out; `batch_info`: what was done;
- `certify`: one team after the other; `search`: which rows bind; `active_rows`: their algebra;
- `write_rows`, `layout`: the rows of a team, and what they are made from;
- `headings`: sines and cosines; `compiling`: what is compiled, and where it is kept.
"""

from barrier_certificates.batch.batch_certificate import BatchCertificate
from barrier_certificates.batch.batch_info import STATUSES, BatchInfo
from barrier_certificates.batch.compiling import Engine, numba_is_installed

__all__ = ["STATUSES", "BatchCertificate", "BatchInfo", "Engine", "numba_is_installed"]
