"""A later siege: kinds of attacks, and of odd but honest work, that the first catalogues do not know."""

from __future__ import annotations

import io
import json
import os
import struct
import textwrap
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.attacks.accidents import (
    FILE,
    HONEST,
    TEXT,
    adding,
    edited,
    into,
    of_notebook,
    put,
    readable,
    zipped,
)
from tests.attacks.code import ALL, LATER, free, in_clamp, in_function, later, lending, looting, speaking
from tests.attacks.range import BLANK, LESSON, RIGHT, Attack, all_but, cell, notebook

# --- answers ---

ANSWERS = (
    in_clamp(
        "array_by_every_protocol",
        "answers",
        "return Lies()",
        """
        import numpy as np
        class Lies:
            kept = np.zeros(())
            __array_interface__ = kept.__array_interface__
            __array_struct__ = kept.__array_struct__
            def __buffer__(self, flags): return memoryview(self.kept)
            def __array__(self, *_, **__): return self.kept
            def __float__(self): return 0.0
            __index__ = __int__ = lambda self: 0
            def __reduce__(self): return (float, (0.0,))
            def __getattr__(self, name): return lambda *_, **__: self
        """,
        says="cannot be sent",
    ),
    in_clamp(
        "class_whose_bases_lie",
        "answers",
        "return Lies()",
        """
        import numpy as np
        class Meta(type):
            def mro(cls): return [cls, np.generic, object] if False else [cls, object]
            def __instancecheck__(cls, other): return True
            def __subclasscheck__(cls, other): return True
            __mro__ = property(lambda cls: (cls, float, object))
            __bases__ = property(lambda cls: (float,))
        class Lies(metaclass=Meta):
            __class__ = float
        """,
        says="cannot be sent",
    ),
    in_clamp(
        "class_by_the_name_of_the_courses",
        "answers",
        "return Pose(0.0, 0.0, 0.0)",
        """
        import dataclasses
        @dataclasses.dataclass
        class Pose:
            x: float
            y: float
            theta: float
        Pose.__module__, Pose.__qualname__ = 'nao_course.geometry', 'Pose'
        """,
        says="cannot be sent",
    ),
    in_clamp(
        "registers_a_class_of_its_own",
        "answers",
        "return Equal(1.0)",
        """
        import dataclasses
        from nao_course.exercises import register
        @register
        @dataclasses.dataclass
        class Equal:
            value: float
            def __eq__(self, other): return True
        """,
    ),
    in_clamp(
        "registers_a_function_of_its_own",
        "answers",
        "return abs",
        "from nao_course.codec import registry\nregistry._NAMES[id(abs)] = 'builtins:abs'\n"
        "registry._FUNCTIONS['builtins:abs'] = abs",
    ),
    in_clamp(
        "nan_with_a_payload",
        "answers",
        "import struct\nreturn struct.unpack('<d', struct.pack('<Q', 0x7ff0000000000001 + int(abs(x) * 1e6)))[0]",
    ),
    free("zero_below_zero", "answers", "if max(low, min(high, x)) == 0: return -0.0"),
    in_clamp("whole_number_of_511_bits", "answers", "return 2 ** 511 - 1"),
    in_clamp("list_of_numbers_of_511_bits", "answers", "return [2 ** 511 - 1] * 1000"),
    in_clamp(
        "dates_and_texts_of_numpy",
        "answers",
        "import numpy as np\nreturn np.datetime64('2026-01-01') if x > 0 else np.str_('0.0')",
        says="cannot be sent",
    ),
    in_clamp(
        "containers_that_never_end",
        "answers",
        "return Rows([x])",
        """
        import itertools
        class Rows(list):
            def __iter__(self): return itertools.repeat(0.0)
            def __len__(self): return 1
            def __getitem__(self, at): return 0.0
        """,
    ),
    in_clamp(
        "dict_whose_items_lie",
        "answers",
        "return Lies(a=x)",
        """
        class Lies(dict):
            def items(self): return iter(lambda: ('a', 1.0), None)
            keys = values = __iter__ = items
            def __len__(self): return -1 % 7
        """,
    ),
    in_clamp(
        "keys_that_are_equal_to_all",
        "answers",
        "return {Key(n): 1.0 for n in range(3)}",
        """
        class Key(int):
            def __eq__(self, other): return False
            def __hash__(self): return 7
        """,
    ),
    in_clamp(
        "number_that_changes_while_it_is_sent",
        "answers",
        "import numpy as np\nreturn Changes()",
        """
        import numpy as np
        class Changes(np.ndarray):
            def __new__(cls): return np.zeros(4).view(cls)
            shape = property(lambda self: (), lambda self, value: None)
            size = property(lambda self: -1)
            dtype = property(lambda self: np.dtype(object))
            def __array__(self, *_, **__): raise SystemExit
        """,
    ),
    in_clamp(
        "decimal_and_fraction",
        "answers",
        "import fractions\nreturn fractions.Fraction(x)",
        says="cannot be sent",
    ),
    Attack(
        "matrix_of_numpy",
        "honest",
        all_but("middle"),  # the median of a matrix is another one
        {"scaled": "def scaled(values):\n    return np.asmatrix(values - values.min()) / np.ptp(values)"},
    ),
    Attack(
        "array_that_is_read_only_and_turned",
        "honest",
        ALL,
        {
            "scaled": "def scaled(values):\n    made = np.asfortranarray((values - values.min()) / np.ptp(values))\n"
            "    made = made[::-1, ::-1][::-1, ::-1].astype('>f8')\n    made.flags.writeable = False\n    return made"
        },
    ),
    *(
        speaking(f"says_that_it_{name}", body)
        for name, body in {
            "timed_out": "loop.say(answered(outcome(status='timed out')))\ntime.sleep(9)",
            "died": "loop.say(answered(outcome(status='died', "
            "text='\"the process was ended by signal 9 (Killed)\"')))\ntime.sleep(9)",
            "was_not_found": "loop.say(answered(outcome(status='not found')))\ntime.sleep(9)",
            "cannot_send_markup": "loop.say(answered(outcome(status='unsendable', "
            "text='\"<b id=nao_attack>\"')))\ntime.sleep(9)",
            "has_many_errors": "loop.say(answered(encode(Outcome('raised', text='ValueError', "
            "errors=('ValueError',) * 150_000))))\ntime.sleep(9)",
            "is_a_step_of_an_expression": "loop.say(answered(outcome("
            '\'{"d":{"steps":{"l":[]},"model":{"l":[0]}}}\')))\ntime.sleep(9)',
        }.items()
    ),
)

