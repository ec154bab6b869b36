"""The files of deploy/hub say what the docs promise, and JupyterHub knows every option that they set."""

import importlib
import json
import re
import shlex
import shutil
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest
import yaml
from traitlets.config import Config, PyFileConfigLoader

from tests.paths import PROJECT

HUB = PROJECT / "deploy" / "hub"
VALUES = yaml.safe_load((HUB / "values.yaml").read_text())
PAGE = (PROJECT / "docs" / "setup.md").read_text()
TERM = (PROJECT / "docs" / "run_a_hub.md").read_text()
ADA = "ada@uni.example"


@pytest.fixture
def load(monkeypatch, tmp_path):
    """Load a configuration of this folder, some of its lines changed, in the hub's own folder."""
    monkeypatch.syspath_prepend(str(HUB))
    monkeypatch.chdir(tmp_path)

    def load(name="jupyterhub_config.py", **changed) -> Config:
        for file in (*HUB.glob("*.py"),):
            source = file.read_text()
            for variable, value in changed.items():
                source = re.sub(rf"^{variable} = .*", f"{variable} = {value}", source, flags=re.MULTILINE)
            (tmp_path / file.name).write_text(source)
        return PyFileConfigLoader(name, path=str(tmp_path)).load_config()

    yield load
    sys.modules.pop("names", None)


@pytest.fixture
def config(load) -> Config:
    return load()


def test_jupyterhub_knows_every_option_of_the_configuration(config):
    pytest.importorskip("jupyterhub", reason="JupyterHub is not installed: make .venv/hub.stamp")
    classes = {
        "JupyterHub": "jupyterhub.app",
        "Authenticator": "jupyterhub.auth",
        "Spawner": "jupyterhub.spawner",
        "ConfigurableHTTPProxy": "jupyterhub.proxy",
        "LTI13Authenticator": "ltiauthenticator.lti13.auth",
        "SystemdSpawner": "systemdspawner",
    }
    assert set(config) == set(classes)
    for name, module in classes.items():
        configured = getattr(importlib.import_module(module), name)
        known = configured(config=config) if name == "JupyterHub" else None
        traits = configured.class_traits(config=True)
        for option, value in config[name].items():
            assert option in traits, f"{name}.{option}"
            if known is not None:
                assert getattr(known, option) == value or option.endswith("_class")


def test_a_students_name_on_the_hub_is_never_one_of_the_system(config):
    def named(name):
        return config.Authenticator.post_auth_hook(None, None, {"name": name, "admin": False})

    renamed = named("root")
    assert re.fullmatch(r"nao-root-[0-9a-f]{10}", renamed["name"]) and renamed["admin"] is False
    assert named("jos\u00e9") == named("jose\u0301"), "a name that is typed in two ways is one account"


def test_no_student_sees_files_devices_or_processes_of_another_and_a_class_is_not_turned_away(config):
    # Beyond this number JupyterHub answers with error 429: the load test's eleventh student met a limit of ten.
    assert config.JupyterHub.concurrent_spawn_limit >= 30
    assert VALUES["hub"]["concurrentSpawnLimit"] == config.JupyterHub.concurrent_spawn_limit
    spawner = config.SystemdSpawner
    assert spawner.isolate_tmp and spawner.isolate_devices and spawner.disable_user_sudo
    assert spawner.unit_extra_properties["ProtectProc"] == "invisible"


def spawner_of(name):
    return SimpleNamespace(user=SimpleNamespace(name=name), unit_extra_properties={"TasksMax": "128"})


def test_an_account_is_made_once_with_a_home_that_nobody_else_can_read(config, monkeypatch):
    made = []
    monkeypatch.setattr(subprocess, "run", lambda command, check: made.append(command))
    spawner = spawner_of("nao-ada-0123456789")
    config.Spawner.pre_spawn_hook(spawner)
    (command,) = made
    assert command[0] == "useradd" and command[-1] == "nao-ada-0123456789" and "HOME_MODE=0700" in command
    spawner.user.name = "root"  # it exists
    config.Spawner.pre_spawn_hook(spawner)
    assert len(made) == 1


def test_both_hubs_give_a_student_the_same(config):
    """One server and Kubernetes: the same limits, command, sign-on and time until an idle server stops."""
    student = VALUES["singleuser"]
    assert student["memory"]["limit"] == config.Spawner.mem_limit
    assert student["cpu"]["limit"] == config.Spawner.cpu_limit
    assert student["cmd"] == ["nao-course", *config.Spawner.cmd[1:]]
    assert student["defaultUrl"] == config.Spawner.default_url
    culler = next(each for each in config.JupyterHub.services if each["name"] == "idle-culler")
    assert VALUES["cull"]["enabled"]
    assert f"--timeout={VALUES['cull']['timeout']}" in culler["command"]
    assert f"--cull-every={VALUES['cull']['every']}" in culler["command"]
    sign_on = VALUES["hub"]["config"]["LTI13Authenticator"]
    assert {**sign_on, "client_id": set(sign_on["client_id"])} == dict(config.LTI13Authenticator)
    assert VALUES["hub"]["config"]["Authenticator"]["allow_all"] is config.Authenticator.allow_all is True
    assert (
        VALUES["hub"]["config"]["JupyterHub"]["authenticator_class"] == config.JupyterHub.authenticator_class
    )


