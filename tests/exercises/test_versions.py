"""A version in a notebook is any text; what it explains are only errors that an older version makes."""

from nao_course.exercises import versions
from nao_course.exercises.versions import in_words, newer_than_here, numbers, stated_versions


def test_versions_are_compared_by_two_numbers_and_what_is_none_is_older_than_any(monkeypatch):
    for text in ["", "3", "x.y", "9" * 400 + ".1", "3.12 <b>", "\u0663.\u0661"]:
        told = {"python": text, "numpy": text}
        assert not newer_than_here(told) and stated_versions(told) == {} and in_words(told) == ""
    for told in [None, 3, "numpy", [], {"numpy": {"a": 1}, "x": "1.2"}, {"numpy": 2.4}]:
        assert stated_versions(told) == {}
    monkeypatch.setattr(versions, "installed_versions", lambda: {"python": "3.11.7", "numpy": "2.4.6"})
    assert (numbers("3.14.0rc2"), numbers("2.10")) == ((3, 14), (2, 10))
    assert not newer_than_here({"python": "3.11.9", "numpy": "2.4.9", "release": "9.9"})
    newer = newer_than_here({"python": "3.9.1", "numpy": "2.10.0"})
    assert newer.against("the grader") == "NumPy 2.10, and the grader has NumPy 2.4"


def test_only_errors_of_an_older_version_are_explained():
    for error, of in [
        ("SyntaxError: invalid syntax", {"python"}),
        ("AttributeError: module 'math' has no attribute 'fma'", {"python"}),
        ("AttributeError: module 'numpy' has no attribute 'x'", {"python", "numpy"}),
        ("AttributeError: module 'numpy.linalg' has no attribute 'x'", {"python", "numpy"}),
        ("ImportError: cannot import name 'batched' from 'itertools' (/x)", {"python"}),
        ("ModuleNotFoundError: No module named 'annotationlib'", {"python"}),
        ("ModuleNotFoundError: No module named 'string.templatelib'; 'string' is not a package", {"python"}),
        ("ModuleNotFoundError: No module named 'torch'", set()),
        ("AttributeError: module 'helper' has no attribute 'x'", set()),
        ("NameError: name 'x' is not defined", set()),
        ("IndentationError: unexpected indent", set()),
        ("TypeError: reshape() got an unexpected keyword argument 'shape'", {"python", "numpy"}),
    ]:
        theirs = {"python": "99.1", "numpy": "99.1"}
        assert {name for name in theirs if newer_than_here({name: theirs[name]}).explains(error)} == of