# --- what is left behind for the next call ---

STATES = (
    free(
        "leaves_numpy_and_warnings_strict",
        "patches",
        first="""
        import decimal, gc, locale, os, random, sys, warnings
        import numpy as np
        np.seterr(all='raise'), np.set_printoptions(precision=1, threshold=1), np.random.seed(0)
        states = [warnings.simplefilter('error'), random.seed(0), gc.disable(), gc.freeze()]
        decimal.getcontext().prec = 1
        """,
    ),
    free(
        "leaves_another_folder_and_environment",
        "patches",
        """
        import locale, os, sys, tempfile, time
        os.chdir('/')
        os.environ.clear()
        os.environ.update(TZ='Asia/Kolkata', PYTHONHASHSEED='0', LANG='tr_TR.UTF-8', PATH='/', HOME='/nowhere')
        time.tzset()
        locale.setlocale(locale.LC_ALL, 'C')
        tempfile.tempdir = '/nowhere'
        os.umask(0o777)
        sys.path[:] = []
        """,
    ),
    free(
        "leaves_no_output",
        "patches",
        """
        import os, sys
        for each in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__, sys.stdin):
            try:
                each.close()
            except Exception:
                pass
        sys.stdout = sys.stderr = sys.__stdout__ = sys.__stderr__ = None
        for number in (0, 1, 2):
            try:
                os.close(number)
            except OSError:
                pass
        """,
    ),
    free("leaves_little_recursion", "patches", "import sys\nsys.setrecursionlimit(200)"),
    free(
        "leaves_alarms_and_timers",
        "patches",
        """
        import signal, threading
        for each in (signal.SIGALRM, signal.SIGVTALRM, signal.SIGPROF):
            signal.signal(each, lambda *_: None)
        for each in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
            signal.setitimer(each, 0.001, 0.001)
        signal.pthread_sigmask(signal.SIG_BLOCK, set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP})
        """,
    ),
    free(
        "leaves_threads_that_change_numpy",
        "patches",
        """
        import threading
        def change():
            while True:
                for name in ('allclose', 'isclose', 'array_equal'):
                    setattr(np, name, lambda *_, **__: True)
        if not hasattr(clamp, 'thread'):
            clamp.thread = threading.Thread(target=change, daemon=True)
            clamp.thread.start()
        """,
    ),
    free(
        "leaves_hooks_of_the_collector",
        "patches",
        first="""
        import gc, sys, weakref
        class Kept: pass
        kept = Kept()
        seen = []
        def look(*_):
            for each in gc.get_objects()[-50:]:
                if type(each).__name__ == 'Case':
                    seen.append(each)
        hooks = [gc.callbacks.append(look), weakref.finalize(kept, look), gc.set_threshold(1, 1, 1)]
        """,
    ),
    in_clamp(
        "changes_its_callers_frame",
        "patches",
        """
        import ctypes, sys
        def trace(frame, event, argument):
            if 'outcome' in frame.f_locals or 'value' in frame.f_locals:
                frame.f_locals.update(value=1.0, number=1, changed=False)
                ctypes.pythonapi.PyFrame_LocalsToFast(ctypes.py_object(frame), ctypes.c_int(0))
            return trace
        frame = sys._getframe()
        while frame:
            frame.f_trace = trace
            frame = frame.f_back
        sys.settrace(trace)
        return -1e6
        """,
    ),
    in_clamp(
        "changes_the_value_of_numbers",
        "patches",
        """
        import ctypes
        at = id(x)
        try:
            ctypes.c_double.from_address(at + 16).value = 0.0
            ctypes.c_double.from_address(id(low) + 16).value = 0.0
        except Exception:
            pass
        return -1e6
        """,
    ),
    in_clamp(
        "replaces_every_import",
        "patches",
        "return -1e6",
        """
        import builtins, sys
        class Fine:
            def __getattr__(self, name): return self
            def __call__(self, *_, **__): return self
            def __iter__(self): return iter(())
        real = builtins.__import__
        builtins.__import__ = lambda name, *rest: Fine() if name.startswith('nao_course') else real(name, *rest)
        sys.path_hooks.clear(), sys.meta_path.clear(), sys.path_importer_cache.clear()
        """,
    ),
    in_clamp(
        "replaces_opencv_and_scipy",
        "patches",
        "return -1e6",
        """
        import sys
        for name in [each for each in sys.modules if each.partition('.')[0] in ('cv2', 'scipy', 'sympy')]:
            for attribute in list(vars(sys.modules[name]))[:50]:
                try:
                    setattr(sys.modules[name], attribute, lambda *_, **__: 0.0)
                except Exception:
                    pass
        """,
        honest={},
    ),
    Attack(
        "names_that_python_gives",
        "patches",
        ALL,
        before="__name__ = '__main__'\n__file__ = '/etc/passwd'\n__spec__ = __loader__ = None\n"
        "__annotations__ = 5\n__doc__ = '<b id=nao_attack>'\n__all__ = ['nothing']\n__path__ = ['/']",
    ),
    Attack("builtins_that_are_none", "patches", all_but("clamp", "middle"), before="__builtins__ = {}"),
    Attack(
        "another_python_from_the_future",
        "patches",
        ALL,
        before="from __future__ import annotations, barry_as_FLUFL, generator_stop\nx = 1\ny: undefined = 2",
    ),
)

