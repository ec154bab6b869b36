"""A student's account, named after what the learning platform says of the student. Needs only Python."""

import hashlib
import re
import subprocess
import unicodedata

START = "nao-"  # of the name of every account that the hub creates


def system_name(claim: str) -> str:
    """Return the name of a student's account and home folder.

    No claim leads to an account that the system has already ("root"), and different claims have different names,
    because each name has a fixed beginning and ends with a hash of the claim. The names suit Linux and Kubernetes. The
    claim is what the platform calls the student, such as an e-mail address, whose case does not matter. The name has at
    most 27 lower-case letters, digits and hyphens.

    >>> system_name("Ada.Lovelace@uni.example")
    'nao-ada-lovelace-3c6d023791'
    """
    claim = unicodedata.normalize("NFC", claim.strip().lower())
    letters = unicodedata.normalize("NFKD", claim.partition("@")[0]).encode("ascii", "ignore").decode()
    start = re.sub(r"[^a-z0-9]+", "-", letters)[:12].strip("-") or "student"
    return f"{START}{start}-{hashlib.sha256(claim.encode()).hexdigest()[:10]}"


def account_of(word: str) -> str:
    """Return the account of a student who is given by the account's name or by an e-mail address.

    >>> account_of("nao-ada-lovelace-3c6d023791") == account_of("Ada.Lovelace@uni.example")
    True
    """
    is_account = re.fullmatch(rf"{START}[a-z0-9-]+-[0-9a-f]{{10}}", word)
    return word if is_account else system_name(word)


def create_account(name: str, *options: str) -> None:
    """Create a student's account: it has no password, and a home folder that nobody else can read."""
    shell = ["--shell", "/bin/bash"]
    subprocess.run(
        ["useradd", "--key", "HOME_MODE=0700", *shell, *(options or ["--create-home"]), name], check=True
    )
