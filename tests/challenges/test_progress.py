"""The progress bar: seen in a terminal and in a notebook, nowhere else."""

import io
import sys
from types import SimpleNamespace

import pytest

from nao_course.challenges import progress
from nao_course.challenges.progress import Progress


@pytest.fixture(autouse=True)
def _no_pause(monkeypatch):
    monkeypatch.setattr(progress, "PAUSE", -1.0)


def go(steps):
    bar = Progress(2, "scenes")
    for _ in range(steps):
        bar.step()
    bar.end()


def test_nothing_is_said_where_nobody_waits_and_a_terminal_has_one_line_written_over(capsys, monkeypatch):
    go(1)
    assert capsys.readouterr() == ("", "")
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    go(2)
    assert terminal.getvalue() == "\r1 of 2 scenes\r2 of 2 scenes\r2 of 2 scenes\n"


def test_a_notebook_has_a_labelled_bar_that_ends_as_words(monkeypatch):
    shown = []
    handle = SimpleNamespace(update=lambda what: shown.append((what._repr_html_(), repr(what))))
    monkeypatch.setattr(progress, "_display", lambda html, text: handle)
    go(1)
    (bar, text), (end, _) = shown
    assert '<progress aria-label="scenes" value="1" max="2">' in bar and text == "1 of 2 scenes"
    assert end == "<small>1 of 2 scenes</small>"
