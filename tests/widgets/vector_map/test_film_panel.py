"""A film that the course ships, in a notebook."""

import pytest

from nao_course.films import recorded_film
from nao_course.widgets import show_film


def test_a_recorded_film_is_played_and_told_in_words_and_one_that_is_not_there_is_named_with_others():
    shown = show_film("08_graph_slam")._repr_mimebundle_()
    last = recorded_film("08_graph_slam")["captions"][-1]
    assert "application/vnd.jupyter.widget-view+json" in shown
    assert last in shown["text/plain"] and shown["text/html"].startswith("<p>Film: Graph SLAM")
    with pytest.raises(ValueError, match="there is no film '08'; there are 07_ekf_slam, 08_graph_slam"):
        show_film("08")
