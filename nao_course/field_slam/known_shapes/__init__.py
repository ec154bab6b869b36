"""Use of shapes whose sizes are known from the rules: the centre circle, and the calibration of the camera by them."""

__all__ = ["calibration", "circle"]
