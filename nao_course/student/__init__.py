"""The student's side of the course: their own functions, their robot, and their progress."""

from nao_course._internal.lazy_names import list_public
from nao_course._internal.personal_world import personal_world
from nao_course.student.notebooks import earlier, functions
from nao_course.student.overview import progress
from nao_course.student.personal import personal_table
from nao_course.student.robot import my_nao
from nao_course.student.strip import so_far

__all__ = ["earlier", "functions", "my_nao", "personal_table", "personal_world", "progress", "so_far"]
__dir__ = list_public(__name__)
