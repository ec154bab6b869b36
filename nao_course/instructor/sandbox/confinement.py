"""What keeps a student's code from everything but its own inputs: layers, each tried at the start, and named levels."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import signal
import site
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

if sys.platform != "win32":
    import resource
if sys.platform == "linux":
    from nao_course.instructor.sandbox import linux as syscalls

# What holds at each level, beside the codec, limits for each process and the kill by wall clock:
#   process     nothing else: a student's code can read and write what the grader can.
#   landlock    files, TCP, signals, abstract sockets are closed; UDP and the number of processes are not.
#   namespaces  files, network and processes are the worker's own; it ends as a whole; all it uses is bounded.
#   full        all of this twice, by independent means, as a user without rights, and with fewer system calls.
LEVELS = ("process", "landlock", "namespaces", "full")
_NAMESPACES = ("user namespace", "pid namespace", "mount namespace", "ipc namespace", "network namespace")
_LINUX = (*_NAMESPACES, "landlock", "seccomp", "unprivileged user")
_NEEDS = {
    "process": (),
    "landlock": ("landlock",),
    "namespaces": _NAMESPACES,
    "full": _LINUX,
}
SCRATCH = "/scratch"  # in a worker's own view of the files
_USERS = (
    (1_900_000_000, 1000),
    (65534, 1),
)  # of the host: the first of a range that nobody uses, and how many
_FIRST_USER = 1000  # what they are called in the user namespace
_TRIAL_SECONDS = 60.0


class SandboxError(RuntimeError):
    """A sandbox that is weaker than what was asked for, or than it was when it was tried."""


@dataclass(frozen=True)
class Layer:
    """One thing that holds a student's code back.

    Parameters
    ----------
    name : str
        Such as "landlock".
    on : bool
        Whether it works here.
    detail : str
        What it does, or why it is not there.
    """

    name: str
    on: bool
    detail: str = ""


@dataclass(frozen=True)
class Bounds:
    """How much one worker may use.

    Parameters
    ----------
    memory : int
        Bytes: of what each process may map to write to, beyond what the server itself has (with what it shares or only
        reserves, twice that), and, where there is a PID namespace, of what all its processes hold together.
    processes : int
        Processes and threads.
    scratch : int
        Bytes of all files, where there is a mount namespace; of each file elsewhere.
    files : int
        Open files of each process.
    cpu_seconds : int
        Of each process.
    """

    memory: int = 2 * 2**30
    processes: int = 48
    scratch: int = 128 * 2**20
    files: int = 128
    cpu_seconds: int = 150


@dataclass(frozen=True)
class Sandbox:
    """The layers that work on this machine.

    Parameters
    ----------
    layers : tuple of Layer
        All that there are, on or off.
    """

    layers: tuple[Layer, ...]

    @property
    def on(self) -> frozenset[str]:
        """Names of the layers that work."""
        return frozenset(layer.name for layer in self.layers if layer.on)

    @property
    def level(self) -> str:
        """The highest of LEVELS all of whose layers work."""
        return [level for level in LEVELS if self.on.issuperset(_NEEDS[level])][-1]

    def require(self, level: str) -> None:
        """Refuse to go on below a level.

        Raises
        ------
        ValueError
            If there is no such level.
        SandboxError
            If a layer of it is missing; the message says which and why.
        """
        if level not in LEVELS:
            raise ValueError(f"a sandbox's level is one of {', '.join(LEVELS)}; got {level!r}")
        missing = [layer for layer in self.layers if not layer.on and layer.name in _NEEDS[level]]
        if missing:
            reasons = "; ".join(f"no {layer.name}: {layer.detail}" for layer in missing)
            raise SandboxError(
                f"sandbox level {level!r} is required, this machine has {self.level!r}: {reasons}"
            )

    def __str__(self) -> str:
        """Return the line that is printed at the start."""
        missing = [f"no {layer.name} ({layer.detail})" for layer in self.layers if not layer.on]
        there = f"Sandbox: level {self.level!r} of {LEVELS[-1]!r}"
        if not missing:
            return f"{there}: {', '.join(layer.name for layer in self.layers)}."
        loud = "" if self.level != "process" else " STUDENTS' CODE CAN READ AND WRITE WHAT YOU CAN."
        return f"{there}: {'; '.join(missing)}.{loud}"


@cache
def probe() -> Sandbox:
    """Try every layer, each in a process that is thrown away.

    Returns
    -------
    Sandbox
        What works here; off Linux, no more than processes with limits.
    """
    layers = [
        Layer("own process", True, "killed with all its group by the wall clock"),
        Layer(
            "limits",
            sys.platform != "win32",
            "of time, memory, files" if os.name == "posix" else "not on Windows",
        ),
        Layer("scrubbed environment", True),
        Layer("private folder", True),
    ]
    if sys.platform != "linux":
        return Sandbox((*layers, *(Layer(name, False, f"not on {sys.platform}") for name in _LINUX)))
    trial = [sys.executable, "-P", "-m", "nao_course.instructor.sandbox.confinement"]
    try:
        done = subprocess.run(trial, capture_output=True, timeout=_TRIAL_SECONDS, check=True)
        found = [Layer(*each) for each in json.loads(done.stdout)]
    except (OSError, subprocess.SubprocessError, ValueError) as error:
        found = [Layer(name, False, f"it could not be tried: {error}") for name in _LINUX]
    return Sandbox((*layers, *found))


# --- what may be seen ---


def readable() -> list[str]:
    """Files and folders that Python, its packages and the student side of this one need; nothing else is shown."""
    package = Path(__file__).resolve().parents[1]
    own = [path for path in package.iterdir() if path.name not in ("instructor", "cli.py", "__pycache__")]
    named = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    users = [site.getusersitepackages()] if site.ENABLE_USER_SITE else []
    packages = [*site.getsitepackages(), *users, sysconfig.get_config_var("LIBDIR") or ""]
    system = ["/lib", "/lib64", "/usr/lib", "/usr/lib64", "/etc/ld.so.cache", "/etc/localtime"]
    shared = ["/usr/share/zoneinfo", "/usr/share/fonts", "/usr/local/share/fonts"]
    paths = [os.path.abspath(path) for path in (*named, *packages, *system, *shared, *map(str, own)) if path]
    return sorted({path for path in paths if os.path.exists(path)})


def _outermost(paths: Iterable[str]) -> list[str]:
    """Real paths, without those that lie in another of them."""
    kept: list[str] = []
    for path in sorted({os.path.realpath(path) for path in paths}):
        if not any(path == each or path.startswith(each + "/") for each in kept):
            kept.append(path)
    return kept


def _links(path: str) -> Iterator[tuple[str, str]]:
    """Symbolic links on the way to a path, with what each leads to."""
    at = Path("/")
    for part in Path(path).parts[1:]:
        at /= part
        if at.is_symlink():
            yield str(at), os.path.realpath(at)
            at = at.resolve()


# --- what the server does, once ---


def enter_namespaces(on: Collection[str]) -> list[int]:
    """Move this process, which has one thread, and its children into new namespaces.

    Parameters
    ----------
    on : collection of str
        Names of layers.

    Returns
    -------
    list of int
        Unprivileged users that its children may become; empty where they are one already.

    Raises
    ------
    OSError
        If the kernel refuses.
    """
    users: list[int] = []
    if "user namespace" in on:
        users = _enter_user_namespace()
    elif os.geteuid() == 0:
        users = list(range(_USERS[0][0], sum(_USERS[0])))
    flags = {
        "pid namespace": syscalls.CLONE_NEWPID,
        "mount namespace": syscalls.CLONE_NEWNS,
        "ipc namespace": syscalls.CLONE_NEWIPC | syscalls.CLONE_NEWUTS,
        "network namespace": syscalls.CLONE_NEWNET,
    }
    wanted = sum(flag for name, flag in flags.items() if name in on)
    if wanted:
        syscalls.unshare(wanted)
    return users if "unprivileged user" in on else []


def _enter_user_namespace() -> list[int]:
    """Become the administrator of a new user namespace; if already the machine's, bring unprivileged users along."""
    user, group = os.geteuid(), os.getegid()
    if user != 0:
        syscalls.unshare(syscalls.CLONE_NEWUSER)
        _map_users(0, user, group)
        return []
    process, (ready, tell) = os.getpid(), os.pipe()
    child = os.fork()
    if child == 0:  # only a process outside may map several users
        os.close(tell)
        os.read(ready, 1)
        os._exit(next((many for many, at in enumerate(_USERS) if _map_range(process, *at)), len(_USERS)))
    os.close(ready)
    try:
        syscalls.unshare(syscalls.CLONE_NEWUSER)
    finally:
        os.close(tell)
        _, status = os.waitpid(child, 0)
    choice = os.waitstatus_to_exitcode(status)
    if not 0 <= choice < len(_USERS):
        raise OSError(errno.EPERM, "no unprivileged user can be mapped into a user namespace")
    os.setgroups([])
    return list(range(_FIRST_USER, _FIRST_USER + _USERS[choice][1]))


