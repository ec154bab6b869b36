"""Laws of the simulator's pictures."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import DIMENSIONS, NAO_V4, CameraView, Field, Reality, render, visible_landmarks
from nao_course.sim.render import COLOURS, GREEN, OTHER, WHITE, YELLOW
from nao_course.sim.shapes import cut_square

CLEAN = Reality.clean()
LOOKING_DOWN_A_LITTLE = np.radians(-31.0)


def camera(size=(320, 240), **angles):
    return NAO_V4.view("bottom", pitch=LOOKING_DOWN_A_LITTLE, size=size, **angles)


def white_share(pixels):
    """How much of each pixel is line, from the light it sent."""
    light = (pixels.astype(float) / 255) ** 2
    carpet, line = (COLOURS[name].astype(float) for name in ("carpet", "line"))
    return ((light - carpet) @ (line - carpet)) / ((line - carpet) @ (line - carpet))


@pytest.mark.parametrize("distance", [1.0, 2.0, 4.0, 6.0])
@pytest.mark.parametrize("turned", [0.0, 0.2])
def test_a_lines_rendered_area_is_its_projected_area_within_two_per_cent(distance, turned):
    field = Field(2013, half=False)
    pose = Pose(2.2, 3.0 - distance, np.pi / 2 + turned)  # the touch line at y = 3, and beyond it only carpet
    view = camera()
    pixels, _ = render(field, pose, view, CLEAN)
    x = np.linspace(-1.0, 4.0, 5001)
    near, far = (view.project(np.column_stack([x, np.full_like(x, y)]), pose) for y in (2.975, 3.025))
    columns = np.arange(130, 200)
    low, high = (np.interp(columns, *edge[np.argsort(edge[:, 0])].T) for edge in (near, far))
    rows = np.arange(240)[:, None]
    around = (rows > high - 1) & (rows < low + 1)  # without blur, no line reaches farther than its pixels
    drawn = white_share(pixels)[:, columns][around].sum()
    assert drawn == pytest.approx((low - high).sum(), rel=0.02)


def test_a_cut_square_has_the_area_that_counting_gives(rng):
    inside = (np.arange(400) + 0.5) / 400 - 0.5
    x, y = np.meshgrid(inside, inside)
    for _ in range(50):
        angle, offset = rng.uniform(0, 2 * np.pi), rng.uniform(-0.8, 0.8)
        slope = rng.uniform(0.1, 20)
        c, s = np.cos(angle), np.sin(angle)
        counted = (x * c + y * s + offset > 0).mean()
        got = cut_square(*(np.float32([value * slope]) for value in (offset, c, s)))[0]
        assert got == pytest.approx(counted, abs=0.003)


@pytest.mark.slow
def test_no_move_of_the_world_shows_in_any_of_many_pictures(rng):
    for number in range(25):
        robot = Pose(*rng.uniform([0, -2, -3], [3, 2, 3]))
        moved = Pose(*rng.uniform([-50, -50, -3], [50, 50, 3]))
        (here, truth), (there, of_moved) = (
            render(field, pose, camera((160, 120)), rng=np.random.default_rng(5))
            for field, pose in (
                (Field(half=number % 2 == 0), robot),
                (Field(half=number % 2 == 0, pose=moved), moved @ robot),
            )
        )
        assert here.tobytes() == there.tobytes()
        assert truth.labels.tobytes() == of_moved.labels.tobytes()
        assert len(truth.landmarks) == len(of_moved.landmarks)


def test_the_same_seed_gives_the_same_bytes_and_a_mirrored_field_the_mirrored_picture():
    draws = [np.random.default_rng(seed) for seed in (1, 1, 2)]
    pictures = [render(Field(), Pose(), camera(), rng=rng)[0].tobytes() for rng in draws]
    assert pictures[0] == pictures[1] != pictures[2]
    first, second = (render(Field(), Pose(), camera((8, 6)), CLEAN)[1] for _ in range(2))
    assert first == first and first != second, "a truth is equal to itself alone"
    assert len({first, second, first}) == 2
    one, truth = render(Field(), Pose(0.5, 0.6, 0.2), camera(), CLEAN)
    other, mirrored = render(Field(), Pose(0.5, -0.6, -0.2), camera(), CLEAN)
    assert (truth.labels == mirrored.labels[:, ::-1]).mean() > 0.9999
    on_field = truth.labels != OTHER
    assert np.abs(one.astype(int) - other[:, ::-1])[on_field].max() <= 1


@pytest.mark.parametrize("year", DIMENSIONS)
@pytest.mark.parametrize("turn", [-2.8, -1.0, 0.0, 1.0, 2.5])
def test_labels_agree_with_the_picture(year, turn):
    pixels, truth = render(Field(year, half=False), Pose(1.0, 0.5, turn), camera(yaw=0.2), CLEAN)
    red, green, blue = pixels.astype(int).transpose(2, 0, 1)
    labels = truth.labels
    grass = (green > red + 30) & (green > blue + 30)
    yellow = (red > blue + 60) & (green > blue + 50)
    white = pixels.min(axis=2) > 215
    # Away from edges, where colours mix, labels and colours are the same thing.
    flat = cv2.dilate(labels, np.ones((3, 3))) == cv2.erode(labels, np.ones((3, 3)))
    assert grass[flat & (labels == GREEN)].mean() > 0.98  # a line thinner than half a pixel is labelled green
    assert yellow[flat & (labels == YELLOW)].all()
    assert white[flat & (labels == WHITE)].mean() > 0.9 if (flat & (labels == WHITE)).any() else True
    assert not (grass | yellow)[flat & (labels == OTHER)].any()


@pytest.mark.parametrize(("height", "hidden"), [(0.5, True), (2.0, True), (4.0, False), (6.0, False)])
def test_a_post_hides_what_is_behind_it_unless_one_looks_over_its_top(height, hidden):
    # 1 m before a post of 0.8 m, with the corner 0.4 m behind it: seen from above 2.8 m.
    post, corner = np.array([3.0, 0.7]), np.array([3.0, 1.1])
    eye = post - (corner - post) / 0.4
    heading = Pose(*eye, np.pi / 2)
    view = CameraView((320, 240), 1.06, 0.83, height=height, pitch=float(np.arctan2(height, 1.4)))
    _, truth = render(Field(2012), heading, view, CLEAN)
    seen = {(m.landmark.x, m.landmark.y): m for m in truth.landmarks}
    assert seen[(3.0, 1.1)].occluded is hidden
    assert (visible_landmarks(Field(2012), heading, view)) == truth.landmarks
    u, v = np.rint(seen[(3.0, 1.1)].pixel).astype(int)
    assert truth.labels[v, u] == (YELLOW if hidden else WHITE)


def test_visible_landmarks_are_those_on_a_pixel_and_a_post_is_as_wide_and_high_as_its_projection(rng):
    field, near_the_rim = Field(2012), 0
    positions = np.array([(mark.x, mark.y) for mark in field.landmarks])
    for _ in range(150):
        pose, view = Pose(*rng.uniform([0, -2, -3], [3, 2, 3])), camera((8, 6))
        pixels = view.project(positions, pose)
        inside = (np.abs(pixels - (3.5, 2.5)) <= (4, 3)).all(axis=1)
        near_the_rim += (inside & (np.abs(pixels - (3.5, 2.5)) > (3.5, 2.5)).any(axis=1)).sum()
        _, truth = render(field, pose, view, CLEAN)
        wanted = [field.landmarks[i] for i in np.flatnonzero(inside)]
        assert [seen.landmark for seen in truth.landmarks] == wanted
    assert near_the_rim > 10
    robot = Pose(0.5, -0.3, 0.2)
    for seen in render(Field(), robot, camera(yaw=0.4), CLEAN)[1].landmarks:
        x, y = robot.to_local([seen.landmark.x, seen.landmark.y])[0]
        assert seen.distance == pytest.approx(np.hypot(x, y))
        assert seen.bearing == pytest.approx(np.arctan2(y, x))
    pose, view = Pose(1.2, 0.7, 0.0), NAO_V4.view("top", size=(640, 480))
    _, truth = render(Field(2012), pose, view, CLEAN)
    yellow = truth.labels == YELLOW
    foot, half_up = view.project([[3.0, 0.7, 0.0], [3.0, 0.7, 0.4]], pose)
    row = round(half_up[1])
    run = np.flatnonzero(yellow[row, round(foot[0]) - 40 : round(foot[0]) + 41])
    distance = 3.0 - 1.2 - view.offset[0]
    wide = 2 * view.focal[0] * np.tan(np.arcsin(0.05 / distance))
    assert len(run) == pytest.approx(wide, abs=1.5)
    lowest = np.flatnonzero(yellow[:, round(foot[0])]).max()
    assert lowest == pytest.approx(view.project([[2.95, 0.7, 0.0]], pose)[0, 1], abs=1.0)


def test_noise_has_the_stated_deviation_and_a_landmark_behind_a_post_is_occluded_and_the_post_is_not():
    view = camera((640, 480))
    clean, truth = render(Field(), Pose(), view, CLEAN)
    noisy, _ = render(Field(), Pose(), view, replace(CLEAN, noise=3.3), np.random.default_rng(0))
    difference = (noisy.astype(float) - clean)[truth.labels == GREEN]
    assert difference.std() == pytest.approx(3.3, rel=0.03)
    assert difference.mean() == pytest.approx(0, abs=0.1)
    with pytest.raises(ValueError, match="needs rng"):
        render(Field(), Pose(), camera())
    field = Field(2012)
    robot = Pose(2.0, -0.7, 0.0)
    corner = next(m for m in field.landmarks if m.kind == "corner" and (m.x, m.y) == (3.0, 1.1))
    seen = {(m.landmark.x, m.landmark.y): m for m in render(field, robot, camera(), CLEAN)[1].landmarks}
    assert not seen[(3.0, -0.7)].occluded
    # From behind the goal line, the near post hides what stands in line with it.
    direction = np.array([3.0, 0.7]) - np.array([corner.x, corner.y])
    eye = np.array([3.0, 0.7]) + direction / np.linalg.norm(direction) * 1.0
    looking = Pose(float(eye[0]), float(eye[1]), float(np.arctan2(*-direction[::-1])))
    hidden = {(m.landmark.x, m.landmark.y): m for m in render(field, looking, camera(), CLEAN)[1].landmarks}
    assert hidden[(3.0, 1.1)].occluded
    assert not hidden[(3.0, 0.7)].occluded


@pytest.mark.parametrize("effect", Reality.effects())
def test_each_effect_alone_changes_the_picture_and_at_zero_does_not(effect):
    def picture(reality):
        turning = (0.02, 0.05, -0.08) if reality.motion else (0.0, 0.0, 0.0)
        return render(Field(), Pose(0.4, 0.3, 0.1), camera(), reality, np.random.default_rng(0), turning)[0]

    clean = picture(CLEAN)
    assert picture(replace(Reality.clean(seed=5), **{effect: 0.0})).tobytes() == clean.tobytes()
    strong = {"seams": 1.0, "vignette": 0.3, "white_balance": 0.1, "exposure": 1.0}
    strong |= dict.fromkeys(("gradient", "glare"), 0.5) | dict.fromkeys(("clutter", "sheets", "motion"), 5.0)
    assert (picture(replace(CLEAN, **{effect: strong.get(effect, 10.0)})) != clean).mean() > 0.0005


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["lab", "dark", "harsh"])
def test_labels_and_landmarks_are_the_same_under_every_preset_but_for_what_lies_on_the_carpet(preset):
    pose, view = Pose(0.4, 0.3, 0.1), camera()
    reality = getattr(Reality, preset)()
    _, clean = render(Field(), pose, view, CLEAN)
    _, real = render(Field(), pose, view, replace(reality, litter=0.0), np.random.default_rng(0))
    assert clean.labels.tobytes() == real.labels.tobytes()
    assert clean.landmarks == real.landmarks
    _, littered = render(Field(), pose, view, replace(reality, litter=2.0), np.random.default_rng(0))
    changed = littered.labels != clean.labels
    assert 0 < changed.mean() < 0.1
    assert (littered.labels[changed] == OTHER).all()
    assert [m.pixel for m in littered.landmarks] == [m.pixel for m in clean.landmarks]


def test_paper_and_things_on_the_carpet_hide_lines_and_landmarks_and_never_the_nearer_goal():
    view, pose, hidden = camera(), Pose(0.4, 0.3, 0.1), 0
    for seed in range(4):
        clear, clean = render(Field(), pose, view, CLEAN)
        strewn, truth = render(Field(), pose, view, replace(CLEAN, sheets=4.0, seed=seed))
        changed = truth.labels != clean.labels
        assert 0.02 < changed.mean() < 0.6
        assert (truth.labels[changed] == OTHER).all()
        assert strewn[changed].min() > 110
        assert (strewn[~changed] != clear[~changed]).mean() < 0.1  # the rim of the paper
        assert not (changed & (clean.labels == YELLOW)).any()  # it lies flat: posts stand on it
        assert [m.pixel for m in truth.landmarks] == [m.pixel for m in clean.landmarks]
        hidden += sum(m.occluded for m in truth.landmarks) - sum(m.occluded for m in clean.landmarks)
    assert hidden > 0
    field, hidden = Field(), 0
    for seed in range(12):
        reality = replace(CLEAN, litter=4.0, seed=seed)
        view = camera()
        for pose in (Pose(0.2, 1.2, -0.2), Pose(2.0, 0.0, 0.0), Pose(3.6, -0.3, np.pi - 0.6)):
            _, clean = render(field, pose, view, CLEAN)
            _, truth = render(field, pose, view, reality)
            hidden += sum(m.occluded for m in truth.landmarks) - sum(m.occluded for m in clean.landmarks)
            if pose.x < 3:  # everything that lies there lies behind the goal
                assert ((truth.labels == YELLOW) == (clean.labels == YELLOW)).all()
    assert hidden > 0


@pytest.mark.slow
def test_the_room_is_painted_behind_the_field_and_another_room_changes_nothing_on_it():
    pose, view = Pose(0.4, 0.3, 0.1), camera()
    clean, truth = render(Field(), pose, view, CLEAN)
    crowded, _ = render(Field(), pose, view, replace(CLEAN, clutter=2.0))
    other = (truth.labels == OTHER).astype(np.uint8)
    changed = (np.abs(crowded.astype(int) - clean) > 2).any(axis=2)  # a rim may be a level off
    assert not changed[cv2.dilate(other, np.ones((5, 5))) == 0].any()
    assert changed[other > 0].mean() > 0.5
    pose, view = Pose(0.4, 0.3, 0.1), camera()
    lab = replace(Reality.lab(), litter=0.0)
    rooms = [render(Field(), pose, view, replace(lab, seed=s), np.random.default_rng(0)) for s in (0, 1)]
    assert (rooms[0][0] != rooms[1][0]).mean() > 0.5
    assert rooms[0][1].labels.tobytes() == rooms[1][1].labels.tobytes()


def test_exposure_holds_the_mean_lightness_and_near_lines_are_overexposed_and_wider_than_their_paint():
    means = []
    for seed in range(4):
        reality = replace(Reality.lab(seed), noise=0.0)
        for pose in (Pose(0.4, 0.3, 0.1), Pose(2.5, -1.0, 1.4)):
            pixels, _ = render(Field(), pose, camera(), reality)
            means.append(cv2.cvtColor(pixels, cv2.COLOR_RGB2HLS)[..., 1].mean())
    assert np.allclose(means, 117, atol=4)
    reality = replace(CLEAN, grain=12.0)
    pixels, truth = render(Field(), Pose(0.2, 0.4, 0.2), camera(), reality, np.random.default_rng(0))
    parts = (slice(145, 175), slice(190, 240))
    far, near = (pixels[rows][truth.labels[rows] == GREEN][:, 1].std() for rows in parts)
    assert 0.3 * near < far < 0.8 * near
    pixels, truth = render(Field(), Pose(1.6, 0.0, 0.0), camera(), rng=np.random.default_rng(0))
    inside = cv2.erode((truth.labels == WHITE).astype(np.uint8), np.ones((5, 5))) > 0
    assert inside.sum() > 50
    assert (pixels[inside] == 255).mean() > 0.98
    view = camera((640, 480))
    for overexposure, wider in ((0.0, False), (3.0, True)):
        reality = replace(CLEAN, blur=3.0, overexposure=overexposure)
        pixels, truth = render(Field(2012), Pose(1.0, 0.0, 0.0), view, reality)
        column = pixels[:, 320].astype(int).sum(axis=1)
        line = np.flatnonzero(truth.labels[:, 320] == WHITE)
        middle = line[-1]  # of the nearest line's lower edge
        half = (column[middle - 2] + column[middle + 12]) / 2
        assert (column[middle + 4] > half) == wider


def test_a_camera_that_turns_while_it_reads_leans_posts_and_labels_alike():
    pose, view = Pose(1.0, 0.3, 0.0), camera()
    still, shaken = (render(Field(), pose, view, CLEAN, turning=(0, 0, w)) for w in (0.0, 0.12))
    for pixels, truth in (still, shaken):
        yellow = truth.labels == YELLOW
        red, _, blue = pixels.astype(int).transpose(2, 0, 1)
        assert ((red > blue + 60) == yellow).mean() > 0.98
        for seen in truth.landmarks:
            if seen.landmark.kind == "post" and not seen.occluded:
                u, v = np.rint(seen.pixel).astype(int)
                assert (truth.labels[v - 2 : v + 3, u - 2 : u + 3] == YELLOW).any()

    def lean(labels):
        rows, columns = np.nonzero(labels[:, 160:] == YELLOW)
        keep = columns > columns.max() - 40
        return np.polyfit(rows[keep], columns[keep], 1)[0]

    # To the left by .12 rad between first and last row: the picture runs to the right, lower rows farther.
    leaning = lean(shaken[1].labels) - lean(still[1].labels)
    assert leaning == pytest.approx(0.12 * view.focal[0] / 239, rel=0.25)


@pytest.mark.parametrize("turning", [(0, 0, 0.15), (0, 0, -0.15), (0.1, 0.1, 0)])
def test_a_turning_camera_sees_carpet_up_to_the_corners_of_its_picture(turning):
    _, truth = render(Field(half=False), Pose(1.0, 0, 0.3), camera(), CLEAN, turning=turning)
    assert (truth.labels[-40:] != OTHER).all()


@pytest.mark.parametrize("size", [(1, 1), (17, 240), (320, 1)])
def test_tiny_pictures_work(size):
    pixels, truth = render(Field(), Pose(0.5, 0, 0.1), camera(size), CLEAN)
    assert pixels.shape == (size[1], size[0], 3)
    assert truth.labels.shape == (size[1], size[0])


def test_every_pose_and_head_angle_gives_a_picture_and_a_camera_without_a_lens_draws_straight_lines(rng):
    for _ in range(60):
        pose = Pose(*rng.uniform([-0.7, -2.7, -np.pi], [3.7, 2.7, np.pi]))
        name, yaw, pitch = str(rng.choice(["top", "bottom"])), rng.uniform(-2, 2), rng.uniform(-0.67, 0.51)
        tilt = {"torso_pitch": rng.normal(0, 0.2), "torso_roll": rng.normal(0, 0.2)}
        view = NAO_V4.view(name, yaw=yaw, pitch=pitch, size=(64, 48), **tilt)
        pixels, truth = render(Field(), pose, view, CLEAN)
        assert pixels.dtype == truth.labels.dtype == np.uint8
        assert set(np.unique(truth.labels)) <= {OTHER, GREEN, YELLOW, WHITE}
    view = CameraView((320, 240), 1.06, 0.83, height=0.48, pitch=0.3)
    _, truth = render(Field(2012), Pose(1.0, 0, 0), view, CLEAN)
    middle = [np.flatnonzero(truth.labels[:, u] == WHITE).max() for u in (100, 160, 220)]
    assert middle[0] == middle[1] == middle[2]


@pytest.mark.parametrize("turning", [(0, 0, np.nan), (0, 0, 1e9), (0.1, 0.1), 3.0])
def test_a_camera_that_turns_too_far_is_refused_and_by_nothing_stands_still(turning):
    with pytest.raises(ValueError, match="turning must be three small angles"):
        render(Field(), Pose(), camera(), CLEAN, turning=turning)
    pose, view = Pose(0.4, 0.3, 0.1), camera()
    still, tiny = (render(Field(), pose, view, CLEAN, turning=(0, 0, w))[0] for w in (0.0, 1e-9))
    assert np.abs(still.astype(int) - tiny).max() <= 1
