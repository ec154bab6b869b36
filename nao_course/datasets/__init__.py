"""Recordings by others, read as the library's own values: pictures of a real robot."""

from nao_course.datasets.files import DATA_VARIABLE, data_folder
from nao_course.datasets.pictures import AnnotatedPoint, PictureSet, PointKind, RealPicture, read_pictures

__all__ = [
    "DATA_VARIABLE",
    "AnnotatedPoint",
    "PictureSet",
    "PointKind",
    "RealPicture",
    "data_folder",
    "read_pictures",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