def _map_range(process: int, first: int, many: int) -> bool:
    try:
        for kind in ("uid_map", "gid_map"):
            Path(f"/proc/{process}/{kind}").write_text(f"0 0 1\n{_FIRST_USER} {first} {many}\n")
    except OSError:
        return False
    return True


def _map_users(inside: int, user: int, group: int) -> None:
    Path("/proc/self/setgroups").write_text("deny")
    Path("/proc/self/uid_map").write_text(f"{inside} {user} 1")
    Path("/proc/self/gid_map").write_text(f"{inside} {group} 1")


def narrow_view(paths: Iterable[str]) -> None:
    """Leave nothing of the file system in sight but some paths, all of them read-only; for a mount namespace.

    The process must be in a PID namespace of its own, too: it gets its own /proc.
    """
    syscalls.mount("none", "/", flags=syscalls.MS_REC | syscalls.MS_PRIVATE)
    devices = [f"/dev/{name}" for name in ("null", "zero", "urandom", "random")]
    paths = list(paths)
    sources = {path: os.open(path, os.O_PATH) for path in [*_outermost(paths), *devices]}
    links = {link: target for path in paths for link, target in _links(path)}
    root = "/tmp" if os.path.isdir("/tmp") else "/mnt"
    syscalls.mount("tmpfs", root, "tmpfs", syscalls.MS_NOSUID | syscalls.MS_NODEV, "mode=755,size=1m")
    for path, source in sources.items():
        _show(source, root + path, device=path in devices)
        os.close(source)
    for link, target in links.items():
        if not os.path.lexists(root + link):
            os.makedirs(os.path.dirname(root + link), exist_ok=True)
            os.symlink(target, root + link)
    for folder in ("proc", SCRATCH):
        os.makedirs(os.path.join(root, folder.lstrip("/")), exist_ok=True)
    if not os.path.lexists(f"{root}/tmp"):
        os.symlink(SCRATCH, f"{root}/tmp")
    syscalls.mount(
        "proc", f"{root}/proc", "proc", syscalls.MS_NOSUID | syscalls.MS_NODEV | syscalls.MS_NOEXEC
    )
    os.chdir(root)
    syscalls.pivot_root(".", ".")
    syscalls.unmount(".")
    os.chdir("/")
    syscalls.mount("none", "/", flags=_MS_REMOUNT_READ_ONLY)


