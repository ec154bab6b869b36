"""Back up the students' home folders and the hub's own folder, and bring them back.

sudo python3 backup.py make BACKUPS              a new backup; the newest 14 are kept
sudo python3 backup.py restore BACKUP            all accounts that are missing, on a new server for example
sudo python3 backup.py give BACKUP WHO           one student's notebooks, into a folder of their own

Nothing that exists is overwritten. It needs any Python, and `tar`.
"""

import argparse
import os
import pwd
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from names import START, account_of, create_account

DATABASE = "jupyterhub.sqlite"
NOT_KEPT = (".cache", ".local/share/Trash", ".local/share/jupyter/runtime")  # in each home folder
GIVEN = "restored"  # the folder in which a student finds what was given back


def main(arguments: list[str] | None = None) -> int:
    """Do what the command line says; return the exit status."""
    parser = argparse.ArgumentParser(
        description="Back up the students' folders and the hub's, and bring them back."
    )
    parser.add_argument("--homes", type=Path, default=Path("/home"), help="Folder of the home folders.")
    parser.add_argument("--hub", type=Path, default=Path("/var/lib/nao-hub"), help="The hub's own folder.")
    commands = parser.add_subparsers(dest="command", required=True)
    made = commands.add_parser("make", help="Make a backup.")
    made.add_argument("backups", type=Path, metavar="BACKUPS", help="Folder of all backups.")
    made.add_argument("--keep", type=int, default=14, help="How many backups are kept.")
    restored = commands.add_parser("restore", help="Bring back all that is missing.")
    restored.add_argument("backup", type=Path, metavar="BACKUP", help="Folder of one backup.")
    given = commands.add_parser("give", help="Give a student the notebooks of a backup.")
    given.add_argument("backup", type=Path, metavar="BACKUP", help="Folder of one backup.")
    given.add_argument("student", metavar="WHO", help="E-mail address or account.")
    chosen = parser.parse_args(arguments)
    os.umask(0o077)  # a backup holds all that students have written
    try:
        match chosen.command:
            case "make":
                print(make(chosen.homes, chosen.hub, chosen.backups, max(chosen.keep, 1)))
            case "restore":
                print("\n".join(restore(chosen.backup, chosen.homes, chosen.hub)))
            case "give":
                print(give(chosen.backup, chosen.homes, account_of(chosen.student)))
    except (OSError, KeyError, sqlite3.Error, subprocess.CalledProcessError) as error:
        print(f"NOT DONE: {error}", file=sys.stderr)
        return 1
    return 0


def make(homes: Path, hub: Path, backups: Path, keep: int) -> str:
    """Write a backup of each home folder and the hub's folder, and remove the oldest backups; return what was done."""
    name = datetime.now(UTC).strftime("%Y-%m-%dT%H%M%SZ")
    part = backups / f".{name}.part"
    (part / "homes").mkdir(parents=True)
    (part / "hub").mkdir()
    accounts = sorted(
        each.name for each in homes.iterdir() if each.name.startswith(START) and not each.is_symlink()
    )
    for account in accounts:
        excluded = [f"--exclude={account}/{each}" for each in NOT_KEPT]
        command = [
            "tar",
            "--create",
            "--gzip",
            "--one-file-system",
            *excluded,
            "--file",
            part / "homes" / f"{account}.tgz",
        ]
        done = subprocess.run([*command, "--directory", homes, account], check=False)
        if done.returncode > 1:  # 1: a student wrote into a file while it was read
            done.check_returncode()
    for file in sorted(
        each for each in hub.iterdir() if each.is_file() and not each.name.startswith(DATABASE)
    ):
        shutil.copy2(file, part / "hub")
    if (hub / DATABASE).exists():
        with (
            closing(sqlite3.connect(hub / DATABASE)) as source,
            closing(sqlite3.connect(part / "hub" / DATABASE)) as copy,
        ):
            source.backup(copy)  # whole, also while the hub writes
    part.rename(backups / name)
    old = sorted(each for each in backups.iterdir() if not each.name.startswith("."))[:-keep]
    for each in old:
        shutil.rmtree(each)
    return f"{backups / name}: {len(accounts)} students; {len(old)} older backups removed"


def restore(backup: Path, homes: Path, hub: Path) -> list[str]:
    """Bring back the accounts and home folders that are missing, and the hub's files; return a line for each."""
    said = []
    for archive in sorted((backup / "homes").iterdir()):
        account = archive.name.removesuffix(".tgz")
        if os.path.lexists(homes / account):
            said.append(f"{account}: has a home folder, which stays as it is")
            continue
        try:
            pwd.getpwnam(account)
        except KeyError:
            create_account(account, "--no-create-home")
        # Owners are stored by name, so that accounts may have other numbers than before.
        subprocess.run(["tar", "--extract", "--gzip", "--file", archive, "--directory", homes], check=True)
        said.append(f"{account}: restored")
    hub.mkdir(mode=0o700, parents=True, exist_ok=True)
    for file in sorted((backup / "hub").iterdir()):
        if (hub / file.name).exists():
            said.append(f"{hub / file.name}: exists, and stays as it is")
        else:
            shutil.copy2(file, hub)
    return said


def give(backup: Path, homes: Path, account: str) -> str:
    """Unpack a student's notebooks into a folder of their own; return where they are."""
    archive = backup / "homes" / f"{account}.tgz"
    home = homes / account
    owner = home.lstat()
    target = f"{account}/{GIVEN}/{backup.resolve().name}"
    # As the student: whatever links the student has made there, they lead to nothing that is not the student's.
    as_student = (
        {"user": owner.st_uid, "group": owner.st_gid, "extra_groups": []} if os.geteuid() == 0 else {}
    )
    unpack = ["tar", "--extract", "--gzip", "--skip-old-files", "--strip-components=1"]
    unpack += ["--directory", f"{GIVEN}/{backup.resolve().name}"]
    with archive.open("rb") as content:
        subprocess.run(["mkdir", "-p", unpack[-1]], cwd=home, check=True, **as_student)
        subprocess.run([*unpack, f"{account}/notebooks"], cwd=home, stdin=content, check=True, **as_student)
    return f"{homes / target}/notebooks"


if __name__ == "__main__":
    sys.exit(main())
