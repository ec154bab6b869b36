"""The whole robot: pictures to measurements, drives over the field, and what each way of SLAM makes of them."""

__all__ = [
    "association",
    "careful",
    "circle",
    "compass",
    "demo",
    "drives",
    "lines",
    "observation",
    "walk",
    "ways",
    "whole_picture",
]
