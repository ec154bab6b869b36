"""Exploration of a room of boxes."""

from itertools import pairwise

import numpy as np
import pytest

from nao_course.lessons.beyond.exploring import (
    FREE,
    OCCUPIED,
    SHAPE,
    START,
    STRIDE,
    UNKNOWN,
    anywhere_known,
    as_mask,
    as_steps,
    cell_centres,
    cell_of,
    explore,
    lawn_mower,
    mark_visible,
    nearest_frontier,
    passable,
    room_of_boxes,
    way_back,
)


def test_the_visible_area_is_marked_correctly_and_ends_at_a_box():
    centres = cell_centres()
    for row, column in ((0, 0), (10, 3), (SHAPE[0] - 1, SHAPE[1] - 1)):
        assert cell_of(centres[row, column]) == (row, column)
    for seed in range(3):
        taken = room_of_boxes(seed)
        grid = np.full(SHAPE, UNKNOWN)
        mark_visible(grid, taken, np.array(START), np.linspace(-3, 3, 7))
        assert not taken[grid == FREE].any() and taken[grid == OCCUPIED].all()
        assert (grid != UNKNOWN).sum() > 50
    wall, grid, column = np.zeros(SHAPE, dtype=bool), np.full(SHAPE, UNKNOWN), cell_of(np.array(START))[1]
    wall[:, column + 5] = True
    mark_visible(grid, wall, np.array(START), 0.0)
    assert (grid[:, column + 6 :] == UNKNOWN).all()


def test_the_robot_keeps_a_cell_away_from_boxes():
    grid = np.full((5, 5), FREE)
    grid[2, 2] = OCCUPIED
    free = passable(grid)
    assert not free[2, 1:4].any() and not free[1:4, 2].any() and free.sum() == 20
    grid[0, 0] = UNKNOWN
    assert not passable(grid)[0, 0] and passable(grid)[0, 1]


def test_steps_of_neighbours_differ_by_one_at_most_and_a_way_back_is_as_long_as_they_say(own, rng):
    free = rng.random((20, 20)) > 0.3
    free[6, 7] = True
    steps = own["travel_steps"](free, (6, 7))
    assert (steps[~free] == -1).all() and steps[6, 7] == 0
    for one, other in ((steps[1:], steps[:-1]), (steps[:, 1:], steps[:, :-1])):
        both = (one >= 0) & (other >= 0)
        assert (np.abs(one - other)[both] == 1).all()  # colours of a chessboard: never the same
        beside = (one >= 0) != (other >= 0)
        assert not (np.minimum(one, other)[beside] >= 0).any()
    goals = [(int(row), int(column)) for row, column in np.argwhere(steps >= 0)]
    for goal in goals[:: max(1, len(goals) // 15)]:
        way = way_back(steps, goal)
        assert way[0] == (6, 7) and way[-1] == goal and len(way) == steps[goal] + 1
        assert np.abs(np.diff(way, axis=0)).sum() == len(way) - 1 and all(free[cell] for cell in way)


def test_frontiers_are_free_and_vanish_where_all_is_known(own, rng):
    grid = rng.integers(-1, 2, (15, 12))
    ends = own["find_frontiers"](grid)
    assert (grid[ends] == FREE).all()
    assert not own["find_frontiers"](np.abs(grid)).any()
    assert (own["find_frontiers"](np.rot90(grid)) == np.rot90(ends)).all()


@pytest.mark.parametrize("way", ["frontier", "random", "lanes"])
def test_whatever_way_a_robot_goes_it_stays_off_boxes_and_forgets_nothing(own, way):
    choose = {
        "frontier": lambda: nearest_frontier(own["find_frontiers"]),
        "random": lambda: anywhere_known(np.random.default_rng(0)),
        "lanes": lawn_mower,
    }[way]()
    taken = room_of_boxes(3)
    seen = list(explore(own["travel_steps"], choose, 3, 25))
    assert len(seen) == 25
    for before, after in pairwise(seen):
        assert (after.grid[before.grid != UNKNOWN] != UNKNOWN).all() and after.part >= before.part
        assert not taken[cell_of(after.place)]
        moved = np.abs(np.subtract(cell_of(after.place), cell_of(before.place))).sum()
        assert moved <= STRIDE
    assert 0.1 < seen[0].part < seen[-1].part <= 1


def test_frontiers_end_only_where_all_that_can_be_reached_is_known(own):
    *_, last = explore(own["travel_steps"], nearest_frontier(own["find_frontiers"]), 1, 90)
    assert last.goal is None and last.part > 0.95


def lawn_mowers_goals(reachable, moves):
    """Goals of a lawn mower for whom some cells (rows, columns) can be reached, whether or not it gets to them."""
    choose, here, goals = lawn_mower(), cell_of(np.array(START)), []
    while (goal := choose(np.zeros(SHAPE, dtype=int), np.where(reachable, 1, -1), here)) is not None:
        goals.append(goal)
        here = goal if moves else here
    return goals


def test_a_lawn_mower_goes_to_the_ends_of_its_lanes_in_turn_as_near_as_it_can_for_fifteen_moves():
    everywhere, near = np.ones(SHAPE, dtype=bool), np.zeros(SHAPE, dtype=bool)
    goals = lawn_mowers_goals(everywhere, moves=True)
    rows, columns = np.transpose(goals)
    assert len(goals) == 8 and (np.diff(columns) >= 0).all()
    assert (rows == np.tile([rows.min(), rows.max(), rows.max(), rows.min()], 2)).all()
    assert rows.min() < 5 and rows.max() >= SHAPE[0] - 5
    near[10:20] = True
    assert {row for row, _ in lawn_mowers_goals(near, moves=True)} == {10, 19}
    goals = lawn_mowers_goals(everywhere, moves=False)
    assert [goals.count(each) for each in dict.fromkeys(goals)] == [15] * 8


def test_masks_and_steps_may_be_lists_and_other_kinds_of_numbers_and_what_is_none_is_refused():
    assert as_mask([[True, False], [False, False]], (2, 2)).tolist() == [[True, False], [False, False]]
    assert as_mask(np.eye(2, dtype=int), (2, 2)).dtype == bool
    assert as_steps(np.array([[0.0, -1.0], [1.0, 2.0]]), (2, 2)).dtype.kind == "i"
    assert as_steps([[0, -1], [1, 2]], (2, 2)).sum() == 2
    for answer in (np.zeros((2, 2)), np.zeros((3, 2), bool), [[2, 0], [0, 0]], None, "x"):
        with pytest.raises(ValueError, match=r"boolean mask \(2, 2\)"):
            as_mask(answer, (2, 2))
    for answer in (np.full((2, 2), 0.5), np.zeros((3, 2), int), np.full((2, 2), np.nan), None):
        with pytest.raises(ValueError, match=r"whole numbers \(2, 2\)"):
            as_steps(answer, (2, 2))
