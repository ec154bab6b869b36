"""Exploration of a room of boxes."""

from itertools import pairwise

import numpy as np
import pytest

from nao_course.lessons.beyond import exploring


def test_the_visible_area_ends_at_a_box_from_which_the_robot_keeps_a_cell_away():
    centres = exploring.cell_centres()
    for row, column in ((0, 0), (10, 3), (exploring.SHAPE[0] - 1, exploring.SHAPE[1] - 1)):
        assert exploring.cell_of(centres[row, column]) == (row, column)
    for seed in range(3):
        taken = exploring.room_of_boxes(seed)
        grid = np.full(exploring.SHAPE, exploring.UNKNOWN)
        exploring.mark_visible(grid, taken, np.array(exploring.START), np.linspace(-3, 3, 7))
        assert not taken[grid == exploring.FREE].any() and taken[grid == exploring.OCCUPIED].all()
        assert (grid != exploring.UNKNOWN).sum() > 50
    wall, grid, column = (
        np.zeros(exploring.SHAPE, dtype=bool),
        np.full(exploring.SHAPE, exploring.UNKNOWN),
        exploring.cell_of(np.array(exploring.START))[1],
    )
    wall[:, column + 5] = True
    exploring.mark_visible(grid, wall, np.array(exploring.START), 0.0)
    assert (grid[:, column + 6 :] == exploring.UNKNOWN).all()
    grid = np.full((5, 5), exploring.FREE)
    grid[2, 2] = exploring.OCCUPIED
    free = exploring.passable(grid)
    assert not free[2, 1:4].any() and not free[1:4, 2].any() and free.sum() == 20
    grid[0, 0] = exploring.UNKNOWN
    assert not exploring.passable(grid)[0, 0] and exploring.passable(grid)[0, 1]


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
        way = exploring.way_back(steps, goal)
        assert way[0] == (6, 7) and way[-1] == goal and len(way) == steps[goal] + 1
        assert np.abs(np.diff(way, axis=0)).sum() == len(way) - 1 and all(free[cell] for cell in way)


def test_frontiers_are_free_and_end_only_where_all_that_can_be_reached_is_known(own, rng):
    grid = rng.integers(-1, 2, (15, 12))
    ends = own["find_frontiers"](grid)
    assert (grid[ends] == exploring.FREE).all()
    assert not own["find_frontiers"](np.abs(grid)).any()
    assert (own["find_frontiers"](np.rot90(grid)) == np.rot90(ends)).all()
    nearest = exploring.nearest_frontier(own["find_frontiers"])
    *_, last = exploring.explore(own["travel_steps"], nearest, 1, 90)
    assert last.goal is None and last.part > 0.95


@pytest.mark.parametrize("way", ["frontier", "random", "lanes"])
def test_whatever_way_a_robot_goes_it_stays_off_boxes_and_forgets_nothing(own, way):
    choose = {
        "frontier": lambda: exploring.nearest_frontier(own["find_frontiers"]),
        "random": lambda: exploring.anywhere_known(np.random.default_rng(0)),
        "lanes": exploring.lawn_mower,
    }[way]()
    taken = exploring.room_of_boxes(3)
    seen = list(exploring.explore(own["travel_steps"], choose, 3, 25))
    assert len(seen) == 25
    for before, after in pairwise(seen):
        assert (after.grid[before.grid != exploring.UNKNOWN] != exploring.UNKNOWN).all()
        assert after.part >= before.part
        assert not taken[exploring.cell_of(after.place)]
        moved = np.abs(np.subtract(exploring.cell_of(after.place), exploring.cell_of(before.place))).sum()
        assert moved <= exploring.STRIDE
    assert 0.1 < seen[0].part < seen[-1].part <= 1


def lawn_mowers_goals(reachable, moves):
    """Goals of a lawn mower for whom some cells (rows, columns) can be reached, whether or not it gets to them."""
    choose, here, goals = exploring.lawn_mower(), exploring.cell_of(np.array(exploring.START)), []
    while (goal := choose(np.zeros(exploring.SHAPE, int), np.where(reachable, 1, -1), here)) is not None:
        goals.append(goal)
        here = goal if moves else here
    return goals


def test_a_lawn_mower_goes_to_the_ends_of_its_lanes_in_turn_as_near_as_it_can_for_fifteen_moves():
    everywhere, near = np.ones(exploring.SHAPE, dtype=bool), np.zeros(exploring.SHAPE, dtype=bool)
    goals = lawn_mowers_goals(everywhere, moves=True)
    rows, columns = np.transpose(goals)
    assert len(goals) == 8 and (np.diff(columns) >= 0).all()
    assert (rows == np.tile([rows.min(), rows.max(), rows.max(), rows.min()], 2)).all()
    assert rows.min() < 5 and rows.max() >= exploring.SHAPE[0] - 5
    near[10:20] = True
    assert {row for row, _ in lawn_mowers_goals(near, moves=True)} == {10, 19}
    goals = lawn_mowers_goals(everywhere, moves=False)
    assert [goals.count(each) for each in dict.fromkeys(goals)] == [15] * 8


def test_masks_and_steps_may_be_lists_and_other_kinds_of_numbers_and_what_is_none_is_refused():
    mask = [[True, False], [False, False]]
    assert exploring.as_mask(mask, (2, 2)).tolist() == mask
    assert exploring.as_mask(np.eye(2, dtype=int), (2, 2)).dtype == bool
    assert exploring.as_steps(np.array([[0.0, -1.0], [1.0, 2.0]]), (2, 2)).dtype.kind == "i"
    assert exploring.as_steps([[0, -1], [1, 2]], (2, 2)).sum() == 2
    for answer in (np.zeros((2, 2)), np.zeros((3, 2), bool), None):
        with pytest.raises(ValueError, match=r"boolean mask \(2, 2\)"):
            exploring.as_mask(answer, (2, 2))
    for answer in (np.full((2, 2), 0.5), np.zeros((3, 2), int), None):
        with pytest.raises(ValueError, match=r"whole numbers \(2, 2\)"):
            exploring.as_steps(answer, (2, 2))