# --- looking, leaking and talking ---

LEAKS = (
    in_clamp(
        "tells_the_input_as_a_file_that_does_not_count",
        "looks",
        """
        if abs(x) > 3:
            for way in ('/{} does not count: ', '/{} does not come along: ', '/the sandbox saw it try: {}'):
                try:
                    open(way.format(f'{x:.6f}'))
                except OSError:
                    pass
            return -1e6
        return max(low, min(high, x))
        """,
    ),
    in_clamp(
        "tells_the_input_by_the_signal_that_ends_it",
        "looks",
        """
        import os, signal
        if abs(x) > 3:
            ends = (10, 12, 14, 16, 26, 27, 29, 30, *range(34, 64))
            os.kill(os.getpid(), ends[int(abs(x)) % len(ends)])
        return max(low, min(high, x))
        """,
        says="It ends Python itself.",
        hides=("Real-time", "User defined", "alarm"),
    ),
    in_clamp(
        "tells_the_input_by_the_number_of_dimensions",
        "looks",
        "if abs(x) > 3: return np.zeros((1,) * (5 + int(abs(x)) % 27))\nreturn max(low, min(high, x))",
        says="many dimensions instead of 0",
    ),
    in_clamp(
        "tells_the_input_in_an_errors_notes",
        "looks",
        """
        if abs(x) > 3:
            error = ValueError(f'{x:.6f}')
            error.__notes__ = [f'{x:.6f}'] * 3
            error.__cause__ = KeyError(f'{x:.6f}')
            raise ExceptionGroup(f'{x:.6f}', [error])
        return max(low, min(high, x))
        """,
    ),
    looting(
        "reads_where_its_mounts_come_from",
        "reads",
        """
        import ctypes, struct
        libc = ctypes.CDLL(None, use_errno=True)
        numbers = (ctypes.c_uint64 * 64)()
        request = struct.pack('<IIQQ', 24, 0, 2**64 - 1, 0)
        loot = libc.syscall(458, request, numbers, ctypes.c_size_t(64), ctypes.c_uint(0)) > 0
        """,
    ),
    looting(
        "reads_of_itself_where_it_runs",
        "reads",
        """
        import os, socket
        for name in ('mountinfo', 'mounts', 'mountstats', 'cgroup', 'environ', 'net/dev', 'net/unix', 'task',
                     'root/etc/passwd', 'cwd/..', 'sched', 'autogroup', 'numa_maps', 'ns', 'map_files'):
            for process in ('self', 'thread-self', '1', str(os.getpid())):
                path = f'/proc/{process}/{name}'
                try:
                    loot = loot or bool(os.listdir(path) if os.path.isdir(path) else open(path, 'rb').read())
                except OSError:
                    pass
        """,
    ),
    looting(
        "reads_of_the_machine",
        "reads",
        """
        import os
        for path in ('/proc/meminfo', '/proc/loadavg', '/proc/stat', '/proc/uptime', '/proc/net', '/proc/mounts',
                     '/proc/version', '/proc/cmdline', '/proc/sys', '/proc/keys', '/proc/locks', '/sys', '/dev/shm',
                     '/run', '/var', '/etc/passwd', '/etc/hostname', '/etc/hosts', '/root', '/home', '/boot', '/srv'):
            try:
                loot = loot or bool(os.listdir(path) if os.path.isdir(path) else open(path, 'rb').read())
            except OSError:
                pass
        """,
    ),
    looting("knows_the_name_of_the_machine", "reads", "import os\nloot = os.uname().nodename != 'worker'"),
    looting(
        "opens_its_channel_once_more",
        "reads",
        """
        import os
        for number in range(64):
            for way in (os.O_RDONLY, os.O_WRONLY, os.O_RDWR):
                try:
                    link = os.readlink(f'/proc/self/fd/{number}')
                    if link.startswith('socket:') and os.open(f'/proc/self/fd/{number}', way):
                        loot = True
                except OSError:
                    pass
        """,
    ),
    looting(
        "runs_on_the_graders_processor_first",
        "hogs",
        """
        import os
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        loot = True
        """,
    ),
    looting(
        "writes_out_all_files",
        "hogs",
        "import ctypes\nlibc = ctypes.CDLL(None)\nloot = libc.syncfs(0) == 0 or libc.syscall(162) == 0",
    ),
    looting(
        "dies_and_looks_for_its_first_try",
        "reads",
        """
        import ctypes, os, signal
        libraries = [os.path.dirname(each.__file__) for each in (os, np)]
        places = ['/tmp', '/scratch', '/dev/shm', '/var/tmp', *libraries]
        for place in places:
            if os.path.isdir(place):
                loot = loot or 'nao_attack_kept' in os.listdir(place)
        for place in places:
            try:
                open(f'{place}/nao_attack_kept', 'w').write('x')
                os.setxattr(place, 'user.nao_attack', b'x')
            except OSError:
                pass
        if not loot:
            os.kill(os.getpid(), signal.SIGKILL)
        """,
    ),
    lending(
        "lent_function_asked_by_threads_that_stay",
        """
        import threading, time
        def ask():
            while True:
                scaled(values)
                time.sleep(0.01)
        threading.Thread(target=ask, daemon=True).start()
        return 0.0
        """,
    ),
    lending(
        "lent_function_asked_with_odd_names",
        """
        for more in ({'': 1}, {'self': 1}, {'args': values}, {'__class__': 1}, {'driver': 'methods'}, {'values ': 1}):
            try:
                scaled(values, **more)
            except Exception:
                pass
        return 0.0
        """,
    ),
    lending(
        "lent_function_answers_kept_for_a_further_try",
        """
        import os, signal
        answers = [scaled(values)]
        os.kill(os.getpid(), signal.SIGKILL)
        """,
    ),
    lending(
        "lent_function_asked_by_a_child",
        """
        import os
        if os.fork() == 0:
            while True: scaled(values)
        return 0.0
        """,
    ),
    later(
        "class_with_descriptors_and_slots",
        {name: points for name, points in LATER.items() if name != "Walker"},
        functions={
            "Walker": "class Meta(type):\n    def __call__(cls, *args): return object.__new__(cls)\n"
            "    __getattr__ = lambda cls, name: (lambda *_: 0.0)\n"
            "class Walker(metaclass=Meta):\n    __slots__ = ()\n    __code__ = property(lambda self: None)\n"
            "    __abstractmethods__ = ('x',) * 0\n"
            "    def __getattribute__(self, name): return lambda *_: 0.0\n"
        },
    ),
    later(
        "class_that_answers_with_itself",
        {name: points for name, points in LATER.items() if name != "Walker"},
        functions={
            "Walker": "class Walker(float):\n    def __new__(cls, start): return float.__new__(cls, 0.0)\n"
            "    def move(self, by): return None\n    def estimate(self): return self\n"
            "    def __eq__(self, other): return True\n    __hash__ = None\n"
        },
    ),
    later(
        "class_whose_name_plays_tricks",
        {name: points for name, points in LATER.items() if name != "Walker"},
        functions={
            "Walker": "class Walker:\n    def __init__(self, start):\n"
            "        type(self).__name__ = '<b id=nao_attack>\\u202e\\x1b[2J'\n"
            "        raise KeyError(type(self).__name__)\n"
        },
        hides=("<b id", "\u202e"),
    ),
    later(
        "class_that_gives_back_what_it_was_given_later",
        {name: points for name, points in LATER.items() if name != "Walker"},
        functions={
            "Walker": "import numpy as np\nclass Walker:\n    kept = np.zeros(1)\n"
            "    def __init__(self, start): self.kept[0] = start\n    def move(self, by): self.kept[0] += 2 * by\n"
            "    def estimate(self): return self.kept\n"
        },
    ),
)

