"""A drawing of each kind, and an estimate to draw."""

import numpy as np

from nao_course.geometry import Pose, rotation_2d
from nao_course.plotting import draw_labels, draw_map, draw_picture, draw_pictures
from nao_course.sim import Reality, SimulatedNao, Truth
from nao_course.slam import Estimate


def some_estimate(covariance=0.02):
    turn = rotation_2d(0.4)
    ellipse = turn @ np.diag([4 * covariance, covariance]) @ turn.T
    return Estimate(
        Pose(1.0, 0.4, 0.3),
        np.diag([covariance, covariance / 3, 0.01]),
        np.array([[3.0, 0.7], [2.4, 1.1]]),
        np.array([ellipse, ellipse]),
        ("post", "corner"),
    )


def walked():
    """A robot that has walked, and its truth."""
    nao = SimulatedNao(rng=2, reality=Reality.clean())
    truth = Truth(nao)
    nao.walk(0.4)
    return nao, truth


def a_map():
    nao, truth = walked()
    return draw_map(nao.field, truth.path, nao.odometry, some_estimate(), nao.sense(), 'A "map" & more')


def a_picture():
    nao, truth = walked()
    return draw_picture(nao.take_picture(), truth.picture.landmarks)


def some_pictures():
    picture = walked()[0].take_picture()
    return draw_pictures([picture, picture.pixels[:, :, 0]], ["colour", "red"])


def some_labels():
    nao, truth = walked()
    nao.take_picture()
    return draw_labels(truth.picture.labels)


DRAWINGS = {"map": a_map, "picture": a_picture, "pictures": some_pictures, "labels": some_labels}
