"""Submissions that consist of the course's own answers, and written answers with the same words."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from nao_course.instructor.similarity.comparing import LEAST_SHARED, Work, fingerprints

# An exercise is the course's own from this share of an answer's fingerprints on. Of the right answers of this course,
# each has at most 0.45 of another one to the same exercise; a copy with other names and comments has all of it.
SAME = 0.6
LEAST_PART = 0.5  # of a lesson's exercises, for a submission to be listed
SAME_WORDS = 0.6  # of all runs of RUN words that two written answers have, for them to be the same
RUN, FEWEST_WORDS = 3, 6


@dataclass(frozen=True)
class CourseAnswers:
    """A student's exercises that are answers of the course, of how many that are long enough to say so."""

    student: str
    exercises: tuple[str, ...]
    of: int


@dataclass(frozen=True)
class SameWords:
    """Students who answered a question with the same words, and perhaps so did the course's model answer.

    `text` is the first one's answer.
    """

    question: str
    students: tuple[str, ...]
    is_model: bool
    text: str


def course_answers(
    works: Iterable[Work], answers: Mapping[str, Sequence[str]], given: Iterable[str]
) -> list[CourseAnswers]:
    """Return the students of whose exercises at least LEAST_PART are answers of the course, most of them first.

    `answers` are the course's, by exercise, and `given` is the code that all students have. An answer that has few
    fingerprints of its own is left out, because independent answers would be equal to it.
    """
    released = set[int]().union(*map(fingerprints, given))
    known = {name: [fingerprints(code) - released for code in codes] for name, codes in answers.items()}
    known = {name: codes for name, codes in known.items() if codes and len(codes[0]) >= LEAST_SHARED}
    found = []
    for work in works:
        own = set[int]().union(*map(fingerprints, work.cells))
        same = tuple(
            name
            for name, codes in known.items()
            if any(len(code & own) >= SAME * len(code) for code in codes if len(code) >= LEAST_SHARED)
        )
        if same and len(same) >= LEAST_PART * len(known):
            found.append(CourseAnswers(work.student, same, len(known)))
    return sorted(found, key=lambda each: (-len(each.exercises), each.student))


def same_words(written: Mapping[str, Mapping[str, str]], models: Mapping[str, str]) -> list[SameWords]:
    """Return the groups of students who answered a question with nearly the same words.

    `written` are the students' answers by student and question, and `models` the course's by question. Answers of
    few words are left out.
    """
    found = []
    for question in sorted({question for answers in written.values() for question in answers}):
        texts = {
            student: answers[question] for student, answers in sorted(written.items()) if question in answers
        }
        runs = {student: _runs(text) for student, text in texts.items()}
        runs = {student: of for student, of in runs.items() if of}
        model = _runs(models.get(question, ""))
        group = {student: student for student in runs}

        def first(student: str, group: dict[str, str] = group) -> str:
            while group[student] != student:
                student = group[student]
            return student

        for one, other in combinations(runs, 2):
            if _is_same(runs[one], runs[other]):
                one, other = sorted((first(one), first(other)))
                group[other] = one
        for head in runs:
            students = tuple(each for each in runs if first(each) == head)
            is_model = any(_is_same(runs[each], model) for each in students)
            if len(students) > 1 or (students and is_model):
                found.append(SameWords(question, students, is_model, texts[students[0]]))
    return found


def _runs(text: str) -> frozenset[tuple[str, ...]]:
    """Return the runs of words of an answer; none if it has few words."""
    words = re.findall(r"\w+", text.casefold())
    if len(words) < FEWEST_WORDS:
        return frozenset()
    return frozenset(tuple(words[at : at + RUN]) for at in range(len(words) - RUN + 1))


def _is_same(one: frozenset[tuple[str, ...]], other: frozenset[tuple[str, ...]]) -> bool:
    return bool(one and other) and len(one & other) >= SAME_WORDS * len(one | other)
