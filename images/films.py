"""The films of the lessons: drives of the solutions, recorded as numbers for the browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nao_course import films
from nao_course._internal.counts import say_count
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.geometry import Pose
from nao_course.instructor.authoring.plans import load_solution
from nao_course.plotting.style import FOUND, GREY, STYLES
from nao_course.sim import Field
from nao_course.slam import DeadReckoning, run_slam

TRUTH, EKF, GRAPH = (STYLES[name].colour for name in ("truth", "ekf", "graph"))
FIELD = Field(2012)
Own = Mapping[str, Any]


def ekf_slam(own: Own) -> films.Film:
    """Return the film of lesson 07: the run of the log, with the correlations beside the map."""
    from nao_course.lessons.ekf_slam import record_film
    from nao_course.lessons.ekf_slam.panel import browser_film

    return browser_film(record_film(own["init_landmarks"], own["predict"], own["update"]))


def graph_slam(own: Own) -> films.Film:
    """Return the film of lesson 08: constraints arrive, the matrix fills in, and the map follows."""
    from nao_course.lessons.graph_slam.drives import field_drive
    from nao_course.lessons.graph_slam.systems import Builders, map_error, solve_axes

    drive, poses = field_drive(), len(field_drive().path)
    adding = ("add_initial_position", "add_relative_motion", "add_relative_measurement")
    builders = Builders(*(own[name] for name in adding))
    stops, landmarks, rays, newest, omegas, captions = [], [], [], [], [], []
    for count in range(1, len(drive.constraints) + 1):
        used = drive.constraints[:count]
        positions, omega = solve_axes(used, drive.size, builders, own["solve"])
        ends = [[each.first, each.second] for each in used]
        known = np.isfinite(positions[:, 0])
        stops.append(positions[:poses][known[:poses]])
        landmarks.append((positions[poses:][known[poses:]], np.array(FIELD.detectable_kinds)[known[poses:]]))
        rays.append(
            [
                positions[end].ravel()
                for end, each in zip(ends, used, strict=True)
                if each.kind == "measurement"
            ]
        )
        newest.append(positions[ends[-1]].ravel())
        omegas.append(np.sign(omega))
        off = (
            f" The landmarks are {100 * map_error(drive, positions):.0f} cm off."
            if known[poses:].any()
            else ""
        )
        captions.append(f"{say_count(count, 'constraint')}. The newest is a {drive.say(used[-1])}.{off}")
    layers = [
        films.point_layer(TRUTH, [drive.landmarks], "landmark, true", size=7, open=True),
        films.curve_layer(TRUTH, [drive.path], "true path", width=1.2),
        films.line_layer(GRAPH, rays, "measurement", alpha=0.5),
        films.curve_layer(GRAPH, stops, "path by the graph", width=2),
        films.point_layer(GRAPH, stops, marker="D", size=3.5),
        films.landmark_layer(GRAPH, landmarks, "landmark by the graph"),
        films.line_layer(FOUND, newest, "newest constraint", alpha=1, width=3, jumps=True),
    ]
    marked = [[each.first, each.second] for each in drive.constraints]
    blocks = [poses, drive.size - poses]
    matrix = films.Matrix("Omega", omegas, blocks, ["poses", "landmarks"], signs=True, marked=marked)
    title = "Graph SLAM, one constraint after the other"
    return films.Film(title, layers, captions, FIELD, [matrix], step="Constraint")


def pose_graphs(own: Own) -> films.Film:
    """Return the film of lesson 09: a drive through a building relaxes with every step of the solver."""
    from nao_course.lessons.pose_graphs.figures import CLOSURE, relaxed, say_chi2
    from nao_course.lessons.pose_graphs.worlds import building, position_error

    world = building(5)
    every = relaxed(world, own["gauss_newton"], 6)
    chi2 = own["gauss_newton"](world.graph, world.odometry.copy(), 6)[1]
    places = [world.graph.split(states)[0][:, :2] for states in every]
    true = world.graph.split(world.truth)[0][:, :2]
    closures = world.graph.edges[world.closures()]
    layers = [
        films.curve_layer(TRUTH, [true], "true path", width=1.2),
        films.line_layer(
            CLOSURE, [each[closures].reshape(-1, 4) for each in places], "loop closure", width=1.4
        ),
        films.curve_layer(GRAPH, places, "poses by the graph", width=1.6),
        films.point_layer(GRAPH, places, size=1.4),
    ]
    captions = [
        f"{'Odometry' if step == 0 else f'After step {step}'}: chi2 {say_chi2(value)}, "
        f"{position_error(world, states):.2f} m off."
        for step, (states, value) in enumerate(zip(every, chi2, strict=True))
    ]
    return films.Film("A pose graph relaxes", layers, captions, step="Solver step", pace=1)


def slam_on_the_field(own: Own) -> films.Film:
    """Return the film of lesson 11: one drive by odometry, filter and graph, with the measurements of the pictures."""
    from nao_course.lessons.slam_on_the_field.figures import measured_drive

    log, true = measured_drive(own["measure"])
    start = Pose.from_array(true[0])
    algorithms = {
        "odometry": DeadReckoning(start),
        "ekf": own["EkfSlam"](start, OdometryNoisePerMove()),
        "graph": own["GraphSlam"](start, OdometryNoisePerMove()),
    }
    estimates = {name: run_slam(algorithm, log) for name, algorithm in algorithms.items()}
    seen = [observed for _, observed in log]
    title = "EKF and graph on one drive over the half field"
    return films.drive_film(title, FIELD, [Pose.from_array(each) for each in true], estimates, seen)


def exploring(own: Own) -> films.Film:
    """Return the first film of lesson 12: a robot explores a room of boxes, always to the nearest frontier."""
    from nao_course.lessons.beyond import exploring as room

    grid = np.full(room.SHAPE, room.UNKNOWN)
    centres, free, boxes, frontiers, path, captions = room.cell_centres(), [], [], [], [], []
    strategy = room.nearest_frontier(own["find_frontiers"])
    heading, before = 0.0, None
    for number, known in enumerate(room.explore(own["travel_steps"], strategy, 1, 80)):
        free.append(centres[(known.grid == room.FREE) & (grid != room.FREE)])
        boxes.append(centres[(known.grid == room.OCCUPIED) & (grid != room.OCCUPIED)])
        frontiers.append(centres[own["find_frontiers"](known.grid.copy())])
        grid = known.grid
        if before is not None and np.hypot(*(known.place - before)) > 0:
            heading = float(np.arctan2(*(known.place - before)[::-1]))
        path.append((*known.place, heading))
        before = known.place
        captions.append(f"After {say_count(number, 'move')}: {known.part:.0%} of the room is known.")
        if known.goal is None:
            break
    layers = [
        films.cell_layer("#ffffff", room.CELL, free, "known to be free", keeps=True, dark="#5d7564"),
        films.cell_layer("#3b3f46", room.CELL, boxes, "box", keeps=True, fill=0.9, dark="#c3a57c"),
        films.cell_layer("#7a35d0", room.CELL, frontiers, "frontier"),
        films.path_layer("truth", path, "robot"),
    ]
    return films.Film("A robot explores a room", layers, captions, FIELD, step="Move")


def finding_itself(own: Own) -> films.Film:
    """Return the second film of lesson 12: particles find a robot that does not know where it is."""
    from nao_course.lessons.beyond.figures import FOUND as NEAR
    from nao_course.lessons.beyond.figures import LOST_SEED, lap
    from nao_course.lessons.beyond.particles import find_itself
    from nao_course.lessons.beyond.worlds import KINDS, LANDMARKS

    steps = lap(LOST_SEED, 20)
    clouds = find_itself(own["weigh"], own["resample"], steps, np.random.default_rng(LOST_SEED), 1000)
    true = np.array([steps[0].pose, *(step.pose for step in steps)])
    near = [
        np.mean(np.hypot(*(cloud[:, :2] - pose[:2]).T) < NEAR)
        for cloud, pose in zip(clouds, true, strict=True)
    ]
    rays = [np.empty((0, 4))] + [
        np.hstack([np.tile(step.pose[:2], (len(step.numbers), 1)), LANDMARKS[step.numbers]]) for step in steps
    ]
    layers = [
        films.landmark_layer(GREY, [(LANDMARKS, KINDS)], "landmark", size=3.5),
        films.point_layer(
            EKF, [cloud[:, :2] for cloud in clouds], "particle", size=1.2, alpha=0.7, jumps=True
        ),
        films.line_layer(GREY, rays, "measured", alpha=0.8, jumps=True),
        films.path_layer("truth", true, "robot"),
    ]
    captions = [
        f"After {say_count(number, 'observation')}, {part:.0%} of the particles are within "
        f"{100 * NEAR:.0f} cm of the robot."
        for number, part in enumerate(near)
    ]
    return films.Film("Particles find the robot", layers, captions, FIELD, pace=1)


RECORDERS: Mapping[str, tuple[str, Callable[[Own], films.Film]]] = {
    "07_ekf_slam": ("07_ekf_slam", ekf_slam),
    "08_graph_slam": ("08_graph_slam", graph_slam),
    "09_pose_graphs": ("09_pose_graphs", pose_graphs),
    "11_slam_on_the_field": ("11_slam_on_the_field", slam_on_the_field),
    "12_beyond": ("12_beyond", exploring),
    "12_particles": ("12_beyond", finding_itself),
}


def record(name: str) -> films.Film:
    """Record a film with the functions of its lesson's solution."""
    lesson, recorder = RECORDERS[name]
    return recorder(load_solution(Path("solutions", f"{lesson}.ipynb")))