def test_kubernetes_names_accounts_as_one_server_does(config):
    on_kubernetes = Config()
    exec(VALUES["hub"]["extraConfig"]["accounts"], {"c": on_kubernetes})
    hooks = (each.Authenticator.post_auth_hook for each in (config, on_kubernetes))
    one, other = (hook(None, None, {"name": "ada@uni.example"}) for hook in hooks)
    assert one == other and VALUES["singleuser"]["storage"]["static"]["subPath"] == "homes/{username}"


def test_the_image_is_made_of_nothing_but_the_release():
    """The release's own tests prove that it has no solutions; here, that nothing else gets into the image."""
    recipe = (HUB / "Dockerfile").read_text()
    copied = re.findall(r"^(?:COPY|ADD)\s+(.*)$", recipe, re.MULTILINE)
    assert copied == ["install.sh requirements.lock nao-course-*.zip /tmp/course/"]
    install = (HUB / "install.sh").read_text()
    installed = re.findall(r"pip install .*", install)
    assert len(installed) == 2
    assert installed[0].endswith('--require-hashes -r "$here/requirements.lock"')
    assert installed[1].endswith('"$place/new/nao-course"')
    locked = (HUB / "requirements.lock").read_text()
    assert not re.search(r"^(nbgrader|jupytext|nao-course-instructor)\b", locked, re.MULTILINE)


def test_the_image_sets_what_one_server_sets(config):
    recipe = (HUB / "Dockerfile").read_text()
    told = dict(re.findall(r"(\w+)=(\S+)", " ".join(re.findall(r"^ENV (.*)$", recipe, re.MULTILINE))))
    assert {name: told.get(name) for name in config.Spawner.environment} == config.Spawner.environment


def test_the_service_starts_the_configuration_that_the_page_installs():
    (config_file,) = re.findall(r"--config (\S+)", (HUB / "nao-hub.service").read_text())
    assert config_file == "/opt/nao-course/hub/jupyterhub_config.py"
    for name in ("install.sh", "collect.py", "jupyterhub_config.py", "values.yaml", "Dockerfile", "names.py"):
        assert name in PAGE
    assert "/opt/nao-course/hub" in PAGE and "nao-hub.service" in PAGE
    written = {
        each.name
        for each in HUB.iterdir()
        if each.suffix in (".py", ".sh", ".yaml", ".yml", ".service", ".timer")
    }
    assert not {
        each
        for each in written
        if each not in PAGE + TERM.replace("nao-backup.*", "nao-backup.service nao-backup.timer")
    }


# --- for a term: docs/run_a_hub.md ---


def test_a_students_server_has_no_network_but_the_hubs_and_its_files_and_home_have_limits(load, monkeypatch):
    limits = load().SystemdSpawner.unit_extra_properties
    assert (limits["IPAddressDeny"], limits["IPAddressAllow"]) == ("any", "localhost")
    assert limits["LimitFSIZE"] == "1G"
    ran = []
    monkeypatch.setattr(subprocess, "run", lambda command, check: ran.append((command, check)))
    load().Spawner.pre_spawn_hook(spawner_of("root"))  # an account that exists
    assert not ran, "without a quota nothing is needed for one"
    load(QUOTA='"2G"').Spawner.pre_spawn_hook(spawner_of("root"))
    assert ran == [(["setquota", "-u", "root", "2G", "2G", "0", "0", "/home"], True)]


def test_assistants_see_who_works_and_start_and_stop_servers_and_open_none_unless_it_is_said(load):
    def role(**changed):
        return next(each for each in load(**changed).JupyterHub.load_roles if each["name"] == "assistants")

    assert role()["users"] == [], "an empty list takes the role from whoever had it"
    assistants = role(ASSISTANTS=f'{{"{ADA}"}}')
    assert assistants["users"] == ["nao-ada-" + assistants["users"][0][-10:]]
    assert set(assistants["scopes"]) == {
        *("admin-ui", "list:users", "read:users:activity", "read:servers", "servers")
    }
    assert "access:servers" in role(ASSISTANTS_MAY_OPEN="True")["scopes"]


def test_each_service_has_the_rights_that_it_needs_and_a_token_that_only_root_reads(load, tmp_path):
    first, again = load(), load()
    rights = {
        each["services"][0]: each["scopes"] for each in first.JupyterHub.load_roles if "services" in each
    }
    assert rights["monitoring"] == ["read:metrics"] and rights["removal"] == ["delete:users"]
    assert first.JupyterHub.services == again.JupyterHub.services, "a restart keeps the tokens"
    for name in ("monitoring", "removal"):
        file = tmp_path / f"{name}.token"
        (service,) = (each for each in first.JupyterHub.services if each["name"] == name)
        assert service["api_token"] == file.read_text() and len(file.read_text()) == 64
        assert file.stat().st_mode & 0o777 == 0o600


