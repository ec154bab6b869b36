"""`nao-course similar`: read the submissions, compare the students' own code, write the page."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from nao_course._internal.counts import say_count
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.scratch import scratch_folder
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.submissions import gather
from nao_course.instructor.reports.html import write_whole
from nao_course.instructor.similarity.comparing import LONGEST, Work, compare
from nao_course.instructor.similarity.course_answers import course_answers, same_words
from nao_course.instructor.similarity.known_code import given_code, known_code, model_answers, right_answers
from nao_course.instructor.similarity.own_code import own_code
from nao_course.instructor.similarity.page import Found, similar_page

PAGE = "similar.html"
_MOST_PLACES = 3  # of hidden code that are named


def find_similar(console: Console, path: Path, lessons: Sequence[str], out: Path) -> Iterator[str]:
    """Write the page of similar notebooks; yield what to say about it.

    `path` is what `nao-course grade` accepts; by default all lessons are compared. Raise a ValueError if there are not
    two notebooks of a lesson.
    """
    course = load_course()
    with scratch_folder() as scratch, Progress(console=console, transient=True) as progress:
        found = gather(path, scratch, course.names(), course.names(lessons))
        left_out = [f"{each.student}, {each.lesson}: {each.reason}" for each in found.refused]
        left_out += found.not_graded
        works: dict[str, list[Work]] = defaultdict(list)
        written: dict[str, dict[str, Mapping[str, str]]] = defaultdict(dict)
        for each in progress.track(found.submissions, description="reading"):
            whose = f"{each.student}, {each.lesson}"
            try:
                own = own_code(each)
            except Refused as refused:
                left_out.append(f"{whose}: {refused}")
                continue
            work = Work(each.student, own.cells)
            works[each.lesson].append(work)
            written[each.lesson][each.student] = own.written
            if own.hidden:
                places = "; ".join(own.hidden[:_MOST_PLACES])
                left_out.append(
                    f"{whose}: code that is put together while it runs was not compared ({places})"
                )
            if len(work.code) > LONGEST:
                left_out.append(f"{whose}: only the first {LONGEST} characters of its code were compared")
        if not any(len(each) > 1 for each in works.values()):
            raise ValueError(
                f"{path} contains no two notebooks of a lesson to compare. Give a folder of "
                "STUDENT/01_hsl_filtering.ipynb with several students"
            )
        found_in = {}
        for lesson in sorted(works):
            of_lesson = compare(progress.track(works[lesson], description=lesson), known_code(course, lesson))
            found_in[lesson] = Found(
                of_lesson,
                course_answers(works[lesson], right_answers(course, lesson), given_code(course, lesson)),
                same_words(written[lesson], model_answers(course, lesson)),
            )
            yield (
                f"{lesson}: {say_count(of_lesson.compared, 'notebook')}, "
                f"{say_count(len(of_lesson.pairs), 'similar pair')}, "
                f"{len(found_in[lesson].course_answers)} with the course's own answers, "
                f"{say_count(len(found_in[lesson].same_words), 'group')} with the same words"
            )
            for common in of_lesson.common:
                yield f"{lesson}: {say_count(len(common.works), 'notebook')} with the same common code"
    for line in left_out:
        yield f"not compared: {line}"
    yield f"wrote {write_whole(out / PAGE, similar_page(found_in, left_out))}"