_MS_REMOUNT_READ_ONLY = 0x20 | 0x1000 | 1 | 2 | 4  # remount, bind, read-only, no setuid, no devices


def _show(source: int, target: str, *, device: bool) -> None:
    """Bind what a descriptor leads to at a place in the new root."""
    path = f"/proc/self/fd/{source}"
    if os.path.isdir(path):
        os.makedirs(target, exist_ok=True)
    else:
        os.makedirs(os.path.dirname(target), exist_ok=True)
        Path(target).touch()
    syscalls.mount(path, target, flags=syscalls.MS_BIND | syscalls.MS_REC)
    attributes = syscalls.ATTR_NOSUID if device else syscalls.ATTR_NOSUID | syscalls.ATTR_NODEV
    syscalls.mount_attributes(target, attributes if device else attributes | syscalls.ATTR_RDONLY)


_DENIED = (
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
    *("memfd_create", "memfd_secret"),  # memory that no limit counts
    "setsid",  # the kernel shares processors out by session: more of them would be more than a worker's share
)


_CHANGES = (  # of files, which Landlock does not know; in a view of its own, a worker may
    *("chmod", "fchmod", "fchmodat", "fchmodat2", "chown", "lchown", "fchown", "fchownat"),
    *("utime", "utimes", "futimesat", "utimensat", "setxattr", "lsetxattr", "fsetxattr", "setxattrat"),
    *("removexattr", "lremovexattr", "fremovexattr", "removexattrat"),
)


