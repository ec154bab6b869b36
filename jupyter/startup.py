"""Run when a kernel of this environment starts: a name that is not known yet gets the course's sentence.

A lesson's set-up cell does the same; after a restart of the kernel it has not been run.
"""


def _explain_unknown_names():
    from IPython import get_ipython

    def show(self, kind, error, trace, tb_offset=None):
        from nao_course.exercises.trying import show_unknown_name  # it takes long to import, and few need it

        show_unknown_name(self, kind, error, trace, tb_offset)

    get_ipython().set_custom_exc((NameError,), show)


_explain_unknown_names()
del _explain_unknown_names
