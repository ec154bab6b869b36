"""Readers for recorded data: pictures of a real robot, logs of drives, and pose graphs."""

from typing import TYPE_CHECKING

from nao_course._internal.lazy_names import import_as_typed, list_public

if TYPE_CHECKING:
    from nao_course.datasets.carmen import CarmenLog, read_carmen_log
    from nao_course.datasets.files import DATA_VARIABLE, data_folder
    from nao_course.datasets.freiburg_graph import read_freiburg_graph
    from nao_course.datasets.g2o import read_g2o, write_g2o
    from nao_course.datasets.intel import intel_graph
    from nao_course.datasets.logs import (
        FreiburgLog,
        HomeworkLog,
        Observations,
        read_freiburg_log,
        read_homework_log,
        write_homework_log,
    )
    from nao_course.datasets.mcap_log import read_mcap_log
    from nao_course.datasets.mrclam import MrclamLog, read_mrclam_log
    from nao_course.datasets.pictures import AnnotatedPoint, PictureSet, PointKind, RealPicture, read_pictures
    from nao_course.datasets.real_walk import recorded_walk
    from nao_course.datasets.victoria_park import VictoriaParkLog, read_victoria_park

__all__ = [
    "DATA_VARIABLE",
    "AnnotatedPoint",
    "CarmenLog",
    "FreiburgLog",
    "HomeworkLog",
    "MrclamLog",
    "Observations",
    "PictureSet",
    "PointKind",
    "RealPicture",
    "VictoriaParkLog",
    "data_folder",
    "intel_graph",
    "read_carmen_log",
    "read_freiburg_graph",
    "read_freiburg_log",
    "read_g2o",
    "read_homework_log",
    "read_mcap_log",
    "read_mrclam_log",
    "read_pictures",
    "read_victoria_park",
    "recorded_walk",
    "write_g2o",
    "write_homework_log",
]
__getattr__ = import_as_typed(__name__, __file__)
__dir__ = list_public(__name__)
