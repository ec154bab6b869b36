"""The progress bar: seen in a terminal and in a notebook, nowhere else."""

from __future__ import annotations

import io
import sys

from nao_course.challenges import progress
from nao_course.challenges.progress import Progress


class Handle:
    def __init__(self):
        self.shown = []

    def update(self, what):
        self.shown.append((what._repr_html_(), repr(what)))


def test_nothing_is_said_where_nobody_waits(capsys):
    bar = Progress(3, "scenes")
    bar.step()
    bar.end()
    assert capsys.readouterr() == ("", "")


def test_a_terminal_has_one_line_that_is_written_over(monkeypatch):
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "PAUSE", -1.0)
    bar = Progress(2, "scenes")
    bar.step()
    bar.step()
    bar.end()
    assert terminal.getvalue() == "\r1 of 2 scenes\r2 of 2 scenes\r2 of 2 scenes\n"


def test_a_notebook_has_a_labelled_bar_that_ends_as_words(monkeypatch):
    handle = Handle()
    monkeypatch.setattr(progress, "_display", lambda html, text: handle)
    monkeypatch.setattr(progress, "PAUSE", -1.0)
    bar = Progress(2, "scenes")
    bar.step()
    bar.end()
    (bar_html, text), (end, _) = handle.shown
    assert '<progress aria-label="scenes" value="1" max="2">' in bar_html and text == "1 of 2 scenes"
    assert end == "<small>1 of 2 scenes</small>"
