"""EKF SLAM: consistency, recorded logs, time per step."""
