"""The hub of an exam, on a server of its own: one time for everybody, and nothing from before.

docs/run_a_hub.md, "An exam", says how to start it.
"""

from datetime import UTC, datetime, timedelta
from pathlib import Path

c = get_config()  # noqa: F821 - JupyterHub puts it there
load_subconfig(str(Path(__file__).with_name("jupyterhub_config.py")))  # noqa: F821 - JupyterHub puts it there
from names import system_name  # noqa: E402 - beside this file

# --- your exam: change these three ---

BEGIN = datetime.fromisoformat("2027-02-10T10:00:00+01:00")
END = datetime.fromisoformat("2027-02-10T11:30:00+01:00")
EXTRA_MINUTES = {}  # by e-mail address, for example {"ada@uni.example": 30}

extra = {system_name(claim): timedelta(minutes=minutes) for claim, minutes in EXTRA_MINUTES.items()}
make_account = c.Spawner.pre_spawn_hook


class ExamTimeError(Exception):
    """A server was to start before the exam begins or after it has ended."""

    def __init__(self, end):
        self.jupyterhub_message = f"The exam is from {BEGIN:%H:%M} to {end:%H:%M}."  # what the student reads
        super().__init__(self.jupyterhub_message)


def admit(spawner):
    """Start a server only while the exam is on, and let systemd stop it at the student's own end."""
    now, end = datetime.now(UTC), END + extra.get(spawner.user.name, timedelta())
    if not BEGIN <= now < end:
        raise ExamTimeError(end)
    make_account(spawner)
    left = f"{(end - now).total_seconds():.0f}"
    spawner.unit_extra_properties = {**spawner.unit_extra_properties, "RuntimeMaxSec": left}


c.Spawner.pre_spawn_hook = admit
