"""The few calls of the Linux kernel that Python has no name for; each raises OSError as Python's own do."""

import ctypes
import os
import struct
from collections.abc import Iterable

CLONE_NEWNS = 0x00020000
CLONE_NEWCGROUP = 0x02000000
CLONE_NEWUTS = 0x04000000
CLONE_NEWIPC = 0x08000000
CLONE_NEWUSER = 0x10000000
CLONE_NEWPID = 0x20000000
CLONE_NEWNET = 0x40000000
NEW_NAMESPACE = (
    CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC | CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET
)
MS_RDONLY, MS_NOSUID, MS_NODEV, MS_NOEXEC = 1, 2, 4, 8
MS_BIND, MS_REC, MS_PRIVATE = 0x1000, 0x4000, 0x40000
MNT_DETACH = 2
ATTR_RDONLY, ATTR_NOSUID, ATTR_NODEV = 1, 2, 4  # of mount_setattr
_SYS_MOUNT_SETATTR, _SYS_LANDLOCK = 442, (444, 445, 446)  # the same on all of Linux's processors but Alpha
_AT_FDCWD, _AT_RECURSIVE = -100, 0x8000
_PR_SET_PDEATHSIG, _PR_SET_DUMPABLE, _PR_SET_SECCOMP, _PR_SET_NO_NEW_PRIVS = 1, 4, 22, 38
_PR_SET_CHILD_SUBREAPER = 36
_CAPABILITIES_VERSION = 0x20080522

# Landlock: rights in files by the version that brought them (linux/landlock.h).
FS_EXECUTE, FS_WRITE_FILE, FS_READ_FILE, FS_READ_DIR = 1, 2, 4, 8
FS_READ = FS_READ_FILE | FS_READ_DIR
_FS_BY_ABI = {1: 13, 2: 14, 3: 15, 5: 16}  # how many rights there are since
_NET_TCP = 0b11  # bind and connect, since 4
_SCOPES = 0b11  # abstract Unix sockets and signals, since 6
# All that a rule for a file may hold
_OF_A_FILE = FS_EXECUTE | FS_WRITE_FILE | FS_READ_FILE | 1 << 14 | 1 << 15

_MADV_COLLAPSE = 25  # since Linux 6.1
_KEYCTL = {"x86_64": 250, "aarch64": 219}  # number of the system call
_JOIN_SESSION_KEYRING, _SET_PERMISSIONS = 1, 5

_libc = ctypes.CDLL(None, use_errno=True)


def _checked(result: int, what: str) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{what}: {os.strerror(number)}")
    return result


def _long(value: int) -> ctypes.c_ulong:
    return ctypes.c_ulong(value)


def unshare(flags: int) -> None:
    """Move this process into new namespaces."""
    _checked(_libc.unshare(ctypes.c_int(flags)), "unshare")


def setns(descriptor: int, kind: int) -> None:
    """Move this process (for PID namespaces: its later children) into a namespace."""
    _checked(_libc.setns(ctypes.c_int(descriptor), ctypes.c_int(kind)), "setns")


def mount(source: str, target: str, kind: str = "", flags: int = 0, options: str = "") -> None:
    """Mount a file system, or change a mount."""
    result = _libc.mount(
        source.encode(), target.encode(), kind.encode() or None, _long(flags), options.encode() or None
    )
    _checked(result, f"mount {kind or source} on {target}")


def mount_attributes(target: str, attributes: int) -> None:
    """Add attributes, such as ATTR_RDONLY, to a mount and all below it."""
    setting = struct.pack("<QQQQ", attributes, 0, 0, 0)
    result = _libc.syscall(
        ctypes.c_long(_SYS_MOUNT_SETATTR),
        ctypes.c_int(_AT_FDCWD),
        target.encode(),
        ctypes.c_uint(_AT_RECURSIVE),
        setting,
        ctypes.c_size_t(len(setting)),
    )
    _checked(result, f"mount_setattr {target}")


def pivot_root(new: str, old: str) -> None:
    """Make a mounted folder the root of this mount namespace."""
    _checked(_libc.pivot_root(new.encode(), old.encode()), "pivot_root")


def unmount(target: str) -> None:
    """Take a mount, and all below it, out of sight."""
    _checked(_libc.umount2(target.encode(), ctypes.c_int(MNT_DETACH)), f"umount {target}")


