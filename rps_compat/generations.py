"""The two generations of the Robotarium's Python API, which every part of this package tells apart.

Generation 1 is the API of October 2019 to April 2026, generation 2 the one that the testbed runs
since.
"""

from typing import Literal

Generation = Literal[1, 2]
