"""A short lesson is not held to the rules that its plan waives, and to all others."""

import re
from types import SimpleNamespace

import pytest

from nao_course.instructor.authoring.declarations import WAIVABLE
from tests.lessons import every, test_exercises, test_lessons
from tests.lessons.every import waiver

RULES = [name for module in (test_lessons, test_exercises) for name in vars(module) if "test_rubric_" in name]


@pytest.mark.parametrize("rule", WAIVABLE)
def test_each_rule_that_can_be_waived_has_a_test_that_is_then_skipped(rule):
    skipped = [name for name in RULES if waiver(name, {rule: "a lab"})]
    assert skipped and all(re.match(rf"test_rubric_{rule}_", name) for name in skipped)
    assert waiver(skipped[0], {rule: "a lab"}) == f"rule {rule} is waived, a lab"
    assert not waiver(skipped[0], {})


@pytest.mark.parametrize("module", [test_lessons, test_exercises])
def test_the_tests_of_rules_ask_for_waivers_and_a_lessons_waivers_are_those_of_its_plan(module, monkeypatch):
    assert module.waived_rules_are_skipped is every.waived_rules_are_skipped
    plans = {"13_lab": SimpleNamespace(waived={"3": "a lab"})}
    monkeypatch.setattr(every, "COURSE", SimpleNamespace(plan=plans.get))
    every.waived.cache_clear()
    assert every.waived("13_lab") == {"3": "a lab"}
    every.waived.cache_clear()
