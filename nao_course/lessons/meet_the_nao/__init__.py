"""What lesson 00, Meet the NAO, alone uses."""

from nao_course.lessons.meet_the_nao.figures import draw_cameras, draw_drift, draw_frames, plot_footprint

__all__ = ["draw_cameras", "draw_drift", "draw_frames", "plot_footprint"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
