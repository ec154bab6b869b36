"""A student's account, named after what the learning platform says of the student. Needs only Python."""

from __future__ import annotations

import hashlib
import re
import unicodedata


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
    return f"nao-{start}-{hashlib.sha256(claim.encode()).hexdigest()[:10]}"
