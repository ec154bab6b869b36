"""Every strength of an effect can be rendered, or is refused with the limits stated."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field, Reality, SimulatedNao, render

LEVELS = dict.fromkeys(("grain", "mottle", "noise"), 255.0)
FRACTIONS = dict.fromkeys(("seams", "gradient", "white_balance", "exposure", "vignette"), 1.0)
MOST = (
    dict.fromkeys(Reality.effects(), 20.0)
    | LEVELS
    | FRACTIONS
    | {"specks": 200.0, "clutter": 5.0, "sheets": 5.0, "motion": 5.0}
)


@pytest.mark.parametrize("name", Reality.effects())
@pytest.mark.filterwarnings("error")
def test_the_strongest_that_is_allowed_can_be_rendered(name):
    seed = 6 if name == "white_balance" else 0  # 6: a tint that would make the gain of a colour negative
    reality = replace(Reality(seed=seed), **{name: MOST[name]})
    view = NAO_V4.view("bottom", size=(64, 48))
    turning = 0.5 * np.array([0.4, 0.6, 0.5]) if name == "motion" else (0, 0, 0)
    pixels, _ = render(Field(), Pose(0.4, 0.3, 0.1), view, reality, np.random.default_rng(0), turning)
    assert pixels.shape == (48, 64, 3)


@pytest.mark.parametrize("name", Reality.effects())
def test_more_than_that_is_refused_with_the_limit(name):
    for value in (np.nextafter(MOST[name], np.inf), 1e300, 10**400):
        with pytest.raises(ValueError, match=f"Reality: {name} must be"):
            Reality(**{name: value})
    with pytest.raises(ValueError, match=rf"0 \(off\) to {MOST[name]:g}"):
        Reality(**{name: 1e300})


@pytest.mark.parametrize("name", Reality.effects())
@pytest.mark.parametrize("value", [-1e-9, np.nan, "much", True, 1j])
def test_what_is_no_strength_is_refused(name, value):
    with pytest.raises(ValueError, match=f"Reality: {name} must be"):
        Reality(**{name: value})


@pytest.mark.parametrize("seed", [-1, 0.5, np.nan, 2**63, 1e300, True, "0", np.array([1, 2])])
def test_what_is_no_seed_is_refused(seed):
    with pytest.raises(ValueError, match="Reality: seed must be an integer from 0"):
        Reality(seed=seed)


@pytest.mark.parametrize("seed", [3, 3.0, np.int64(3), np.uint8(3), np.float32(3)])
def test_a_whole_number_of_any_type_is_the_same_seed(seed):
    assert Reality(seed=seed) == Reality(seed=3)
    assert type(Reality(seed=seed).seed) is int
    assert type(Reality(grain=seed).grain) is float


def test_a_robot_that_shakes_as_much_as_is_allowed_takes_pictures():
    nao = SimulatedNao(rng=0, reality=replace(Reality.clean(), motion=5.0))
    for _ in range(60):
        nao.take_picture(size=(16, 12), walking=True)
