"""The view of the world: what it shows is what it was given, in small messages, and in a picture without a browser."""

import json

import cv2
import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.plotting import ellipse_outlines
from nao_course.sim import NAO_V4, Field
from nao_course.slam import Estimate
from nao_course.widgets import Ray, WorldView
from nao_course.widgets.world.canvas import Canvas
from nao_course.widgets.world.contents import WorldContents
from nao_course.widgets.world.picture import cameras, render_world, viewer
from nao_course.widgets.world.scene import GRID, PRESETS, Viewpoint
from nao_course.widgets.world.shells import shells

POSE = Pose(0.6, -0.5, 0.2)
PICTURE = np.full((24, 32, 3), (10, 200, 30), dtype=np.uint8)


def an_estimate(pose=POSE):
    covariance = np.array([[0.02, 0.006], [0.006, 0.01]])
    robot = np.zeros((3, 3))
    robot[:2, :2] = covariance
    marks = np.array([[3.0, 0.7], [2.4, 1.1]])
    return Estimate(pose, robot, marks, np.array([covariance] * 2), ("post", "corner"))


@pytest.fixture(scope="module")
def world():
    return WorldView(size=(160, 100))


def test_what_is_not_given_stays_and_none_hides_and_the_summary_says_what_is_shown(world):
    world.update(POSE, an_estimate(), head=(0.3, -0.2), pictures={"top": PICTURE})
    world.update(head=(0.1, 0.0))
    assert world.contents.truth == POSE and world.contents.head == (0.1, 0.0)
    assert list(world.contents.pictures) == ["top"]
    world.update(estimate=None, pictures={"top": np.empty((0, 0, 3), dtype=np.uint8)})
    assert world.contents.estimate is None and world.contents.pictures == {}
    assert world.contents.truth == POSE
    tilted = {"head": (0.5, 0.1), "tilt": (np.radians(1), 0.0)}
    world.update(POSE, an_estimate(Pose(0.6, -0.2, 0.2)), rays=[Ray((3, 0))], **tilted)
    words = world.summary()
    for part in ("(0.60, -0.50) m", "30 cm apart", "2 landmarks", "yaw 29 deg", "1.0 deg", "1 ray "):
        assert part in words
    assert repr(world) == f"WorldView: {words}"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"truth": (0, 0, 0)}, "truth must be a Pose or None"),
        ({"estimate": 3}, "estimate must be an Estimate, a Pose or None"),
        ({"head": (0.0, 2.0)}, "head pitch must be within"),
        ({"tilt": (np.nan, 0.0)}, "tilt"),
        ({"pictures": {"left": PICTURE}}, "camera must be one of"),
        ({"rays": [Ray((1, 1), "left")]}, "camera must be one of"),
        ({"paths": {"gps": [POSE]}}, "source must be one of"),
        ({"paths": {"truth": [[1, 2, 3, 4]]}}, "path must be poses"),
    ],
)
def test_what_is_not_possible_is_refused_and_changes_nothing(world, wrong, words):
    world.update(POSE, None, head=(0.0, 0.0))
    before = world.contents
    with pytest.raises(ValueError, match=words):
        world.update(**{"truth": Pose(1, 1, 1), **wrong})
    assert world.contents is before


def test_the_scene_is_plain_data_with_bytes_in_which_the_robots_corners_are_those_of_its_shapes(world):
    found = []

    def plain(value):
        if isinstance(value, bytes):
            found.append(len(value))
            return None
        raise TypeError(type(value).__name__)

    scene = world.scene.data()
    assert len(json.dumps(scene, default=plain, allow_nan=False)) < 30_000
    assert len(found) == len(world.scene.walls) + 2 and sum(found) < 150_000
    assert list(scene["presets"]) == list(PRESETS)
    robot = world.scene.data()["robot"]
    corners = np.frombuffer(robot["corners"], dtype="<i2").reshape(len(shells()), -1, 3) * robot["unit"]
    for shape, mine in zip(shells(), corners, strict=True):
        np.testing.assert_allclose(mine, shape.points(), atol=robot["unit"])


def test_an_update_of_a_drive_is_small_and_sends_only_what_changed(world):
    world.update(POSE, an_estimate(), head=(0.0, 0.0), paths={}, pictures={"bottom": PICTURE})
    sent = []
    widget = world.widget
    widget.observe(lambda change: sent.append(change["name"]))
    path = [Pose(0.005 * step, 0.0, 0.0) for step in range(2000)]
    world.update(Pose(0.7, -0.5, 0.2), paths={"truth": path})
    assert sorted(set(sent)) == ["contents", "summary", "trails"]
    assert len(json.dumps(widget.contents)) < 1500
    assert len(json.dumps(widget.trails)) < 3000  # ten metres
    assert widget.trails["truth"][-2:] == [9995, 0]
    sent.clear()
    world.update(pictures={"bottom": PICTURE + np.uint8(1)})
    assert sent == ["bottom"]
    assert cv2.imdecode(np.frombuffer(widget.bottom, dtype=np.uint8), cv2.IMREAD_COLOR).shape == PICTURE.shape


def test_the_ellipses_in_the_message_have_the_outlines_of_the_maps():
    estimate = an_estimate()
    data = WorldContents(estimate=estimate).data()
    assert len(data["ellipses"]) == 3
    centre, first, second = np.array(data["ellipses"][1])
    angle = np.linspace(0, 2 * np.pi, 49)[:, None]
    drawn = centre + np.cos(angle) * first + np.sin(angle) * second
    wanted = ellipse_outlines(estimate.landmarks[:1], estimate.landmark_covariances[:1])[0]
    np.testing.assert_allclose(drawn, wanted, atol=2e-4)


