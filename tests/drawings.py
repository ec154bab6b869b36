"""What holds for every figure, of the library and of a lesson."""

import html
import re


def assert_same_bytes_with_words(make):
    """Two drawings of the same are the same files, and a notebook gets a small one with its words."""
    drawing, again = make(), make()
    assert drawing.image() == again.image()
    assert drawing.image("svg") == again.image("svg")
    shown = drawing._repr_html_()
    assert html.unescape(re.search(r'alt="([^"]*)"', shown).group(1)) == drawing.alt
    assert len(drawing.alt) > 60
    assert 'src="data:image/' in shown
    assert len(shown) < 250_000