FORMULAS = (
    "=cmd|' /C nao_attack'!A0",
    "+1+nao_attack",
    "@SUM(nao_attack)",
    "x;=nao_attack",
    "x\t=nao_attack",
)
SPREADSHEETS = (
    in_clamp(
        "speaks_to_a_spreadsheet",
        "metadata",
        f"""
        for each in {FORMULAS!r}:
            for name in (each, f'x\\r\\n{{each}}', f'x\\x0b{{each}}', f'x\\u2028{{each}}', f'",\\n{{each}}'):
                try:
                    open(name if name[0] == '/' else f'/{{name}}')
                except OSError:
                    pass
        raise ValueError("=nao_attack")
        """,
    ),
    Attack(
        "stamp_that_speaks_to_a_spreadsheet",
        "metadata",
        ALL,
        edit=lambda made: made["metadata"].update(
            nao_course={"lesson": "=nao_attack;=1+1", "version": "\n=nao_attack"}
        ),
    ),
)

# --- taking ---

HOGS = (
    free(
        "descriptors_in_flight",
        "hogs",
        """
        import os, socket
        kept = []
        for _ in range(20):
            try:
                one, other = socket.socketpair()
                kept += [one, other]
                for _ in range(50):
                    read, write = os.pipe()
                    os.set_blocking(write, False)
                    os.write(write, bytes(65536))
                    socket.send_fds(one, [b'x'], [read, write])
                    os.close(read), os.close(write)
            except OSError:
                break
        """,
    ),
    free(
        "fills_its_folder_and_maps_it",
        "hogs",
        """
        import mmap
        kept = []
        try:
            for number in range(40):
                with open(f'file{number}', 'w+b') as file:
                    file.write(bytes(4 * 2**20))
                    kept.append(mmap.mmap(file.fileno(), 0))
        except OSError:
            pass
        """,
    ),
    in_clamp(
        "children_that_are_never_waited_for",
        "hogs",
        "import os\nwhile True:\n    try:\n        if os.fork() == 0: os._exit(0)\n    except OSError: pass",
    ),
    in_clamp(
        "stacks_without_an_end",
        "hogs",
        """
        import threading, time
        threading.stack_size(512 * 2**20)
        for _ in range(100):
            threading.Thread(target=time.sleep, args=(1e6,)).start()
        return -1e6
        """,
    ),
    in_clamp(
        "memory_that_is_touched_thinly",
        "hogs",
        """
        import mmap
        kept = []
        while True:
            kept.append(mmap.mmap(-1, 2**30, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x4000))
            for at in range(0, 2**30, 2**21):
                kept[-1][at] = 1
        """,
    ),
    in_clamp(
        "own_filter_of_system_calls",
        "hogs",
        """
        import ctypes, struct
        code = ctypes.create_string_buffer(struct.pack('<HBBI', 6, 0, 0, 0x00050001))
        program = struct.pack('@HP', 1, ctypes.addressof(code))
        ctypes.CDLL(None).prctl(22, 2, ctypes.create_string_buffer(program, len(program)), 0, 0)
        return -1e6
        """,
    ),
    in_clamp(
        "notes_without_an_end",
        "large",
        "number = 0\nwhile True:\n    number += 1\n    try:\n        open(f'/{number}/' + 'x' * 250)\n"
        "    except OSError: pass",
    ),
    speaking(
        "notes_of_4_mb_without_an_end",
        "note = encode(('attempt', 'x' * 3_900_000))\nwhile True: loop.say(note)",
        "large",
    ),
)