def seccomp_program(on: Collection[str]) -> bytes:
    """Compile the filter of system calls for a worker behind some layers; libseccomp is needed.

    Raises
    ------
    ImportError, OSError, RuntimeError
        If there is no pyseccomp, or no libseccomp.
    """
    import pyseccomp

    rules = pyseccomp.SyscallFilter(pyseccomp.ALLOW)
    for name in _DENIED if "mount namespace" in on else (*_DENIED, *_CHANGES):
        with contextlib.suppress(OSError, ValueError):  # a call that this processor or library does not know
            rules.add_rule(pyseccomp.ERRNO(errno.EPERM), name)
    for flag in (1 << bit for bit in range(32)):
        if flag & syscalls.NEW_NAMESPACE:
            argument = pyseccomp.Arg(0, pyseccomp.MASKED_EQ, flag, flag)
            rules.add_rule(pyseccomp.ERRNO(errno.EPERM), "clone", argument)
    # Its flags lie in memory, which a filter cannot read: without it, libraries use clone.
    rules.add_rule(pyseccomp.ERRNO(errno.ENOSYS), "clone3")
    other = pyseccomp.Arg(0, pyseccomp.NE, 1)  # a socketpair of another family than Unix
    rules.add_rule(pyseccomp.ERRNO(errno.EPERM), "socketpair", other)
    with tempfile.TemporaryFile() as file:
        rules.export_bpf(file)
        file.seek(0)
        return file.read()


# --- what each worker does ---


