"""Confines a student's code to its own inputs: namespaces, a view of few files, a filter of system calls, limits."""

import contextlib
import errno
import os
import signal
import site
import socket
import sys
import sysconfig
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import nao_course

if sys.platform != "win32":
    import resource
if sys.platform == "linux":
    from nao_course.instructor.sandbox import linux

# What a process may read of itself. Its mounts would reveal the path of the course.
_OWN_PROCESS = ("cmdline", "comm", "fd", "limits", "maps", "smaps", "stat", "statm", "status")
SCRATCH = "/scratch"  # in a worker's own view of the files
UNUSED_USER = 1_900_000_000  # of the host: the first of a range that nobody uses
_USERS = ((UNUSED_USER, 1000), (65534, 1))  # the first of a range, and how many
_FIRST_USER = 1000  # what they are called in the user namespace
INSTRUCTORS = ("instructor", "cli")  # modules of this package that a student's code does not see


@dataclass(frozen=True)
class Bounds:
    """How much one worker may use.

    `memory`, in bytes, limits what each process may map to write to, beyond what the server itself has (with what it
    shares or only reserves, twice that), and, where there is a PID namespace, what all its processes hold together.
    `processes` counts threads, too; `scratch`, in bytes, is of all files, where there is a mount namespace, and of each
    file elsewhere; `files` are open files of each process, as are `cpu_seconds`.
    """

    memory: int = 2 * 2**30
    processes: int = 48
    scratch: int = 128 * 2**20
    files: int = 64
    cpu_seconds: int = 150


# --- what may be seen ---


def readable() -> list[str]:
    """Return the files and folders that Python, its packages and the students' modules need; all else is hidden."""
    package = Path(nao_course.__file__).resolve().parent
    own = [path for path in package.iterdir() if path.stem not in (*INSTRUCTORS, "__pycache__")]
    named = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    users = [site.getusersitepackages()] if site.ENABLE_USER_SITE else []
    packages = [*site.getsitepackages(), *users, sysconfig.get_config_var("LIBDIR") or ""]
    system = ["/lib", "/lib64", "/usr/lib", "/usr/lib64", "/etc/ld.so.cache", "/etc/localtime"]
    shared = ["/usr/share/zoneinfo", "/usr/share/fonts", "/usr/local/share/fonts"]
    paths = [os.path.abspath(path) for path in (*named, *packages, *system, *shared, *map(str, own)) if path]
    return sorted({path for path in paths if os.path.exists(path)})


def _outermost(paths: Iterable[str]) -> list[str]:
    """Return the real paths, without those inside another one."""
    kept: list[str] = []
    for path in sorted({os.path.realpath(path) for path in paths}):
        if not any(path == each or path.startswith(each + "/") for each in kept):
            kept.append(path)
    return kept


def _links(path: str) -> Iterator[tuple[str, str]]:
    """Return the symbolic links in a path with their targets."""
    at = Path("/")
    for part in Path(path).parts[1:]:
        at /= part
        if at.is_symlink():
            yield str(at), os.path.realpath(at)
            at = at.resolve()


# --- what the server does, once ---


def enter_namespaces(on: Collection[str]) -> list[int]:
    """Move this process, which has one thread, and its children into the new namespaces of some layers.

    Return unprivileged users that its children may become, none if they are one already. Raise an OSError if the kernel
    refuses.
    """
    with contextlib.suppress(OSError):  # a system that refuses keyrings refuses them to an attack, too
        linux.close_keyring()
    users: list[int] = []
    if "user namespace" in on:
        users = _enter_user_namespace()
    elif os.geteuid() == 0:
        users = list(range(_USERS[0][0], sum(_USERS[0])))
    flags = {
        "pid namespace": linux.CLONE_NEWPID,
        "mount namespace": linux.CLONE_NEWNS,
        "ipc namespace": linux.CLONE_NEWIPC | linux.CLONE_NEWUTS,
        "network namespace": linux.CLONE_NEWNET,
    }
    wanted = sum(flag for name, flag in flags.items() if name in on)
    if wanted:
        linux.unshare(wanted)
    if "ipc namespace" in on:
        socket.sethostname("worker")  # this machine's name is nobody's business
    return users if "unprivileged user" in on else []


