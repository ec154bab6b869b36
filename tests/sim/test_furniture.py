"""Furniture: pieces stand where they are put, and face where they are turned."""

import numpy as np

from nao_course.sim.furniture import Workshop


def test_a_pieces_front_looks_along_its_facing():
    workshop = Workshop(np.random.default_rng(0))
    for facing in (0.0, 1.2):
        workshop.place(np.array([2.0, 3.0]), facing)
        workshop.polygon(np.array([(0.0, -1.0, 0.5)]), (9, 9, 9))  # a metre in front of its middle
    ahead = workshop.done().points[:, :2] - (2.0, 3.0)
    assert np.allclose(ahead, [(1.0, 0.0), (np.cos(1.2), np.sin(1.2))])
