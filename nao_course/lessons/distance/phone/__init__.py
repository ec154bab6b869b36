"""The phone lab of lesson 04: a printed half field, the student's photograph of it, and their landmarks on the map."""

from nao_course._internal.lazy_names import list_public
from nao_course.lessons.distance.phone.lab import PhoneLab
from nao_course.lessons.distance.phone.photo import Photo, read_photo, view_from_points
from nao_course.lessons.distance.phone.sheet import sheet_pdf

__all__ = ["PhoneLab", "Photo", "read_photo", "sheet_pdf", "view_from_points"]
__dir__ = list_public(__name__)