def _enter_user_namespace() -> list[int]:
    """Enter a new user namespace as its administrator; root also maps unprivileged users."""
    user, group = os.geteuid(), os.getegid()
    if user != 0:
        linux.unshare(linux.CLONE_NEWUSER)
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
        linux.unshare(linux.CLONE_NEWUSER)
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
    os.umask(0o022)  # another user enters the folders that are made here
    linux.mount("none", "/", flags=linux.MS_REC | linux.MS_PRIVATE)
    devices = [f"/dev/{name}" for name in ("null", "urandom", "random")]  # zero: shared memory
    paths = list(paths)
    sources = {path: os.open(path, os.O_PATH) for path in [*_outermost(paths), *devices]}
    links = {link: target for path in paths for link, target in _links(path)}
    root = "/tmp" if os.path.isdir("/tmp") else "/mnt"
    linux.mount("tmpfs", root, "tmpfs", linux.MS_NOSUID | linux.MS_NODEV, "mode=755,size=1m")
    for path, source in sources.items():
        _bind(source, root + path, device=path in devices)
        os.close(source)
    for link, target in links.items():
        if not os.path.lexists(root + link):
            os.makedirs(os.path.dirname(root + link), exist_ok=True)
            os.symlink(target, root + link)
    for folder in ("proc", SCRATCH):
        os.makedirs(os.path.join(root, folder.lstrip("/")), exist_ok=True)
    if not os.path.lexists(f"{root}/tmp"):
        os.symlink(SCRATCH, f"{root}/tmp")
    linux.mount("proc", f"{root}/proc", "proc", linux.MS_NOSUID | linux.MS_NODEV | linux.MS_NOEXEC)
    os.chdir(root)
    linux.pivot_root(".", ".")
    linux.unmount(".")
    os.chdir("/")
    linux.mount("none", "/", flags=_MS_REMOUNT_READ_ONLY)


_MS_REMOUNT_READ_ONLY = 0x20 | 0x1000 | 1 | 2 | 4  # remount, bind, read-only, no setuid, no devices


def _bind(source: int, target: str, *, device: bool) -> None:
    """Bind what a descriptor leads to at a place in the new root."""
    path = f"/proc/self/fd/{source}"
    if os.path.isdir(path):
        os.makedirs(target, exist_ok=True)
    else:
        os.makedirs(os.path.dirname(target), exist_ok=True)
        Path(target).touch()
    linux.mount(path, target, flags=linux.MS_BIND | linux.MS_REC)
    attributes = linux.ATTR_NOSUID if device else linux.ATTR_NOSUID | linux.ATTR_NODEV
    linux.mount_attributes(target, attributes if device else attributes | linux.ATTR_RDONLY)


# --- what each worker does ---


@dataclass(frozen=True)
class Confinement:
    """Layers that a server has prepared for its workers: readable paths, the seccomp filter, and limits."""

    on: frozenset[str]
    paths: tuple[str, ...] = ()
    program: bytes = b""
    bounds: Bounds = field(default_factory=Bounds)

    def enter(self, user: int | None, folder: str) -> None:
        """Confine this process, just forked, for good: it becomes a user, unless None, and writes to one folder only.

        The folder becomes the working folder. Nothing of a student's may run if the kernel refuses, which raises an
        OSError.
        """
        Path("/proc/self/oom_score_adj").write_text("1000")
        flags = linux.CLONE_NEWNS if "mount namespace" in self.on else 0
        flags |= linux.CLONE_NEWIPC if "ipc namespace" in self.on else 0
        flags |= linux.CLONE_NEWNET if "network namespace" in self.on else 0
        if flags:
            linux.unshare(flags)
        if "mount namespace" in self.on:
            self._mount(user or 0, folder)
        os.chdir(folder)
        self._become(user)
        # Not before: a new user namespace hands its limit up to all of its user's.
        limit_resources(self.bounds)
        self._lock([folder])

    def enter_as_init(self, user: int | None) -> None:
        """Confine the process that only waits until its PID namespace has to end."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGCHLD):
            signal.signal(number, signal.SIG_IGN)  # ended orphans are cleared away by the kernel
        self._become(user)
        self._lock([])

    def _mount(self, user: int, folder: str) -> None:
        options = f"size={self.bounds.scratch},nr_inodes=4096,mode=700,uid={user},gid={user}"
        safe = linux.MS_NOSUID | linux.MS_NODEV
        linux.mount("tmpfs", folder, "tmpfs", safe | linux.MS_NOEXEC, options)
        linux.mount("proc", "/proc", "proc", safe | linux.MS_NOEXEC, "subset=pid")

    def _become(self, user: int | None) -> None:
        """Give up all privileges."""
        if user is not None:
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
        elif "user namespace" in self.on and os.geteuid() == 0:  # one of its own: RLIMIT_NPROC counts in it
            linux.unshare(linux.CLONE_NEWUSER)
            _map_users(_FIRST_USER, 0, 0)
        if "user namespace" in self.on:
            linux.drop_capabilities()

    def _lock(self, folders: list[str]) -> None:
        linux.die_with_parent(signal.SIGKILL)
        linux.no_new_privileges()
        linux.not_dumpable()
        if "landlock" in self.on:
            own = [path for name in _OWN_PROCESS if os.path.exists(path := f"/proc/self/{name}")]
            read = [(path, linux.FS_READ) for path in (*self.paths, *own) if folders]
            devices = [("/dev/null", linux.FS_READ_FILE | linux.FS_WRITE_FILE)]
            devices += [(f"/dev/{name}", linux.FS_READ_FILE) for name in ("urandom", "random")]
            linux.landlock([*read, *devices] if folders else [], folders)
        if "seccomp" in self.on:
            linux.load_filter(self.program)


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
    """Return the bytes that this process has mapped: all (0), or only private writable ones (5)."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[which]) * os.sysconf("SC_PAGE_SIZE")
