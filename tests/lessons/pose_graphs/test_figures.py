"""Figures of lesson 09: what they say is what the text says."""

from hashlib import sha256

import numpy as np
import pytest
import scipy.sparse
from scipy.sparse.linalg import splu

from nao_course.datasets.intel import FILE
from nao_course.lessons import pose_graphs
from nao_course.lessons.pose_graphs.guesses import HEADINGS, POSITIONS
from nao_course.lessons.pose_graphs.information import FRAMES, missed_steps, scaled
from nao_course.lessons.pose_graphs.matrices import block_picture
from tests.lessons.pose_graphs.own import OWN

SOLVE, LINEARIZE = OWN["gauss_newton"], OWN["linearize"]


def test_the_payoff_says_how_the_building_relaxes_and_the_whole_map_moves_freely_in_three_ways():
    said = pose_graphs.draw_relaxing(SOLVE).alt
    assert "off by 6.67 m" in said and "chi2 8,766 and off by 1.32 m" in said
    assert "off by 0.59 m" in said and "chi2 408.7 and off by 0.65 m" in said
    assert pose_graphs.count_of_free_moves(LINEARIZE) == 3
    said = pose_graphs.draw_free_moves(LINEARIZE).alt
    assert said.count("H times it is 0") == 3 and "a map of 9 poses" in said
    assert "3 of 27 eigenvalues are zero" in said


def test_a_step_predicts_too_low_a_chi2_and_climbs_from_63_degrees_on():
    drawing = pose_graphs.draw_step(LINEARIZE, SOLVE, OWN["pose_residual"], OWN["landmark_residual"])
    assert "90 degrees the full step leaves 2.00 of chi2 where 0.013 was predicted" in drawing.alt
    assert "at 0.35 of it" in drawing.alt
    assert len({ax.get_ylim() for ax in drawing.figure.axes[:2]}) == 1
    assert pose_graphs.drift_that_climbs(SOLVE) == pytest.approx(63.2, abs=0.1)

    def ratio(drift):
        world = pose_graphs.drifting_loop(np.radians(drift), 20)  # of 80 poses
        chi2 = SOLVE(world.graph, world.odometry, 1)[1]
        return chi2[1] / chi2[0]

    assert ratio(58) < 1 < ratio(59.5)


def test_the_data_say_in_which_frame_the_information_is_and_headings_do_harm_and_positions_do_not():
    residuals, measured = missed_steps(OWN["pose_residual"], range(1, 11))
    corners = np.abs(np.sin(measured[:, 2])) > 0.5
    right, wrong = (scaled(residuals, measured, frame)[corners].std(axis=0) for frame in FRAMES)
    assert right == pytest.approx([1, 1], abs=0.1) and wrong == pytest.approx([0.6, 1.67], abs=0.1)
    said = pose_graphs.draw_information_frames(OWN["pose_residual"]).alt
    assert "of corners 1.00 and 1.02" in said and "of corners 0.61 and 1.66" in said
    found = pose_graphs.arrivals(SOLVE, positions=(1000.0,), headings=(20.0, 70.0), tries=4)
    assert found["positions"] == pytest.approx(1.0) and found["headings"].tolist() == [1.0, 0.0]
    parts = {"positions": np.ones(len(POSITIONS)), "headings": np.linspace(1, 0, len(HEADINGS))}
    assert "50 % at 40 degrees" in pose_graphs.draw_arrivals(parts).alt
    assert pose_graphs.half_of_them((10.0, 20.0), np.array([0.8, 0.2])) == pytest.approx(15.0)
    assert np.isnan(pose_graphs.half_of_them((10.0, 20.0), np.array([0.8, 0.6])))


def test_the_order_decides_what_the_factor_adds_and_blocks_are_painted_by_what_they_link():
    world = pose_graphs.building(5)
    H = LINEARIZE(world.graph, world.truth)[0].tocsc()[3:, 3:]
    options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    natural, minimum = (splu(H, order, **options).L.nnz for order in ("NATURAL", "MMD_AT_PLUS_A"))
    assert 100 * H.nnz / H.shape[0] ** 2 == pytest.approx(0.9, abs=0.05)
    assert scipy.sparse.tril(H).nnz == 7137 and natural == 120_000 and round(minimum, -3) == 14_000
    H = np.zeros((8, 8))
    H[:3, :3] = H[3:6, 3:6] = H[6:, 6:] = H[0, 3] = H[3, 0] = H[1, 6] = H[6, 1] = 1
    cells = block_picture(H, 2, 30)[6::10, 6::10]
    assert (cells[0, 1] == cells[1, 0]).all() and (cells[0, 1] == (60, 60, 66)).all()
    assert (cells[0, 2] == (161, 69, 102)).all() and (cells[1, 2] == 255).all()


def test_closures_shrink_the_ellipses_ninefold_and_a_false_one_bends_the_map():
    drawing = pose_graphs.draw_uncertainty(LINEARIZE, SOLVE, OWN["marginal_covariances"])
    assert "0.39 to 5.10 m" in drawing.alt and "0.08 to 0.60 m" in drawing.alt
    assert len({(*ax.get_xlim(), *ax.get_ylim()) for ax in drawing.figure.axes}) == 1
    assert "one false closure added, off by 3.41 m." in pose_graphs.draw_false_closure(SOLVE).alt


def test_a_real_building_is_drawn_and_its_file_is_the_published_one():
    assert "943 poses" in (alt := pose_graphs.draw_real_building(SOLVE).alt)
    assert "odometry 205,887" in alt and "after 3 steps 546.5" in alt
    assert sha256(FILE.read_bytes()).hexdigest().startswith("4d87aaf96e1e04e4")
    assert "Redistributions of source code" in FILE.with_name("intel_license.txt").read_text(encoding="utf-8")