def test_a_reader_who_moves_the_view_moves_it_for_the_picture_too_and_without_webgl_there_are_pictures(world):
    world.view_from("behind")
    moved = {**world.widget.viewpoint, "azimuth": 1.25, "distance": 3.0}
    world.widget.viewpoint = moved
    assert world.viewpoint == Viewpoint(1.25, 0.36, 3.0, tuple(moved["target"]), follows=True)
    world.view_from("above")
    assert world.widget.viewpoint["follows"] is False
    world.update(POSE, None)
    assert world.widget.still == b""
    world.widget.needs_still = True
    first = world.widget.still
    assert first[:3] == b"\xff\xd8\xff"
    world.update(Pose(1.5, 0.0, 1.0))
    assert world.widget.still != first
    world.widget.needs_still = False


def test_where_no_widget_lives_there_is_a_picture_with_a_text(world):
    world.update(POSE, an_estimate())
    bundle = world._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle
    assert 'alt="3-D view of the field. robot at (0.60, -0.50) m' in bundle["text/html"]
    # The dark theme inverts figures, but not photographs.
    assert 'class="nao-figure"' not in bundle["text/html"]
    assert bundle["text/plain"] == repr(world)
    assert world.drawing().image("png")[:4] == b"\x89PNG"
    assert world.pixels.shape == (100, 160, 3)


def pixel_of(world, point):
    """Return the row and column of a point in space in the finished picture."""
    width, height = world.size
    canvas = Canvas(viewer(world.contents, world.viewpoint), (2 * width, 2 * height))
    u, v, _ = canvas.project(np.array(point, dtype=float)) / 2
    return round(float(v)), round(float(u))


@pytest.mark.parametrize("preset", PRESETS)
def test_each_viewpoint_shows_the_robot(preset):
    view = WorldView(size=(160, 100), viewpoint=preset)
    view.update(POSE)
    eye, target = viewer(view.contents, view.viewpoint)
    away = eye - target
    distance = float(np.linalg.norm(away))
    fixed = Viewpoint(np.arctan2(away[1], away[0]), np.arcsin(away[2] / distance), distance, tuple(target))
    empty = render_world(view.scene, WorldContents(), fixed, "ekf", view.size)
    changed = np.flatnonzero((view.pixels != empty).any(axis=2))
    rows, columns = np.divmod(changed, 160)
    row, column = pixel_of(view, (POSE.x, POSE.y, 0.3))
    assert len(changed) > 20
    assert abs(np.median(rows) - row) < 12 and abs(np.median(columns) - column) < 12


def test_colours_are_where_the_geometry_puts_them_and_a_nearer_surface_hides_a_farther_one():
    view = WorldView(size=(160, 100), viewpoint="above")
    green, white = view.pixels[pixel_of(view, (1.0, 1.0, 0.0))], view.pixels[pixel_of(view, (0.0, 1.2, 0.0))]
    assert green[1] > green[0] + 40 and green[1] > green[2] + 30
    assert white.min() > 150
    far = WorldView(Field(pose=Pose(10.0, 5.0, np.pi / 2)), size=(160, 100), viewpoint="above")
    # The field frame's y axis points along -x of the world now.
    assert far.pixels[pixel_of(far, (10.0 - 1.2, 5.0, 0.0))].min() > 150
    canvas = Canvas((np.array([3.0, 0.0, 0.5]), np.array([0.0, 0.0, 0.5])), (80, 60))

    def square(x, size):
        y, z = np.array([-1, 1, 1, -1]) * size, np.array([-1, -1, 1, 1]) * size + 0.5
        corners = np.column_stack([np.full(4, x), y, z])
        return corners[[[0, 1, 2], [0, 2, 3]]]

    red, blue = np.tile([255.0, 0.0, 0.0], (2, 1)), np.tile([0.0, 0.0, 255.0], (2, 1))
    canvas.triangles([(square(1.0, 0.2), red), (square(0.0, 0.6), blue)])
    assert canvas.pixels[30, 40].argmax() == 0 and canvas.pixels[30, 25].argmax() == 2
    before = canvas.pixels.copy()
    canvas.triangles([(square(-1.0, 0.5), red)])  # behind both
    assert np.array_equal(canvas.pixels[20:40, 30:50], before[20:40, 30:50])


def test_a_picture_stands_in_the_view_cone_and_impossible_views_are_refused(world):
    view = WorldView(size=(320, 200))
    view.update(POSE, head=(0.0, 0.0), pictures={"bottom": PICTURE})
    frame = cameras(view.scene, view.contents, POSE, (0.0, 0.0))["bottom"]
    middle = frame[:3, 3] + 0.34 * frame[:3, 0]
    shown = view.pixels[pixel_of(view, middle)]
    assert abs(shown.astype(int) - PICTURE[0, 0]).max() < 40
    with pytest.raises(ValueError, match="'behind', 'above', 'goal'"):
        WorldView(viewpoint="below")
    with pytest.raises(ValueError, match="source must be one of"):
        WorldView(source="gps")
    with pytest.raises(ValueError, match="2 or 3 coordinates"):
        Ray((1.0,))


@pytest.mark.parametrize("camera", ["top", "bottom"])
def test_the_mesh_of_a_picture_has_the_rays_of_the_lens(world, camera):
    rays = world.scene.picture_rays(camera)
    assert rays.shape == (GRID[1], GRID[0], 2)
    view = NAO_V4.view(camera)
    seen = np.column_stack([np.ones(GRID[0] * GRID[1]), -rays.reshape(-1, 2)]) @ view.rotation.T
    pixels = view.project(view.position + seen).reshape(GRID[1], GRID[0], 2)
    np.testing.assert_allclose(pixels[0, 0], [-0.5, -0.5], atol=1e-6)
    np.testing.assert_allclose(pixels[-1, -1], [319.5, 239.5], atol=1e-6)
