"""The committed bundles of the widgets' scripts match the sources in web/, and load nothing from elsewhere."""

import hashlib
import re
from pathlib import Path

import pytest

from tests.paths import PROJECT

WEB = PROJECT / "web"
BUNDLES = {"world": PROJECT / "nao_course" / "widgets" / "world" / "static" / "world.js"}


def fingerprint(web: Path, folder: str) -> str:
    """Return the hash that web/bundle.mjs writes into the first line of a bundle."""
    names = [f"{folder}/{path.name}" for path in sorted((web / folder).iterdir())]
    digest = hashlib.sha256()
    for name in [*names, "bundle.mjs", "package-lock.json"]:
        text = (web / name).read_bytes().decode("utf-8").replace("\r\n", "\n")
        digest.update(f"{name}\n{text}\n".encode())
    return digest.hexdigest()


@pytest.mark.parametrize("folder", BUNDLES)
def test_a_bundle_is_made_from_the_present_sources(folder):
    first = BUNDLES[folder].read_text(encoding="utf-8").partition("\n")[0]
    assert first.endswith(f"sources {fingerprint(WEB, folder)}"), "run `make bundles`"


@pytest.mark.parametrize("folder", BUNDLES)
def test_a_bundle_loads_nothing_and_its_licence_lies_beside_it(folder):
    text = BUNDLES[folder].read_text(encoding="utf-8")
    assert not re.search(r"\bimport\s*[\"'({*]|\bimport\s+\w+\s+from\b|\brequire\(", text)
    assert not re.search(r"[\"'`]https?://(?!www\.w3\.org)", text)
    licences = list(BUNDLES[folder].parent.glob("LICENSE-*.txt"))
    assert [path.name for path in licences] == ["LICENSE-three.txt"]
    assert "MIT" in licences[0].read_text(encoding="utf-8")


def test_the_lock_of_the_bundler_has_hashes_and_no_address():
    text = (WEB / "package-lock.json").read_text(encoding="utf-8")
    assert text.count('"integrity": "sha512-') > 20
    assert "://" not in text
