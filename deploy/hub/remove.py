"""Remove students' accounts: from the hub, with server, home folder and backups.

sudo python3 remove.py WHO ... [--backups BACKUPS] --yes
sudo python3 remove.py --all [--backups BACKUPS] --yes       at the end of a term

Without --yes it only lists what would be removed. The hub must be running. It needs any Python.
"""

import argparse
import pwd
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

from names import START, account_of


def main(arguments: list[str] | None = None) -> int:
    """Remove the accounts that the command line names; return the exit status."""
    parser = argparse.ArgumentParser(description="Remove students' accounts with all that belongs to them.")
    parser.add_argument("students", nargs="*", metavar="WHO", help="E-mail address or account.")
    parser.add_argument("--all", action="store_true", help="All accounts that the hub has created.")
    parser.add_argument(
        "--backups", type=Path, help="Folder of all backups, from which they are removed as well."
    )
    parser.add_argument("--yes", action="store_true", help="Remove them.")
    parser.add_argument("--api", default="http://127.0.0.1:8000/hub/api", help="Address of the hub's API.")
    parser.add_argument("--hub", type=Path, default=Path("/var/lib/nao-hub"), help="The hub's own folder.")
    chosen = parser.parse_args(arguments)
    if bool(chosen.students) == chosen.all:
        parser.error("name students, or --all")
    accounts = sorted(set(map(account_of, chosen.students)))
    if chosen.all:
        accounts = sorted(each.pw_name for each in pwd.getpwall() if each.pw_name.startswith(START))
    failed = False
    for account in accounts:
        archives = sorted(chosen.backups.glob(f"*/homes/{account}.tgz")) if chosen.backups else []
        if not chosen.yes:
            print(f"{account}: would be removed, with {len(archives)} backups")
            continue
        try:
            remove_from_hub(account, chosen.api, (chosen.hub / "removal.token").read_text())
            remove_account(account)
            for archive in archives:
                archive.unlink()
            print(f"{account}: removed, with {len(archives)} backups")
        except (OSError, subprocess.CalledProcessError) as error:
            print(f"{account}: NOT REMOVED: {error}", file=sys.stderr)
            failed = True
    if chosen.yes:
        print("Collected folders and grades still name them: nao-course students GRADES --forget STUDENT")
    return failed


def remove_from_hub(account: str, api: str, token: str) -> None:
    """Stop the student's server and remove the student from the hub's database."""
    request = urllib.request.Request(
        f"{api}/users/{account}", method="DELETE", headers={"Authorization": f"token {token}"}
    )
    try:
        with urllib.request.urlopen(request, timeout=60):
            pass
    except urllib.error.HTTPError as error:
        if error.code != 404:  # a student whom the hub does not know, as after a restored backup
            raise


def remove_account(account: str) -> None:
    """Remove an account of the system with its home folder, if there is one."""
    try:
        pwd.getpwnam(account)
    except KeyError:
        return
    subprocess.run(["userdel", "--remove", account], check=True, capture_output=True, text=True)


if __name__ == "__main__":
    sys.exit(main())
