"""The map between the unit cube and a box of parameters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from stribeck.space import Param, Space, box

BOUND = st.floats(-1e9, 1e9)
UNIT = st.floats(0.0, 1.0)


@given(lower=BOUND, upper=BOUND, u=st.lists(UNIT, min_size=1, max_size=9))
def test_no_rounding_carries_a_point_out_of_the_box(
    lower: float, upper: float, u: list[float]
) -> None:
    assume(upper - lower >= 1e-100)  # narrower ones are refused
    x = box([(lower, upper)]).decode(np.array([[0.0], [1.0], *([v] for v in u)]))
    assert x[0] == lower
    assert lower <= x.min() <= x.max() <= upper


def test_the_far_corner_is_kept_where_range_and_lower_add_up_to_more() -> None:
    assert -0.2 + (0.4 - -0.2) > 0.4
    assert box([(-0.2, 0.4)]).decode(np.array([[1.0]])) == 0.4


@pytest.mark.parametrize("upper", [0.4, 0.8])  # of which the first rounds out of the box
@pytest.mark.parametrize(("u", "wall"), [(-0.3, 0), (1.7, 1)])
def test_what_is_outside_the_cube_is_put_on_the_wall(upper: float, u: float, wall: int) -> None:
    x = box([(-0.2, upper), (0.0, 1.0)]).decode(np.array([[u, 0.5], [0.5, u]]))
    assert x[0, 0] == (-0.2, upper)[wall]
    assert x[1, 1] == wall
    assert x[0, 1] == 0.5


@given(st.lists(st.tuples(UNIT, UNIT), min_size=1, max_size=9))
def test_encoding_takes_back_what_decoding_did(u: list[tuple[float, float]]) -> None:
    space = Space((Param("a", -3.0, 8.0), Param("b", 1e-4, 1e3, log=True)))
    assert np.allclose(space.encode(space.decode(np.array(u))), u, atol=1e-12)