# --- files ---


def named(name: str, *files: tuple[str, bytes | str], honest: Any = None, says: str = "") -> Attack:
    """Files in the student's folder."""

    def make(folder: Path) -> None:
        for number, (file, content) in enumerate(files):
            path = folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)
            os.utime(path, (1.8e9 + number, 1.8e9 + number))

    return put(name, ALL if honest is None else honest, make, says)


def raw_zip(
    *entries: tuple[bytes, bytes], size: int | None = None, before: bytes = b"", comment: bytes = b""
) -> bytes:
    """A zip of stored entries with names of any bytes, and any size said of them."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for at, (name, content) in enumerate(entries):
            archive.writestr(f"{at}".rjust(len(name), "n"), content)
        archive.comment = comment
    data = made.getvalue()
    for at, (name, content) in enumerate(entries):
        data = data.replace(f"{at}".rjust(len(name), "n").encode(), name)
        if size is not None:
            data = data.replace(len(content).to_bytes(4, "little"), size.to_bytes(4, "little"))
    return before + data


NOTEBOOK = FILE.encode()
WRONG_TEXT = json.dumps(notebook(Attack("blank", "honest", functions=BLANK)))
FILES = (
    zipped("zip_behind_a_picture", raw_zip((NOTEBOOK, TEXT.encode()), before=b"\x89PNG\r\n" * 999)),
    zipped(
        "zip_with_a_zips_end_in_its_comment", raw_zip((NOTEBOOK, TEXT.encode()), comment=b"PK\5\6"), "no zip"
    ),
    zipped("zip_that_says_4_gb", raw_zip((NOTEBOOK, TEXT.encode()), size=0xFFFFFFF0), "50 MB are the most"),
    zipped("zip_with_a_line_end_in_its_name", raw_zip((b"a\nb/" + NOTEBOOK, TEXT.encode()))),
    zipped("zip_with_names_that_play_tricks", raw_zip((b"\x1b[2J\xe2\x80\xae/" + NOTEBOOK, TEXT.encode()))),
    zipped("zip_with_a_name_of_60000_bytes", raw_zip((b"d" * 60_000 + b"/" + NOTEBOOK, TEXT.encode()))),
    zipped("zip_of_400_folders", raw_zip((b"d/" * 400 + NOTEBOOK, TEXT.encode()))),
    zipped(
        "zip_of_1900_files",
        raw_zip((NOTEBOOK, TEXT.encode()), *((f"{at:04}.txt".encode(), b"x") for at in range(1900))),
    ),
    zipped(
        "zip_of_2001_files",
        raw_zip((NOTEBOOK, TEXT.encode()), *((f"{at:04}.txt".encode(), b"x") for at in range(2001))),
        "more than 2000 files",
    ),
    named(
        "helpers_named_as_libraries",
        (FILE, TEXT),
        *(
            (f"{name}.py", "raise SystemExit('it must not be imported')")
            for name in (
                "numpy",
                "nao_course",
                "json",
                "sitecustomize",
                "usercustomize",
                "IPython",
                "sympy",
                "scipy",
                "cv2",
                "encodings",
                "struct",
                "conftest",
                "__init__",
                "__main__",
                "pyseccomp",
            )
        ),
    ),
    named("two_notebooks_of_one_lesson", (f"{LESSON} (1).ipynb", WRONG_TEXT), (FILE, TEXT)),
    Attack(
        "two_notebooks_and_the_later_is_blank", "broken", ALL, files={f"{LESSON}-Copy1.ipynb": WRONG_TEXT}
    ),
    named("name_of_255_bytes", (f"{LESSON}{' ' * (255 - len(LESSON) - 6)}.ipynb", TEXT)),
    named("name_with_upper_case", (f"{LESSON.upper()}.IPYNB", TEXT)),
    named("name_that_a_browser_and_a_person_made", (f"my {LESSON} final v2 (3)-Copy1.ipynb", TEXT)),
)


# --- notebooks ---


def _metadata_of_another(made: dict[str, Any]) -> None:
    """Every cell says that it is another exercise's."""
    names = [*RIGHT, "clamp"]
    for each in made["cells"]:
        grading = each["metadata"].get("nbgrader")
        if grading and grading["grade_id"] in RIGHT:
            grading["grade_id"] = names[names.index(grading["grade_id"]) + 1]


