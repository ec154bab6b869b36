"""The page of rubrics says each question, its points and its rubric."""

from nao_course.exercises import Written
from website.lessons import Lesson
from website.rubrics import rubrics_page

LESSON = Lesson("02_posts", "Posts", "You find them.", "", "NumPy", 90, 0, 5, 2, ())


def test_a_question_stands_below_its_lesson_with_its_points_and_its_rubric():
    page = rubrics_page([(LESSON, Written("why", points=2, question="Why?", rubric="1 point: so. 1: else."))])
    assert page.startswith("# ")
    assert "\n## 02 Posts, 2 points\n\nWhy?\n\n> 1 point: so. 1: else.\n" in page