@dataclass(frozen=True)
class Walls:
    """What a server has made ready for its workers.

    Parameters
    ----------
    on : frozenset of str
        Layers that work.
    paths : tuple of str
        What may be read.
    program : bytes
        The seccomp filter.
    bounds : Bounds
        How much a worker may use.
    """

    on: frozenset[str]
    paths: tuple[str, ...] = ()
    program: bytes = b""
    bounds: Bounds = field(default_factory=Bounds)

    def close_around(self, user: int | None, folder: str) -> None:
        """Confine this process, just forked, for good.

        Parameters
        ----------
        user : int or None
            Whom to become; None where it stays who it is.
        folder : str
            The only one it may write to; it becomes the working folder.

        Raises
        ------
        OSError
            If the kernel refuses: nothing of a student's may run.
        """
        Path("/proc/self/oom_score_adj").write_text("1000")
        flags = syscalls.CLONE_NEWNS if "mount namespace" in self.on else 0
        flags |= syscalls.CLONE_NEWIPC if "ipc namespace" in self.on else 0
        flags |= syscalls.CLONE_NEWNET if "network namespace" in self.on else 0
        if flags:
            syscalls.unshare(flags)
        if "mount namespace" in self.on:
            self._mount(user or 0, folder)
        os.chdir(folder)
        self._become(user)
        limit_resources(
            self.bounds
        )  # not before: a new user namespace hands its limit up to all of its user's
        self._lock([folder])

    def idle(self, user: int | None) -> None:
        """Confine the process that only waits until its PID namespace has to end."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGCHLD):
            signal.signal(number, signal.SIG_IGN)  # ended orphans are cleared away by the kernel
        self._become(user)
        self._lock([])

    def _mount(self, user: int, folder: str) -> None:
        options = f"size={self.bounds.scratch},nr_inodes=4096,mode=700,uid={user},gid={user}"
        safe = syscalls.MS_NOSUID | syscalls.MS_NODEV
        syscalls.mount("tmpfs", folder, "tmpfs", safe | syscalls.MS_NOEXEC, options)
        syscalls.mount("proc", "/proc", "proc", safe | syscalls.MS_NOEXEC, "subset=pid")

    def _become(self, user: int | None) -> None:
        """Give up all privileges."""
        if user is not None:
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
        elif "user namespace" in self.on and os.geteuid() == 0:  # one of its own: RLIMIT_NPROC counts in it
            syscalls.unshare(syscalls.CLONE_NEWUSER)
            _map_users(_FIRST_USER, 0, 0)
        if "user namespace" in self.on:
            syscalls.drop_capabilities()

    def _lock(self, folders: list[str]) -> None:
        syscalls.die_with_parent(signal.SIGKILL)
        syscalls.no_new_privileges()
        syscalls.not_dumpable()
        if "landlock" in self.on:
            read = [(path, syscalls.FS_READ) for path in (*self.paths, "/proc/self") if folders]
            devices = [("/dev/null", syscalls.FS_READ_FILE | syscalls.FS_WRITE_FILE)]
            devices += [(f"/dev/{name}", syscalls.FS_READ_FILE) for name in ("zero", "urandom", "random")]
            syscalls.landlock([*read, *devices] if folders else [], folders)
        if "seccomp" in self.on:
            syscalls.load_filter(self.program)


def limit_resources(bounds: Bounds) -> None:
    """Set this process's limits; where the system has none of a kind, it is left out."""
    if sys.platform == "win32":
        return
    limits = {
        "RLIMIT_CPU": bounds.cpu_seconds,
        "RLIMIT_CORE": 0,
        "RLIMIT_FSIZE": bounds.scratch,
        "RLIMIT_NOFILE": bounds.files,
        "RLIMIT_NPROC": bounds.processes if sys.platform == "linux" else resource.RLIM_INFINITY,
        "RLIMIT_AS": _mapped(0) + 2 * bounds.memory if sys.platform == "linux" else resource.RLIM_INFINITY,
        "RLIMIT_DATA": _mapped(5) + bounds.memory if sys.platform == "linux" else resource.RLIM_INFINITY,
        "RLIMIT_MSGQUEUE": 0,
        "RLIMIT_MEMLOCK": 0,
    }
    for name, limit in limits.items():
        kind = getattr(resource, name, None)
        if kind is None or limit == resource.RLIM_INFINITY:
            continue
        most = resource.getrlimit(kind)[1]
        least = limit if most == resource.RLIM_INFINITY else min(limit, most)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(kind, (least, least))


def _mapped(which: int) -> int:
    """Bytes that this process has mapped: in all (0), or that it may write to alone (5)."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[which]) * os.sysconf("SC_PAGE_SIZE")


# --- trying ---


def _tried(attempt: Callable[[], object]) -> str:
    """Why something does not work in a process forked for it; empty where it does."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            attempt()
            message = ""
        except BaseException as error:  # noqa: BLE001 - whatever it is, it is the reason
            message = f"{type(error).__name__}: {error}" if not isinstance(error, OSError) else str(error)
        os.write(write, message.encode()[:500])
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as file:
        message = file.read().decode("utf-8", "replace")
    _, status = os.waitpid(child, 0)
    return message or ("" if status == 0 else f"a process that tried it ended with status {status}")


def _in_a_child(attempt: Callable[[], object]) -> None:
    """Do something in a child; OSError where it fails there."""
    if reason := _tried(attempt):
        raise OSError(reason)