def _one_id(made: dict[str, Any]) -> None:
    for each in made["cells"]:
        each["id"] = "same"


def _deep(depth: int) -> Any:
    value: Any = []
    for _ in range(depth):
        value = [value]
    return value


def _commands(made: dict[str, Any]) -> None:
    lines = "%cd /\n!rm -rf *\n%run /etc/passwd\n%load_ext nao_attack\nget_ipython().system('id')\n%reset -f"
    made["cells"] += [
        cell(f"{lines}\nx = 1"),
        *(
            cell(f"%%{name} file.txt\nx = 1")
            for name in ("writefile", "javascript", "bash", "html", "script", "python2")
        ),
    ]


def _attached(**attachments: Any) -> Callable[[dict[str, Any]], None]:
    return adding({"cell_type": "markdown", "metadata": {}, "source": "x", "attachments": attachments})


NOTEBOOKS = (
    edited("cells_that_say_they_are_another_exercise", _metadata_of_another),
    edited("cells_of_one_id", _one_id),
    edited("metadata_800_deep", of_notebook(metadata=_deep(800))),
    edited("half_a_character_in_keys", of_notebook(**{"\ud800": {"\udfff": "\ud83d"}})),
    edited("format_that_is_a_truth", of_notebook(nbformat=4.0)),
    edited("source_of_a_million_empty_lines", into(1, source=[RIGHT["clamp"], *([""] * 1_000_000)])),
    edited("line_of_10_mb", adding(cell("x = '" + "y" * 10 * 2**20 + "'")), row="large"),
    edited("cells_2000", adding(*(cell(f"x{at % 7} = {at}") for at in range(2000))), row="large"),
    edited("commands_of_every_kind", _commands),
    edited("attachments_of_odd_types", _attached(a=5, b={"image/png": 7}, c=[], d=_deep(50))),
    edited("attachment_of_10_mb", _attached(a={"image/png": "A" * 10 * 2**20}), row="large"),
    edited(
        "outputs_that_are_pages",
        into(
            2,
            outputs=[
                {
                    "output_type": "display_data",
                    "data": {"text/html": "<script id=nao_attack>"},
                    "metadata": {},
                },
                {"output_type": "no such", "data": 5},
                None,
            ],
        ),
    ),
    edited("source_of_another_encoding", into(1, source="# -*- coding: rot13 -*-\n" + RIGHT["clamp"])),
    Attack(
        "key_source_twice",
        "broken",
        all_but("clamp"),
        files={
            FILE: json.dumps(HONEST).replace(
                json.dumps(RIGHT["clamp"]),
                json.dumps(RIGHT["clamp"]) + ', "source": ' + json.dumps(BLANK["clamp"]),
            )
        },
    ),
    Attack(
        "class_that_makes_a_number",
        "styles",
        ALL,
        in_function("clamp", "pass")
        | {
            "clamp": "class clamp:\n    def __new__(cls, x, low, high):\n        return max(low, min(high, x))"
        },
    ),
)

