"""Legends say what is shown in words: no name of a variable, a function or a style stands in one."""

import ast
import re

from nao_course.plotting import STYLES
from nao_course.plotting.legends import landmark_keys, source_key
from nao_course.plotting.style import LANDMARK_MARKERS
from tests.paths import PROJECT
from tests.plotting.examples import DRAWINGS

_FORMULA = re.compile(r"\$[^$]*\$")


def is_a_name(label):
    """Whether a label has an underscore that a reader would see: not matplotlib's "_hidden", nor a formula's."""
    return "_" in _FORMULA.sub("", label) and not label.startswith("_")


def labels_written_in(path):
    """Texts that a module gives as `label=`, parts of f-strings among them, each with its line."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.keyword) and node.arg == "label":
            texts = [node.value, *getattr(node.value, "values", [])]
            yield from (
                (text.lineno, text.value)
                for text in texts
                if isinstance(text, ast.Constant) and isinstance(text.value, str)
            )


def test_every_key_has_words_and_each_kind_of_landmark_one_key():
    keys = [*map(source_key, STYLES), *landmark_keys(LANDMARK_MARKERS, "black", "the field's")]
    assert not [key.get_label() for key in keys if is_a_name(key.get_label())]
    keys = landmark_keys(["post", "corner", "post"], "black", "the field's")
    assert [key.get_label() for key in keys] == ["the field's corner", "the field's post"]
    assert landmark_keys([], "black", "the field's") == []
    legends = [legend for draw in DRAWINGS.values() for legend in draw().figure.legends]
    assert not [text for each in legends for text in each.get_texts() if is_a_name(text.get_text())]


def test_no_label_of_a_lesson_or_panel_is_a_name():
    named = [
        f"{path.relative_to(PROJECT)}:{line}: {label}"
        for path in sorted((PROJECT / "nao_course").rglob("*.py"))
        for line, label in labels_written_in(path)
        if is_a_name(label)
    ]
    assert not named
    assert is_a_name("robot_predicted") and is_a_name(r"robot_predicted, $\sigma_p$")
    assert not is_a_name(r"tilt, $\sigma_p$") and not is_a_name("_truth")
