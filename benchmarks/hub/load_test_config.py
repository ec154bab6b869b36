"""The hub's own configuration with two changes, because there is no learning platform here and perhaps no systemd."""

import os

c = get_config()  # noqa: F821 - JupyterHub puts it there
load_subconfig(os.environ["HUB_CONFIG"])  # noqa: F821
c.JupyterHub.authenticator_class = "dummy"
c.DummyAuthenticator.password = os.environ["HUB_PASSWORD"]
c.JupyterHub.spawner_class = "jupyterhub.spawner.LocalProcessSpawner"  # the same accounts, without limits
c.JupyterHub.cleanup_servers = True
c.JupyterHub.bind_url = f"http://127.0.0.1:{os.environ['HUB_PORT']}"
c.JupyterHub.hub_port = int(os.environ["HUB_PORT"]) + 1
c.ConfigurableHTTPProxy.api_url = f"http://127.0.0.1:{int(os.environ['HUB_PORT']) + 2}"
