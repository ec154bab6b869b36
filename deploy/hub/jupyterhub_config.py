"""JupyterHub for a class on one server: docs/setup.md installs it, and docs/run_a_hub.md runs it for a term.

Each option says why it is here.
"""

import os
import pwd
import secrets
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

COURSE = Path(os.environ.get("NAO_COURSE_FOLDER", "/opt/nao-course"))  # where install.sh put everything
HUB = Path(__file__).resolve().parent
sys.path.insert(0, str(HUB))
from names import create_account, system_name  # noqa: E402 - beside this file

c = get_config()  # noqa: F821 - JupyterHub puts it there

# --- your university: change these, with what the learning platform shows after the registration ---

c.JupyterHub.authenticator_class = "ltiauthenticator.lti13.auth.LTI13Authenticator"
c.LTI13Authenticator.issuer = "https://moodle.example.edu"
c.LTI13Authenticator.client_id = {"the client ID that Moodle shows"}
c.LTI13Authenticator.authorize_url = "https://moodle.example.edu/mod/lti/auth.php"
c.LTI13Authenticator.jwks_endpoint = "https://moodle.example.edu/mod/lti/certs.php"
# E-mail addresses of those who may do everything on the hub, and of those who only help the students
c.Authenticator.admin_users = set()
ASSISTANTS = set()
ASSISTANTS_MAY_OPEN = False  # students' servers, where an assistant can do all that the student can
QUOTA = None  # of a student's home folder, such as "2G": docs/run_a_hub.md says what it needs

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
    """Create the student's account if there is none, and limit the size of its home folder."""
    try:
        pwd.getpwnam(spawner.user.name)
    except KeyError:
        create_account(spawner.user.name)
    if QUOTA:  # at each start, so that a new limit holds for everybody
        subprocess.run(["setquota", "-u", spawner.user.name, QUOTA, QUOTA, "0", "0", "/home"], check=True)


c.Authenticator.post_auth_hook = name_account
c.Spawner.pre_spawn_hook = make_account

# --- a student's server ---

# One unit of systemd for each student: it has its own limits, and survives a restart of the hub.
c.JupyterHub.spawner_class = "systemdspawner.SystemdSpawner"
c.JupyterHub.cleanup_servers = False
# Brings newer lessons into the student's folder, and then becomes the student's JupyterLab.
# The link `current` is followed at the start of a server, and what runs stays with its release: install.sh
c.Spawner.cmd = [str(COURSE / "current" / ".venv" / "bin" / "nao-course"), "lab"]
c.Spawner.environment = {
    "NAO_COURSE_RELEASE": str(COURSE / "current" / "release"),
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
    "LimitFSIZE": "1G",  # and so does a loop that writes into one file for ever
    # A lesson needs no network, and without one nobody mines, sends mail or asks a language model from here.
    "IPAddressDeny": "any",
    "IPAddressAllow": "localhost",  # the hub and its proxy
}

# --- who may do what besides the students ---


def token(service):
    """Return the token of a service, which is made at the hub's first start and kept in the hub's own folder."""
    file = Path(f"{service}.token").resolve()
    with suppress(FileExistsError):
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "w") as made:
            made.write(secrets.token_hex(32))
    return file.read_text()


c.JupyterHub.load_roles = [
    {
        "name": "idle-culler",
        "scopes": ["list:users", "read:users:activity", "read:servers", "delete:servers"],
        "services": ["idle-culler"],
    },
    {"name": "monitoring", "scopes": ["read:metrics"], "services": ["monitoring"]},
    {"name": "removal", "scopes": ["delete:users"], "services": ["removal"]},
    {
        "name": "assistants",  # they see on /hub/admin who works, and start and stop servers
        "scopes": ["admin-ui", "list:users", "read:users:activity", "read:servers", "servers"]
        + ["access:servers"] * ASSISTANTS_MAY_OPEN,
        # Exactly these: JupyterHub takes the role from all others at its start.
        "users": sorted(map(system_name, ASSISTANTS)),
    },
]
c.JupyterHub.services = [
    {"name": "monitoring", "api_token": token("monitoring")},  # for Prometheus: prometheus.yml
    {"name": "removal", "api_token": token("removal")},  # for remove.py
    # Idle servers give their memory back.
    {
        "name": "idle-culler",
        # An hour without a message; a cell that still runs counts as activity. Notebooks stay in the home folder.
        "command": [sys.executable, "-m", "jupyterhub_idle_culler", "--timeout=3600", "--cull-every=300"],
    },
]

# --- the hub itself ---

c.JupyterHub.bind_url = (
    "http://127.0.0.1:8000"  # only for the web server beside it, which has the certificate
)
c.ConfigurableHTTPProxy.command = [str(HUB / "node_modules" / ".bin" / "configurable-http-proxy")]
# The working folder is the hub's alone (nao-hub.service): the database, the cookies' secret, the services' tokens.
c.JupyterHub.db_url = "sqlite:///jupyterhub.sqlite"
c.JupyterHub.cookie_secret_file = "jupyterhub_cookie_secret"
# With a DNS name and a certificate for *.hub.example.edu, each student has an origin of their own: then no script in
# one student's page can use another's session. docs/what_is_protected.md
# c.JupyterHub.subdomain_host = "https://hub.example.edu"
