"""The instructor's secret is made once, for this user's eyes only, and one that cannot be used is refused."""

import stat
import sys

import pytest

from nao_course.instructor.autograding import secret as module
from nao_course.instructor.autograding.secret import SecretError, keyed, load_secret

posix = pytest.mark.skipif(sys.platform == "win32", reason="modes of POSIX")


@pytest.fixture
def no_secret(tmp_path, monkeypatch):
    monkeypatch.delenv("NAO_COURSE_SECRET", raising=False)
    monkeypatch.setattr(module.typer, "get_app_dir", lambda name: str(tmp_path / "config" / name))
    return tmp_path / "config" / "nao-course" / "secret"


@posix
def test_a_secret_is_made_once_for_this_users_eyes_only(no_secret):
    first = load_secret()
    assert len(first) >= 32
    assert load_secret() == first
    assert stat.S_IMODE(no_secret.stat().st_mode) == 0o600
    assert [each.name for each in no_secret.parent.iterdir()] == ["secret"]
    assert keyed(b"s", "a", "b") != keyed(b"s", "ab") != keyed(b"t", "ab")
    assert keyed(b"s", "a") == keyed(b"s", "a")


@posix
def test_a_secret_that_is_none_is_refused_and_one_that_is_named_is_not_made(no_secret, tmp_path, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setenv("NAO_COURSE_SECRET", str(tmp_path / "mine"))
        with pytest.raises(SecretError, match="mine, which does not exist. Copy your secret there.*unset"):
            load_secret()
    assert not (tmp_path / "mine").exists() and not no_secret.exists()
    no_secret.parent.mkdir(parents=True)
    for content, mode, reason in ((b"x" * 40, 0o644, "chmod 600"), (b"short", 0o600, "5 bytes")):
        no_secret.write_bytes(content)
        no_secret.chmod(mode)
        with pytest.raises(SecretError, match=reason):
            load_secret()