def _prctl(option: int, value: int, pointer: object = None) -> None:
    zero = _long(0)
    _checked(_libc.prctl(ctypes.c_int(option), _long(value), pointer or zero, zero, zero), f"prctl {option}")


def die_with_parent(signal: int) -> None:
    """Request a signal for this process when the thread that forked it ends."""
    _prctl(_PR_SET_PDEATHSIG, signal)


def adopt_orphans() -> None:
    """Make this process adopt every descendant whose own parent ends."""
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)


def no_new_privileges() -> None:
    """Let no program that this process starts gain privileges."""
    _prctl(_PR_SET_NO_NEW_PRIVS, 1)


def not_dumpable() -> None:
    """Make this process non-dumpable, so that other processes of its user cannot trace it."""
    _prctl(_PR_SET_DUMPABLE, 0)


def close_keyring() -> None:
    """Give this process an empty session keyring, which nobody may look into or add to."""
    if number := _KEYCTL.get(os.uname().machine):
        keyring = _checked(_libc.syscall(number, _JOIN_SESSION_KEYRING, None), "new keyring")
        _checked(_libc.syscall(number, _SET_PERMISSIONS, keyring, 0), "permissions of a keyring")


def drop_capabilities() -> None:
    """Give up every capability of this process."""
    header = struct.pack("<Ii", _CAPABILITIES_VERSION, 0)
    _checked(_libc.capset(header, bytes(24)), "capset")


def use_large_pages() -> None:
    """Move what this process has written to into large pages, where the kernel can do so."""
    with open("/proc/self/maps") as file:
        rows = [line.split() for line in file]
    for place, rights, _, _, inode, *name in rows:
        if rights == "rw-p" and inode == "0" and name != ["[stack]"]:
            start, end = (int(each, 16) for each in place.split("-"))
            _libc.madvise(ctypes.c_void_p(start), ctypes.c_size_t(end - start), _MADV_COLLAPSE)


def load_filter(program: bytes) -> None:
    """Install a seccomp program, as exported by libseccomp, that the kernel runs before each system call."""
    code = ctypes.create_string_buffer(program, len(program))
    filter_ = struct.pack("@HP", len(program) // 8, ctypes.addressof(code))
    _prctl(_PR_SET_SECCOMP, 2, ctypes.create_string_buffer(filter_, len(filter_)))


def landlock_version() -> int:
    """Return the version of Landlock that the kernel offers; raise an OSError if it offers none."""
    result = _libc.syscall(ctypes.c_long(_SYS_LANDLOCK[0]), None, ctypes.c_size_t(0), ctypes.c_uint(1))
    return _checked(result, "landlock")


def landlock(allowed: Iterable[tuple[str, int]], everything: Iterable[str] = ()) -> None:
    """Deny this process, for good, all files but some, TCP, and signals and abstract sockets to others.

    `allowed` are paths with rights to all beneath each, such as FS_READ; beneath the folders in `everything`, all is
    allowed.
    """
    abi = landlock_version()
    rights = (1 << max(many for since, many in _FS_BY_ABI.items() if since <= abi)) - 1
    net, scopes = (_NET_TCP if abi >= 4 else 0), (_SCOPES if abi >= 6 else 0)
    attributes = struct.pack("<QQQ", rights, net, scopes)[: 24 if abi >= 6 else 16 if abi >= 4 else 8]
    call = _libc.syscall
    ruleset = _checked(
        call(ctypes.c_long(_SYS_LANDLOCK[0]), attributes, ctypes.c_size_t(len(attributes)), ctypes.c_uint(0)),
        "landlock_create_ruleset",
    )
    try:
        for path, access in [*allowed, *((folder, rights) for folder in everything)]:
            _allow(ruleset, path, access & rights)
        no_new_privileges()
        _checked(
            call(ctypes.c_long(_SYS_LANDLOCK[2]), ctypes.c_int(ruleset), ctypes.c_uint(0)),
            "landlock_restrict_self",
        )
    finally:
        os.close(ruleset)


def _allow(ruleset: int, path: str, access: int) -> None:
    descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
    try:
        if not os.path.isdir(path):
            access &= _OF_A_FILE
        rule = struct.pack("<Qi", access, descriptor)
        result = _libc.syscall(
            ctypes.c_long(_SYS_LANDLOCK[1]), ctypes.c_int(ruleset), ctypes.c_int(1), rule, ctypes.c_uint(0)
        )
        _checked(result, f"landlock_add_rule {path}")
    finally:
        os.close(descriptor)