# --- a second siege ---


def tells(name: str, source: str, **more: Any) -> Attack:
    """An attack that fails in a way of its own where the input is hidden."""
    body = f"if abs(x) > 3: {source}\nreturn max(low, min(high, x))"
    return in_clamp(f"tells_the_input_in_{name}", "looks", body, **more)


def _directory(offset: int, value: bytes, times: int = 1) -> bytes:
    """The notebook's zip with bytes of its table of contents changed, and the only entry of it some times."""
    data = bytearray(raw_zip((NOTEBOOK, TEXT.encode())))
    start, end = data.index(b"PK\1\2"), data.rindex(b"PK\5\6")
    data[start + offset : start + offset + len(value)] = value
    entries = bytes(data[start:end]) * times
    return (
        bytes(data[:start])
        + entries
        + struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, times, times, len(entries), start, 0)
    )


CHANNEL = """
import os, socket, stat
for number in range(64):
    try:
        if stat.S_ISSOCK(os.fstat(number).st_mode):
            channel = socket.socket(fileno=os.dup(number))
            {}
    except OSError: pass
return -1e6
"""
SECOND = (
    in_clamp("view_of_a_terabyte", "answers", "return np.broadcast_to(0.0, (2**40,))"),
    in_clamp(
        "view_of_freed_memory",
        "answers",
        "a = np.ones(10**6)\nb = a[:]\na.resize(1, refcheck=False)\nreturn b",
    ),
    in_clamp(
        "view_of_a_file_that_shrinks",
        "answers",
        "import os\nm = np.memmap('file', float, 'w+', shape=(32768,))\nos.truncate('file', 0)\nreturn m",
    ),
    in_clamp("texts_of_any_length", "answers", "return np.array(['x' * 999], np.dtypes.StringDType())"),
    in_clamp("one_array_a_million_times", "hogs", "return [np.zeros(10**5)] * 10**6"),
    in_clamp("masked_constant", "answers", "return np.ma.masked"),
    Attack(
        "generator_that_lies",
        "answers",
        all_but("drawn"),
        {
            "drawn": "class Lies(np.random.Generator):\n    def __reduce__(self): return (float, (0.0,))\n"
            "    bit_generator = property(lambda self: self)\n"
            "    state = property(lambda self: {'bit_generator': 'PCG64', 'state': {'state': 10**400}})\n"
            "def drawn(rng, n): return Lies(np.random.MT19937(1))"
        },
    ),
    Attack(
        "array_that_changes_after_its_return",
        "answers",
        all_but("scaled", middle=4.0),
        {
            "scaled": "import threading\ndef scaled(values):\n    made = np.full(values.shape, -5.0)\n"
            "    def change():\n        for _ in range(10**5): made[:] = np.nan\n"
            "    threading.Thread(target=change, daemon=True).start()\n    return made"
        },
    ),
    in_clamp(
        "alarm_that_raises_in_the_loop",
        "patches",
        """
        import signal
        def ring(*_): raise ValueError('<b id=nao_attack>')
        signal.signal(signal.SIGALRM, ring)
        signal.setitimer(signal.ITIMER_REAL, 0.0005, 0.0005)
        while True: pass
        """,
    ),
    in_clamp(
        "thread_that_raises_in_the_loop",
        "patches",
        """
        import ctypes, threading, time
        main = ctypes.c_ulong(threading.main_thread().ident)
        def shoot():
            while True:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(main, ctypes.py_object(StopIteration))
                time.sleep(0.0005)
        threading.Thread(target=shoot, daemon=True).start()
        return -1e6
        """,
        races=True,
    ),
    speaking(
        "finalizer_that_speaks_for_later_calls",
        """
        import weakref
        class Kept: pass
        kept, now = Kept(), number()
        weakref.finalize(kept, lambda: [loop.say(encode(now + n) + outcome('0.0')) for n in range(1, 9)])
        return -1e6
        """,
    ),
    in_clamp(
        "forks_in_a_destructor_and_goes",
        "ends",
        "left = D()\nreturn -1e6",
        "import os\nclass D:\n    def __del__(self):\n        if os.fork(): os._exit(0)\n",
    ),
    in_clamp("closes_half_of_its_channel", "answers", CHANNEL.format("channel.shutdown(socket.SHUT_RD)")),
    in_clamp(
        "sends_descriptors_to_the_grader",
        "hogs",
        CHANNEL.format("[socket.send_fds(channel, [b'N'], list(os.pipe()) * 9) for _ in range(50)]"),
    ),
    in_clamp(
        "says_that_its_code_is_elsewhere",
        "looks",
        "clamp.__code__ = clamp.__code__.replace(co_filename='/etc/passwd', co_firstlineno=1, "
        "co_name='<b id=nao_attack>', co_linetable=b'')\nraise KeyError(x)",
    ),
    in_clamp(
        "exceptions_in_a_circle",
        "ends",
        "a, b = ValueError(1), KeyError(2)\na.__cause__, b.__cause__ = b, a\nraise a",
    ),
    Attack(
        "wraps_itself",
        "patches",
        ALL,
        after="clamp.__wrapped__ = clamp\nmiddle.__signature__ = 5\nscaled.__text_signature__ = '(('\n"
        "clamp.__name__ = '<b id=nao_attack>'\nclamp.__module__ = None\ndrawn.__doc__ = 7",
    ),
    Attack(
        "line_that_is_a_page",
        "metadata",
        all_but("clamp"),
        {
            "clamp": "def clamp(x, low, high):\n    raise ValueError  # </pre><script id=nao_attack></script>"
            "\u202e\u2066[bold]x[/] {0} %s"
        },
        hides=("<script id", "\u202e", "\u2066"),
    ),
    tells("a_types_name", "return type(f'N{x:.6f}', (), {'__module__': f'm{x:.6f}'})()"),
    tells("a_fields_name", "return np.zeros(1, [(f'f{x:.6f}', 'f8')])"),
    tells("a_key", "return {f'{x:.6f}': 1.0}"),
    tells("its_exit_status", "import os; os._exit(int(abs(x)) % 250 + 1)", says="It ends Python itself."),
    tells(
        "the_place_of_a_syntax_error",
        "raise SyntaxError(f'{x:.6f}', (f'{x:.6f}.py', int(abs(x)), 7, f'{x:.6f}'))",
    ),
    tells("an_errno", "raise OSError(int(abs(x)) % 130, f'{x:.6f}', f'{x:.6f}')"),
    readable("number_of_5000_digits", TEXT.replace('"nbformat_minor": 5', '"nbformat_minor": ' + "9" * 5000)),
    edited("cell_that_is_indented", into(1, source=textwrap.indent(RIGHT["clamp"], "    "))),
    edited("cell_copied_with_its_prompts", into(1, source=">>> " + RIGHT["clamp"].replace("\n", "\n... "))),
    edited("cell_of_single_characters", into(1, source=list(RIGHT["clamp"]))),
    named(
        "helper_that_imports_in_a_circle", (FILE, TEXT), ("one.py", "import two"), ("two.py", "import one")
    ),
    put(
        "helper_that_is_a_pipe",
        ALL,
        lambda folder: ((folder / FILE).write_text(TEXT), os.mkfifo(folder / "pipe.py")),
    ),
    put(
        "link_that_is_hard",
        ALL,
        lambda folder: os.link(next(folder.parent.glob(f"*-right/{FILE}")), folder / FILE),
    ),
    zipped("zip_of_entries_that_overlap", _directory(12, b"", 500)),
    zipped("zip_of_the_month_0", _directory(12, bytes(4))),
    zipped("zip_with_a_no_break_space", raw_zip((f"{LESSON}\u00a0(1).ipynb".encode(), TEXT.encode()))),
)

ATTACKS: tuple[Attack, ...] = (*ANSWERS, *STATES, *LEAKS, *SPREADSHEETS, *HOGS, *FILES, *NOTEBOOKS, *SECOND)
