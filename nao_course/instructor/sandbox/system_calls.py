"""Which system calls a student's code may not make, as a program that the kernel runs before each of them."""

import contextlib
import errno
import tempfile
from collections.abc import Collection

from nao_course.instructor.sandbox.linux import NEW_NAMESPACE

_CLONE_PARENT = 0x00008000  # the child would be the server's, which does not know it
_MAP_SHARED, _MAP_ANONYMOUS = 0x01, 0x20
_MADV_COLD, _MADV_PAGEOUT = 20, 21
# Of fcntl: locks of a process (to ask, set, wait for) and of an open file, leases (set, ask), notes of changes.
_LOCKS_AND_NOTES = (5, 6, 7, 36, 37, 38, 1024, 1025, 1026)

_DENIED_CALLS = (
    *("socket", "connect", "bind", "listen", "accept", "accept4"),
    *("ptrace", "process_vm_readv", "process_vm_writev", "process_madvise", "pidfd_getfd", "kcmp"),
    *("mount", "umount", "umount2", "pivot_root", "chroot", "move_mount", "open_tree", "fsopen", "fsconfig"),
    *("fsmount", "fspick", "mount_setattr", "unshare", "setns", "quotactl", "swapon", "swapoff"),
    *("keyctl", "add_key", "request_key", "bpf", "perf_event_open", "userfaultfd", "fanotify_init"),
    *("io_uring_setup", "io_uring_enter", "io_uring_register", "io_setup"),
    *("kexec_load", "kexec_file_load", "init_module", "finit_module", "delete_module", "reboot", "acct"),
    *("open_by_handle_at", "name_to_handle_at", "lookup_dcookie", "syslog", "vhangup", "iopl", "ioperm"),
    *("modify_ldt", "settimeofday", "clock_settime", "clock_adjtime", "adjtimex", "sethostname"),
    *("setdomainname", "migrate_pages", "move_pages", "nfsservctl", "personality"),
    *("shmget", "shmat", "shmctl", "semget", "semop", "semctl", "msgget", "msgsnd", "msgrcv", "mq_open"),
    *("sync", "syncfs"),  # writing out all that the machine has in hand takes others' time
    *("memfd_create", "memfd_secret"),  # memory that no limit counts
    # Calls by which workers could exchange messages over a library's file that both read, or over the cache.
    *("flock", "inotify_init", "inotify_init1", "inotify_add_watch"),
    *("fadvise64", "fadvise64_64", "arm_fadvise64_64", "readahead", "mincore", "cachestat"),
    "setsockopt",  # how much a socket may hold: no limit counts that either
    "setsid",  # the kernel shares processors out by session: more of them would be more than a worker's share
)

# Calls that are denied where an argument, by its number, has all bits of a value, or is one of some.
_DENIED_FLAGS = {
    "clone": [(0, 1 << bit) for bit in range(32) if 1 << bit & (NEW_NAMESPACE | _CLONE_PARENT)],
    "mmap": [(3, _MAP_SHARED | _MAP_ANONYMOUS)],  # held by nobody, once a process has let go of it
}
_DENIED_VALUES = {
    "fcntl": [(1, value) for value in _LOCKS_AND_NOTES],
    "madvise": [(2, value) for value in (_MADV_COLD, _MADV_PAGEOUT)],
}
# Calls that are denied unless an argument has a value: a socketpair of another family than Unix, reading with a flag.
_ALLOWED_VALUES = {"socketpair": (0, 1), "preadv2": (5, 0), "pwritev2": (5, 0)}

_FILE_CHANGES = (  # of files, which Landlock does not know; in a view of its own, a worker may
    *("chmod", "fchmod", "fchmodat", "fchmodat2", "chown", "lchown", "fchown", "fchownat"),
    *("utime", "utimes", "futimesat", "utimensat", "setxattr", "lsetxattr", "fsetxattr"),
    *("removexattr", "lremovexattr", "fremovexattr"),
)
# Calls that came after this list was made, by number, which libseccomp may not know: statmount reveals where a
# mount comes from. Their numbers are the same on all processors; to libraries this is an older Linux.
_LATER = range(453, 560)


def seccomp_program(on: Collection[str]) -> bytes:
    """Compile the filter of system calls for a worker behind some layers; libseccomp is needed.

    Raise an ImportError, OSError or RuntimeError without pyseccomp or libseccomp.
    """
    import pyseccomp

    rules = pyseccomp.SyscallFilter(pyseccomp.ALLOW)
    for name in _DENIED_CALLS if "mount namespace" in on else (*_DENIED_CALLS, *_FILE_CHANGES):
        with contextlib.suppress(OSError, ValueError):  # a call that this processor or library does not know
            rules.add_rule(pyseccomp.ERRNO(errno.EPERM), name)
    for denied, how in ((_DENIED_FLAGS, pyseccomp.MASKED_EQ), (_DENIED_VALUES, pyseccomp.EQ)):
        for name, arguments in denied.items():
            for at, value in arguments:
                values = (value, value) if how == pyseccomp.MASKED_EQ else (value,)
                rules.add_rule(pyseccomp.ERRNO(errno.EPERM), name, pyseccomp.Arg(at, how, *values))
    for name, (at, value) in _ALLOWED_VALUES.items():
        rules.add_rule(pyseccomp.ERRNO(errno.EPERM), name, pyseccomp.Arg(at, pyseccomp.NE, value))
    # The flags of clone3 lie in memory, which a filter cannot read: without it, libraries use clone.
    for call in ("clone3", *_LATER):
        rules.add_rule(pyseccomp.ERRNO(errno.ENOSYS), call)
    with tempfile.TemporaryFile() as file:
        rules.export_bpf(file)
        file.seek(0)
        return file.read()
