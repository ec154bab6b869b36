"""Run when a kernel starts: an unknown name is explained in the course's words.

A lesson's set-up cell arranges the same, but after a restart of the kernel it has not been run yet.
"""


def _explain_unknown_names() -> None:
    from IPython import get_ipython

    shell = get_ipython()
    if shell is None:  # a plain Python, which also runs PYTHONSTARTUP
        return

    def show(self: object, kind: object, error: object, trace: object, tb_offset: object = None) -> None:
        from nao_course.exercises.trying import show_unknown_name  # slow to import, and rarely needed

        show_unknown_name(self, kind, error, trace, tb_offset)  # type: ignore[arg-type]

    shell.set_custom_exc((NameError,), show)


_explain_unknown_names()
del _explain_unknown_names
