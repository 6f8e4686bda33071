"""The recorded optima of every published certificate are reproduced, each from its own rows."""

import pytest
from recorded_certificates import check, load

CASES = load()
FAMILIES = sorted({case["id"].rpartition("/")[0] for case in CASES})


@pytest.mark.parametrize("solver", ["auto", "nnls"])
@pytest.mark.parametrize("family", FAMILIES)
def test_recorded_optima_are_reproduced(family, solver):
    for case in CASES:
        if case["id"].rpartition("/")[0] == family:
            check(case, solver)


def test_every_family_of_rows_is_covered():
    assert len(CASES) > 450
    for key in ("octagon", "boundary", "wheels", "unsafe_gain", "scaled_to"):
        assert any(key in case for case in CASES)
    assert any(case["obstacles"].size for case in CASES)
