"""An account is removed with all that belongs to it, and only when it is said twice."""

import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from types import SimpleNamespace

import pytest

ADA, BEN = "ada@uni.example", "ben@uni.example"


@pytest.fixture
def remove(hub_program):
    return hub_program("remove")


@pytest.fixture
def hub(remove, monkeypatch, tmp_path):
    """A stand-in of the hub's API, accounts of Ada, Ben and root, and a function that runs the program."""
    asked, deleted, answer = [], [], {"status": 204}

    class Api(BaseHTTPRequestHandler):
        def do_DELETE(self):
            asked.append((self.path, self.headers["Authorization"]))
            self.send_response(answer["status"])
            self.end_headers()

        def log_message(self, *words):
            pass

    accounts = {name: SimpleNamespace(pw_name=name) for name in ("root", *map(remove.account_of, (ADA, BEN)))}
    monkeypatch.setattr(remove.pwd, "getpwall", lambda: list(accounts.values()))
    monkeypatch.setattr(remove.pwd, "getpwnam", accounts.__getitem__)
    monkeypatch.setattr(remove.subprocess, "run", lambda command, **options: deleted.append(command))
    (tmp_path / "removal.token").write_text("secret")
    for day in "12":
        for account in accounts:
            file = tmp_path / "backups" / day / "homes" / f"{account}.tgz"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("")
    with HTTPServer(("127.0.0.1", 0), Api) as server:
        threading.Thread(target=server.serve_forever, args=[0.01], daemon=True).start()

        def run(*words):
            api = f"http://127.0.0.1:{server.server_port}/hub/api"
            return remove.main(
                [*words, "--backups", str(tmp_path / "backups"), "--api", api, "--hub", str(tmp_path)]
            )

        run.asked, run.deleted, run.answer = asked, deleted, answer
        run.backups = lambda: sorted(each.name for each in (tmp_path / "backups").rglob("*.tgz"))
        yield run
        server.shutdown()


def test_a_student_is_removed_from_hub_system_and_backups(hub, remove):
    account, before = remove.account_of(ADA), hub.backups()
    assert hub(ADA) == 0 and not hub.asked and not hub.deleted and hub.backups() == before
    assert hub(ADA, "--yes") == 0
    assert hub.asked == [(f"/hub/api/users/{account}", "token secret")]
    assert hub.deleted == [["userdel", "--remove", account]]
    assert hub.backups() == [each for each in before if account not in each]


def test_all_are_the_accounts_that_the_hub_has_created(hub, remove):
    assert hub("--all", "--yes") == 0
    assert sorted(each[-1] for each in hub.deleted) == sorted(map(remove.account_of, (ADA, BEN)))
    assert set(hub.backups()) == {"root.tgz"}
    for words in ([], ["--all", ADA]):
        with pytest.raises(SystemExit):
            hub(*words)


def test_an_account_of_the_system_is_never_meant(hub):
    assert hub("root", "--yes") == 0
    assert hub.asked[0][0].startswith("/hub/api/users/nao-root-") and not hub.deleted


def test_while_the_hub_does_not_let_a_student_go_nothing_of_theirs_is_removed(hub, capsys):
    before = hub.backups()
    hub.answer["status"] = 403
    assert hub(ADA, "--yes") == 1 and "NOT REMOVED" in capsys.readouterr().err
    assert not hub.deleted and hub.backups() == before
    hub.answer["status"] = 404  # the hub does not know the student any more
    assert hub(ADA, "--yes") == 0 and len(hub.deleted) == 1