def test_jupyterhub_knows_every_scope_and_exports_every_number_that_an_alert_asks_for(config):
    pytest.importorskip("jupyterhub", reason="JupyterHub is not installed: make .venv/hub.stamp")
    from jupyterhub import metrics, scopes
    from prometheus_client import REGISTRY

    wanted = {scope for role in config.JupyterHub.load_roles for scope in role["scopes"]}
    assert wanted <= scopes.scope_definitions.keys()
    alerts = yaml.safe_load((HUB / "alerts.yml").read_text())["groups"][0]["rules"]
    asked = set(re.findall(r"jupyterhub_\w+", " ".join(each["expr"] for each in alerts)))
    assert metrics and len(asked) >= 2
    assert asked <= set(REGISTRY._names_to_collectors)
    scraped = {
        each["job_name"]: each
        for each in yaml.safe_load((HUB / "prometheus.yml").read_text())["scrape_configs"]
    }
    assert scraped["jupyterhub"]["metrics_path"] == "/hub/metrics"
    assert scraped["jupyterhub"]["static_configs"][0]["targets"][0] in config.JupyterHub.bind_url
    jobs = set(re.findall(r'job="(\w+)"', json.dumps(alerts).replace("\\", "")))
    assert jobs <= scraped.keys()


def test_an_exam_begins_and_ends_by_the_clock_and_some_students_have_more_time(load, monkeypatch):
    begin, end = (datetime.now(UTC) + timedelta(minutes=each) for each in (-60, 30))
    times = {"BEGIN": f'datetime.fromisoformat("{begin}")', "END": f'datetime.fromisoformat("{end}")'}
    made = []
    monkeypatch.setattr(subprocess, "run", lambda command, check: made.append(command[-1]))

    def admitted(claim, minutes=0):
        moved = {key: f"{value} + timedelta(minutes={minutes})" for key, value in times.items()}
        config = load("exam_config.py", **moved, EXTRA_MINUTES=f'{{"{ADA}": 20}}')
        spawner = spawner_of(config.Authenticator.post_auth_hook(None, None, {"name": claim})["name"])
        config.Spawner.pre_spawn_hook(spawner)
        assert spawner.unit_extra_properties["TasksMax"] == "128" and made[-1] == spawner.user.name
        return float(spawner.unit_extra_properties["RuntimeMaxSec"])

    assert admitted("ben@uni.example") == pytest.approx(30 * 60, abs=20)
    assert admitted(ADA) == admitted(ADA.upper()) == pytest.approx(50 * 60, abs=20)
    assert admitted(ADA, -40) == pytest.approx(10 * 60, abs=20)
    for claim, minutes in (("ben@uni.example", -40), ("ben@uni.example", 61), (ADA, 61), (ADA, -51)):
        with pytest.raises(Exception, match="The exam is from") as refused:
            admitted(claim, minutes)
        assert refused.value.jupyterhub_message == str(refused.value), "the student reads it"


def test_an_exams_hub_is_the_usual_one_in_all_else(load):
    usual, exam = load(), load("exam_config.py")
    usual.Spawner.pop("pre_spawn_hook"), exam.Spawner.pop("pre_spawn_hook")
    for config in (usual, exam):
        config.Authenticator.pop("post_auth_hook")
    assert usual == exam


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="this machine has no systemd")
def test_systemd_understands_every_unit(tmp_path):
    units = []
    for name in ("nao-hub.service", "nao-backup.service", "nao-backup.timer"):
        text = (HUB / name).read_text()
        units.append(tmp_path / name)
        units[-1].write_text(
            re.sub(r"^ExecStart=\S+", f"ExecStart={sys.executable}", text, flags=re.MULTILINE)
        )
    done = subprocess.run(["systemd-analyze", "verify", *units], capture_output=True, text=True)
    assert not [line for line in done.stderr.splitlines() if str(tmp_path) in line or "nao-" in line], (
        done.stderr
    )


def test_every_command_of_the_page_is_one_that_the_files_understand(load, monkeypatch, capsys):
    """Each line that starts one of our programs is read by its parser, which stops before anything is done."""
    load()
    said = [
        line
        for block in re.findall(r"^```sh\n(.*?)^```", TERM, re.MULTILINE | re.DOTALL)
        for line in block.splitlines()
    ]
    tried = set()
    for line in said:
        words = shlex.split(line, comments=True)
        for program in ("backup", "collect", "remove"):
            found = [place for place, word in enumerate(words) if word.endswith(f"hub/{program}.py")]
            if found:
                module = importlib.import_module(program)
                with monkeypatch.context() as patched:
                    patched.setattr(module.argparse.ArgumentParser, "parse_args", parsed_only)
                    with pytest.raises(ParsedError):
                        module.main(words[found[0] + 1 :])
                tried.add(program)
    for program in tried:
        sys.modules.pop(program)
    assert tried == {"backup", "collect", "remove"}


class ParsedError(Exception):
    """The arguments are understood."""


def parsed_only(parser, arguments):
    _, unknown = parser.parse_known_args(arguments)
    assert not unknown, unknown
    raise ParsedError
