"""What a backup has is given back as it was, and nothing that exists is overwritten."""

import os
import pwd
import sqlite3
import stat
import subprocess
from contextlib import closing

import pytest

ADA = "ada@uni.example"
needs_root = pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root makes accounts")


@pytest.fixture
def backup(hub_program):
    return hub_program("backup")


@pytest.fixture
def server(backup, tmp_path):
    """A server with Ada's notebooks, and a function that runs the program on it."""
    homes, hub, backups = (tmp_path / each for each in ("homes", "hub", "backups"))
    ada = homes / backup.account_of(ADA)

    def run(*words, homes=homes, hub=hub):
        return backup.main(["--homes", str(homes), "--hub", str(hub), *map(str, words)])

    def newest():
        assert run("make", backups) == 0
        return max(backups.iterdir())

    run.newest, run.backups, run.homes, run.hub, run.ada = newest, backups, homes, hub, ada
    for file, text in {
        "notebooks/01_hsl_filtering.ipynb": "my work",
        ".cache/pip": "large",
        ".local/share/Trash/files/old": "large",
        ".ssh/config": "mine",
    }.items():
        (ada / file).parent.mkdir(parents=True, exist_ok=True)
        (ada / file).write_text(text)
    (homes / "teacher").mkdir()
    (homes / "nao-eve-0123456789").symlink_to(homes / "teacher")
    hub.mkdir()
    (hub / "monitoring.token").write_text("secret")
    with closing(sqlite3.connect(hub / backup.DATABASE)) as database:
        database.execute("create table users (name)")
        database.execute("insert into users values ('ada')")
        database.commit()
    return run


def users(hub):
    with closing(sqlite3.connect(hub / "jupyterhub.sqlite")) as database:
        return database.execute("select name from users").fetchall()


def test_only_root_reads_a_backup_and_it_has_each_students_folder_and_the_hubs(server):
    made = server.newest()
    assert stat.S_IMODE(made.stat().st_mode) == 0o700
    assert {str(each.relative_to(made)) for each in made.rglob("*") if each.is_file()} == {
        f"homes/{server.ada.name}.tgz",
        "hub/monitoring.token",
        "hub/jupyterhub.sqlite",
    }
    assert users(made / "hub") == [("ada",)]


def test_the_database_is_whole_although_the_hub_is_writing(server):
    with closing(sqlite3.connect(server.hub / "jupyterhub.sqlite")) as database:
        database.execute("pragma journal_mode=wal")
        database.execute("insert into users values ('ben')")
        database.commit()  # it is in the file -wal only, which the copy of a file would not have
        database.execute("insert into users values ('not yet')")
        assert users(server.newest() / "hub") == [("ada",), ("ben",)]


def test_the_newest_backups_are_kept(server, backup, monkeypatch):
    server.backups.mkdir()
    for day in range(10, 20):
        (server.backups / f"2020-01-{day}T033000Z").mkdir()
    assert server("make", server.backups, "--keep", "3") == 0
    kept = sorted(each.name for each in server.backups.iterdir())
    assert kept[:2] == ["2020-01-18T033000Z", "2020-01-19T033000Z"] and len(kept) == 3


def test_a_student_gets_notebooks_back_beside_those_of_today(server, capsys):
    made = server.newest()
    notebook = server.ada / "notebooks" / "01_hsl_filtering.ipynb"
    notebook.write_text("later work")
    for who in (ADA, server.ada.name):
        assert server("give", made, who) == 0
    given = server.ada / "restored" / made.name / "notebooks" / "01_hsl_filtering.ipynb"
    assert (given.read_text(), notebook.read_text()) == ("my work", "later work")
    given.write_text("edited")
    assert server("give", made, ADA) == 0 and given.read_text() == "edited"
    assert server("give", made, "eve@uni.example") == 1 and "NOT DONE" in capsys.readouterr().err


@needs_root
def test_a_link_in_a_students_folder_leads_root_nowhere(server, tmp_path):
    """The files are written as the student, who cannot write where the link leads."""
    made = server.newest()
    target = tmp_path / "roots"
    target.mkdir(mode=0o700)
    (server.ada / "restored").symlink_to(target)
    os.chown(server.ada, 12345, 12345)
    assert server("give", made, ADA) == 1
    assert not list(target.iterdir())


@pytest.mark.slow
@needs_root
def test_accounts_that_are_missing_come_back_with_all_their_files(server, tmp_path, capsys):
    name = server.ada.name
    new = tmp_path / "new"
    new.mkdir()
    try:
        subprocess.run(["useradd", "--no-create-home", name], check=True)
        first = pwd.getpwnam(name).pw_uid
        subprocess.run(["chown", "-R", name, server.ada], check=True)
        server.ada.chmod(0o700)
        made = server.newest()
        subprocess.run(["userdel", name], check=True)
        subprocess.run(
            ["useradd", "--no-create-home", "--uid", str(first + 7), "nao-other-0123456789"], check=True
        )
        assert server("restore", made, homes=new, hub=tmp_path / "new hub") == 0
        home, owner = new / name, pwd.getpwnam(name)
        assert stat.S_IMODE(home.stat().st_mode) == 0o700
        notebook = home / "notebooks" / "01_hsl_filtering.ipynb"
        assert notebook.read_text() == "my work" and notebook.stat().st_uid == owner.pw_uid
        assert (home / ".ssh").is_dir() and not (home / ".cache").exists()
        assert users(tmp_path / "new hub") == [("ada",)]
        notebook.write_text("later work")
        capsys.readouterr()
        assert server("restore", made, homes=new, hub=tmp_path / "new hub") == 0
        assert notebook.read_text() == "later work" and "stays as it is" in capsys.readouterr().out
    finally:
        for each in (name, "nao-other-0123456789"):
            subprocess.run(["userdel", each], check=False, capture_output=True)
