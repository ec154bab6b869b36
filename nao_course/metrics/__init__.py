"""Scores of detectors, confidence intervals, and the consistency of estimators."""

from nao_course.metrics.consistency import band, log_density, squared_distances
from nao_course.metrics.detection import REACH, CornerTruth, PointMatch, corner_cost, match_points, total
from nao_course.metrics.statistics import mean_interval, wilson_interval

__all__ = [
    "REACH",
    "CornerTruth",
    "PointMatch",
    "band",
    "corner_cost",
    "log_density",
    "match_points",
    "mean_interval",
    "squared_distances",
    "total",
    "wilson_interval",
]
