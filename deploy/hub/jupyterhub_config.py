"""JupyterHub for a class on one server. docs/setup.md says how to install it; each option says why it is here."""

import os
import pwd
import subprocess
import sys
from pathlib import Path

COURSE = Path(os.environ.get("NAO_COURSE_FOLDER", "/opt/nao-course"))  # where install.sh put everything
HUB = Path(__file__).resolve().parent
sys.path.insert(0, str(HUB))
from names import system_name  # noqa: E402 - beside this file

c = get_config()  # noqa: F821 - JupyterHub puts it there

# --- your university: change these five, with what the learning platform shows after the registration ---

c.JupyterHub.authenticator_class = "ltiauthenticator.lti13.auth.LTI13Authenticator"
c.LTI13Authenticator.issuer = "https://moodle.example.edu"
c.LTI13Authenticator.client_id = {"the client ID that Moodle shows"}
c.LTI13Authenticator.authorize_url = "https://moodle.example.edu/mod/lti/auth.php"
c.LTI13Authenticator.jwks_endpoint = "https://moodle.example.edu/mod/lti/certs.php"
c.Authenticator.admin_users = set()  # e-mail addresses of those who may stop other people's servers

# --- who a student is ---

# In the platform's sheet of grades, so that collect.py can name each folder as the exports need it.
c.LTI13Authenticator.username_key = "email"
c.LTI13Authenticator.uri_scheme = "https"  # the hub itself sees only the web server's HTTP
# Whoever the platform lets open the activity may come in.
c.Authenticator.allow_all = True


def name_account(authenticator, handler, user):
    """Name the hub's user after a system account that no claim of the platform can choose freely."""
    return {**user, "name": system_name(user["name"])}


def make_account(spawner):
    """Create the student's account: no password, and a home folder that nobody else can read."""
    try:
        pwd.getpwnam(spawner.user.name)
    except KeyError:
        options = ["--create-home", "--key", "HOME_MODE=0700", "--shell", "/bin/bash"]
        subprocess.run(["useradd", *options, spawner.user.name], check=True)


c.Authenticator.post_auth_hook = name_account
c.Spawner.pre_spawn_hook = make_account

# --- a student's server ---

# One unit of systemd for each student: it has its own limits, and survives a restart of the hub.
c.JupyterHub.spawner_class = "systemdspawner.SystemdSpawner"
c.JupyterHub.cleanup_servers = False
# Brings newer lessons into the student's folder, and then becomes the student's JupyterLab.
c.Spawner.cmd = [str(COURSE / ".venv" / "bin" / "nao-course"), "lab"]
c.Spawner.environment = {
    "NAO_COURSE_RELEASE": str(COURSE / "release"),
    "MALLOC_ARENA_MAX": "2",  # else each thread's heap keeps what it once needed
}
c.Spawner.default_url = "/lab"
c.Spawner.mem_limit = (
    "1G"  # twice what all of lesson 11 needs; a loop that appends for ever ends its own student only
)
c.Spawner.cpu_limit = 2  # one student's endless loops leave the other processors free
c.Spawner.start_timeout = 120  # a whole class logs in within a minute
c.Spawner.http_timeout = 120
# More than a class: who comes when so many servers are starting gets an error page and has to try again.
c.JupyterHub.concurrent_spawn_limit = 50
c.SystemdSpawner.isolate_tmp = True  # no student sees another's temporary files
c.SystemdSpawner.isolate_devices = True
c.SystemdSpawner.disable_user_sudo = True
c.SystemdSpawner.unit_extra_properties = {
    "ProtectProc": "invisible",  # nor their processes and command lines
    "TasksMax": "128",  # a fork bomb ends here
}

# --- idle servers give their memory back ---

c.JupyterHub.load_roles = [
    {
        "name": "idle-culler",
        "scopes": ["list:users", "read:users:activity", "read:servers", "delete:servers"],
        "services": ["idle-culler"],
    }
]
c.JupyterHub.services = [
    {
        "name": "idle-culler",
        # An hour without a message; a cell that still runs counts as activity. Notebooks stay in the home folder.
        "command": [sys.executable, "-m", "jupyterhub_idle_culler", "--timeout=3600", "--cull-every=300"],
    }
]

# --- the hub itself ---

c.JupyterHub.bind_url = (
    "http://127.0.0.1:8000"  # only for the web server beside it, which has the certificate
)
c.ConfigurableHTTPProxy.command = [str(HUB / "node_modules" / ".bin" / "configurable-http-proxy")]
# The working folder is the hub's alone (nao-hub.service): the database, the cookies' secret.
c.JupyterHub.db_url = "sqlite:///jupyterhub.sqlite"
c.JupyterHub.cookie_secret_file = "jupyterhub_cookie_secret"
# With a DNS name and a certificate for *.hub.example.edu, each student has an origin of their own: then no script in
# one student's page can use another's session. docs/what_is_protected.md
# c.JupyterHub.subdomain_host = "https://hub.example.edu"