def _must_fail(attempt: Callable[[], object], what: str) -> None:
    try:
        attempt()
    except OSError:
        return
    raise OSError(f"it was set up, but {what} is still possible")


def _try_namespace(name: str) -> None:
    enter_namespaces({"user namespace", name})
    if name == "pid namespace":
        _in_a_child(lambda: _expect(os.getpid() == 1, "it is not the first process"))
    elif name == "network namespace":
        with open("/proc/self/net/dev") as file:
            _expect(len(file.readlines()) <= 3, "there are devices in it")


def _try_view() -> None:
    enter_namespaces({"user namespace", "pid namespace", "mount namespace"})

    def look() -> None:
        narrow_view(readable())
        _must_fail(lambda: os.listdir("/home"), "looking into /home")
        _must_fail(lambda: Path("/here").touch(), "writing to the root")
        os.listdir(sysconfig.get_path("stdlib"))

    _in_a_child(look)


def _expect(true: bool, otherwise: str) -> None:
    if not true:
        raise OSError(otherwise)


def _try_landlock() -> None:
    syscalls.landlock([(path, syscalls.FS_READ) for path in readable()])
    _must_fail(lambda: os.listdir("/"), "reading the root folder")
    os.listdir(sysconfig.get_path("stdlib"))


def _try_seccomp() -> None:
    import socket

    syscalls.no_new_privileges()
    syscalls.load_filter(seccomp_program({"seccomp"}))
    _must_fail(lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM), "opening a socket")


def _try_user(*, namespace: bool) -> None:
    """Become an unprivileged user, who can still read Python's own files."""
    if os.geteuid() != 0:
        return
    users = enter_namespaces({"user namespace", "unprivileged user"}) if namespace else [_USERS[0][0]]
    os.setgroups([])
    os.setresgid(users[0], users[0], users[0])
    os.setresuid(users[0], users[0], users[0])
    if not namespace:  # else it gets a view of its own
        os.listdir(sysconfig.get_path("stdlib"))


def _try_all(on: frozenset[str]) -> None:
    """Do once what the server does."""
    program = seccomp_program(on) if "seccomp" in on else b""
    users = enter_namespaces(on)
    walls = Walls(on, tuple(readable()), program)

    def serve() -> None:
        narrow_view(walls.paths)
        _in_a_child(lambda: walls.close_around(users[0] if users else None, SCRATCH))

    _in_a_child(serve)


def _trial() -> list[Layer]:
    """Try all layers of Linux, one by one, and then together."""
    found = {name: _tried(lambda name=name: _try_namespace(name)) for name in _NAMESPACES}  # type: ignore[misc]
    found["mount namespace"] = found["mount namespace"] or _tried(_try_view)
    found["landlock"] = _tried(_try_landlock)
    found["seccomp"] = _tried(_try_seccomp)
    found["unprivileged user"] = _tried(lambda: _try_user(namespace=not found["user namespace"]))
    details = dict.fromkeys(found, "")
    if not found["landlock"]:
        details["landlock"] = f"version {syscalls.landlock_version()}"
    details["unprivileged user"] = "" if os.geteuid() == 0 else f"started by user {os.geteuid()}"
    if any(
        found[name] for name in _NAMESPACES
    ):  # a view without a PID namespace would show the host's processes
        for name in _NAMESPACES:
            found[name] = found[name] or "it holds only together with the other namespaces"
    else:
        on = frozenset(name for name, reason in found.items() if not reason)
        if reason := _tried(lambda: _try_all(on)):
            found |= dict.fromkeys(_NAMESPACES, f"together: {reason}")
    if any(found[name] for name in _NAMESPACES):
        found["unprivileged user"] = _tried(lambda: _try_user(namespace=False))
    return [Layer(name, not reason, reason or details[name]) for name, reason in found.items()]


if __name__ == "__main__":
    sys.stdout.write(json.dumps([[layer.name, layer.on, layer.detail] for layer in _trial()]))
