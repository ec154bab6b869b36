"""Figures, logs and filters of lesson 07, EKF SLAM."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "ablations": ("ablate", "ablation_table", "draw_ablations"),
        "bent_map": ("draw_bearings", "draw_bent_map", "draw_covariance_test", "draw_second_error"),
        "blocks": ("draw_blocks",),
        "consistency": ("compare", "draw_consistency", "say_rotation"),
        "costs": ("draw_costs",),
        "evaluation": ("NIS_REMARKS", "distances_table", "draw_nis", "mean_nis", "personal_table"),
        "film": ("draw_film", "record_film"),
        "filters": ("CompressedFilter", "FirstEstimates"),
        "homework_log": ("OWN_SIGMAS", "own_log"),
        "invariant": ("draw_invariant", "group_sheet"),
        "loop": ("LOOP_REMARKS", "draw_loop", "last_deviation"),
        "noise": ("joint_noise",),
        "panel": ("FilmPanel",),
        "real_walk": ("draw_real_map",),
        "recorded_log": ("draw_mrclam",),
        "starts": ("draw_starts",),
    },
)
