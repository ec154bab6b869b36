"""A page that is wrong is found out: a link, an anchor, a picture, another host."""

import pytest

from website.checks import offences, read_page

FINE = """<a id="top" href="#top">here</a> <a href="b.html#part">there</a> <a href="https://example.org">away</a>
<img src="a.png" alt="a robot"> <link rel="stylesheet" href="a.png?v=1">
<img alt="drawn" src="data:image/png;base64,">"""


@pytest.fixture
def pages(tmp_path):
    (tmp_path / "index.html").write_text(FINE)
    (tmp_path / "b.html").write_text('<p id="part">')
    (tmp_path / "a.png").touch()
    return tmp_path


def test_what_is_wrong_is_said_with_its_page(pages):
    assert offences(pages) == []
    for wrong, said in (
        *((f'<a href="{to}">', f"leads nowhere: {to}") for to in ("c.html", "b.html#other", "#bottom")),
        ('<img src="c.png" alt="a robot">', "leads nowhere: c.png"),
        *((f'<img src="a.png"{alt}>', "a picture without alt text: a.png") for alt in ("", ' alt=" "')),
        ('<script src="https://example.org/x.js"></script>', "asks another host: https://example.org/x.js"),
        ('<link rel="stylesheet" href="//example.org/x.css">', "asks another host: //example.org/x.css"),
    ):
        (pages / "index.html").write_text(FINE + wrong)
        assert offences(pages) == [f"index.html: {said}"]


def test_code_and_words_of_a_page_can_be_read_and_a_folder_without_a_first_page_is_found_out(tmp_path):
    assert offences(tmp_path) == ["there is no index.html"]
    (tmp_path / "a.html").write_text("<p>Say</p><pre><span>x</span> = &lt;1</pre> and <pre>y</pre> go")
    page = read_page(tmp_path / "a.html")
    assert page.code == ["x = <1", "y"]
    assert "".join(page.words) == "Sayx = <1 and y go"
