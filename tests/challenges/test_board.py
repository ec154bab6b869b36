"""The board: rows in order, an entry beside them, the best so far."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from nao_course.challenges import Board
from nao_course.challenges.best import SUFFIX
from nao_course.challenges.board import SIGNIFICANT, _by_chance, _in_cases
from nao_course.plotting import Drawing
from tests.challenges.example import CHALLENGE, COST, double


def names(table):
    return [row[0] for row in table.rows]


@pytest.fixture
def board(tmp_path):
    return Board(CHALLENGE, tmp_path)


def same(numbers):
    return numbers


def test_a_board_says_task_score_rows_and_that_it_is_not_graded(board, tmp_path):
    words = ("Double what is given.", "one less the mean error", "not graded", "0.75", "worst scene")
    for shown in (repr(board), board._repr_html_()):
        assert all(each in shown for each in (*words, "you, best so far", "enter(my_function)"))
    assert not list(tmp_path.iterdir())
    shown = Board(replace(CHALLENGE, task="Find x < 3 & <b>."), tmp_path)._repr_html_()
    assert "Find x &lt; 3 &amp; &lt;b&gt;." in shown


def test_the_best_so_far_takes_its_place_among_the_rows(board, tmp_path):
    assert names(board.table()) == ["nothing", "the reference", "you, best so far"]
    assert board.table().rows[-1][1] == "-"
    report = board.enter(same)
    assert report.score == 0.5 and names(board.table()) == ["nothing", "you, best so far", "the reference"]
    assert 'your first. It is better than "nothing" (0.00), better in 2 scenes: this' in repr(report)
    table = report.table()  # its columns say how the score came about
    assert table.columns == ("", "score", "worst scene", "off")
    assert table.rows[1] == ("you, best so far", "0.50", "0.00", "0.5 m")
    better = repr(board.enter(double))
    assert 'best so far; it was 0.50. It is better than "the reference" (0.75), better in 2' in better
    again = board.enter(double)
    assert "as good as your best so far" in repr(again) and "this entry" not in names(again.table())
    worse = board.enter(lambda numbers: 2.75 * numbers)
    assert names(worse.table()) == ["nothing", "this entry", "the reference", "you, best so far"]
    assert "Your best so far stays 1.00." in repr(worse)
    assert Board(CHALLENGE, tmp_path).table().rows[-1][:3] == ("you, best so far", "1.00", "1.00")


def test_a_score_that_is_shown_as_another_is_level_with_it_and_one_better_in_few_cases_chance(board):
    report = board.enter(lambda numbers: 2.5001 * numbers)
    assert report.score == pytest.approx(0.74995)
    assert "better in all 3 scenes: this difference may be chance; it is level with" in repr(report)
    run = board.enter(same).run
    first, *others = (each.score for each in run.results)
    tied = replace(CHALLENGE.rows[0], cases=(first - 1.0, *(each + 1.0 for each in others)))
    chance = ": this difference may be chance"
    assert _in_cases(run, tied, 1) == f", better in 1 scene and worse in 2{chance}"
    assert _in_cases(run, tied, -1) == f", which is better in 2 scenes and worse in 1{chance}"
    run = replace(run, challenge=replace(CHALLENGE, sampled=False))
    assert _in_cases(run, tied, 1) == ", better in 1 scene and worse in 2"


def test_a_difference_is_called_chance_by_a_sign_test_that_leaves_ties_out():
    # Thirteen of fifteen, whatever the number of ties.
    assert _by_chance(13, 2) == pytest.approx(2 * (105 + 15 + 1) / 2**15)
    assert _by_chance(16, 14) > 0.8 and _by_chance(12, 8) > 0.5 and _by_chance(2, 13) == 1.0
    assert _by_chance(5, 0) > SIGNIFICANT >= _by_chance(6, 0)
    # Of equal entries on thirty scenes, the first is called better in half of 5 %.
    drawn = np.random.default_rng(4).integers(2, size=(20_000, 30)).sum(axis=1)
    assert 0.02 < np.mean([_by_chance(wins, 30 - wins) <= SIGNIFICANT for wins in drawn]) < 0.03


def test_a_cost_is_better_the_smaller_it_is_and_has_a_unit(tmp_path):
    board = Board(COST, tmp_path)
    assert 'next is "the reference" (0.25 m).' in repr(board.enter(same))
    assert names(board.table()) == ["nothing", "you, best so far", "the reference"]


def test_an_entry_that_is_interrupted_leaves_the_best_as_it_was(board, tmp_path):
    board.enter(double)
    kept = (tmp_path / f"77_doubling{SUFFIX}").read_bytes()

    def entry(numbers):
        raise KeyboardInterrupt

    report = board.enter(entry)
    assert "Interrupted after 0 of 3 scenes" in repr(report) and "stays 1.00" in repr(report)
    assert (tmp_path / f"77_doubling{SUFFIX}").read_bytes() == kept and report.figure is None


def test_a_broken_file_is_said_on_the_board_and_in_the_report(tmp_path):
    (tmp_path / f"77_doubling{SUFFIX}").write_text("broken")
    board = Board(CHALLENGE, tmp_path)
    for shown in (repr(board), board._repr_html_()):  # a notebook asks for both, and shows the second
        assert "renamed to 77_doubling.challenge.json.old-1" in shown
    (tmp_path / f"77_doubling{SUFFIX}").write_text("broken")
    assert "old-2" in Board(CHALLENGE, tmp_path).enter(double)._repr_html_()


def test_the_report_shows_the_figure_and_what_entries_say_as_text_and_an_example_is_a_copy(tmp_path, board):
    drawn = replace(CHALLENGE, figure=lambda run: Drawing(Figure(figsize=(1, 1)), f"{run.score} drawn"))

    def entry(numbers):
        if len(numbers) > 1:
            raise ValueError("<script>")
        return np.ones(1)

    report = Board(drawn, tmp_path).enter(entry)
    shown = report._repr_html_()
    assert "<script>" not in shown and "&lt;script&gt;" in shown and 'alt="0.0 drawn"' in shown
    assert "0.0 drawn" in repr(report)
    for _ in range(2):
        example = board.example(3)
        assert example.tolist() == [0.0, 1.0, 2.0]
        example[:] = 7
    with pytest.raises(ValueError, match="from 1 to 3, got 0"):
        board.example(0)


def test_an_entry_without_any_answer_is_no_first_best(board, tmp_path):
    report = board.enter(lambda numbers: None)
    assert list(tmp_path.iterdir()) == [] and np.isnan(report.score)
    assert "It is your first" not in repr(report) and "must return shape" in repr(report)
    assert "Stopped after 2 of 3 scenes, without a score" in repr(report)
    board.enter(double)
    assert "Your best so far stays 1.00." in repr(board.enter(lambda numbers: None))
