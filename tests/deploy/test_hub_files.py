"""The files of deploy/hub say what the docs promise, and JupyterHub knows every option that they set."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys

import pytest
import yaml
from traitlets.config import Config, PyFileConfigLoader

from tests.paths import PROJECT

HUB = PROJECT / "deploy" / "hub"
VALUES = yaml.safe_load((HUB / "values.yaml").read_text())
PAGE = (PROJECT / "docs" / "setup.md").read_text()


@pytest.fixture
def config(monkeypatch) -> Config:
    monkeypatch.syspath_prepend(str(HUB))
    loaded = PyFileConfigLoader("jupyterhub_config.py", path=str(HUB)).load_config()
    yield loaded
    sys.modules.pop("names", None)


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


def test_an_account_is_made_once_with_a_home_that_nobody_else_can_read(config, monkeypatch):
    made = []
    monkeypatch.setattr(subprocess, "run", lambda command, check: made.append(command))
    spawner = type("Spawner", (), {"user": type("User", (), {"name": "nao-ada-0123456789"})})
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
    (culler,) = config.JupyterHub.services
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
    assert installed[1].endswith('"$folder/new/nao-course"')
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
