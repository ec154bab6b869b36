"""What lesson 07, EKF SLAM, alone uses."""

from nao_course.lessons.ekf_slam.noise import joint_noise

__all__ = ["joint_noise"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
