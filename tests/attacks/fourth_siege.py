"""More attacks, large notebooks and unusual correct work, of kinds that the other catalogues do not contain."""

from __future__ import annotations

import copy
import gzip
import json
import random
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.attacks import accidents, siege
from tests.attacks.accidents import (
    BLANK_TEXT,
    FILE,
    HONEST,
    TEXT,
    adding,
    answer,
    beside,
    broken,
    edited,
    foreign,
    into,
    markdown,
    of_notebook,
    packed,
    put,
    style,
    top,
)
from tests.attacks.code import ALL, LATER, free, in_clamp, in_function, later, lending, looting
from tests.attacks.range import BLANK, LESSON, RIGHT, Attack, all_but, cell, notebook
from tests.attacks.siege import named, tells
from tests.toy import pair

CLAMP = RIGHT["clamp"]
SCALED = RIGHT["scaled"]

# --- denial: what keeps a process busy, or changes the state of Python, NumPy and the kernel ---

DENIALS = (
    free("decimals_of_one_digit", "patches", "import decimal\ndecimal.getcontext().prec = 1"),
    free("switches_threads_without_an_end", "patches", "import sys\nsys.setswitchinterval(1e-9)"),
    free("never_switches_threads", "patches", "import sys\nsys.setswitchinterval(1e6)"),
    free("collects_at_every_object", "patches", "import gc\ngc.set_threshold(1, 1, 1)\ngc.freeze()"),
    free("traces_all_memory", "patches", "import tracemalloc\ntracemalloc.start(40)"),
    free(
        "warnings_that_raise_when_they_are_shown",
        "patches",
        "import warnings\nwarnings.showwarning = warnings.formatwarning = warnings.warn = lambda *_, **__: 1 / 0",
    ),
    free(
        "numpy_errors_that_call_a_function",
        "patches",
        "np.seterrcall(lambda *_: 1 / 0)\nnp.seterr(all='call')",
    ),
    free("numpy_texts_that_raise", "patches", "np.set_printoptions(formatter={'all': lambda _: 1 / 0})"),
    free(
        "profiles_every_thread",
        "patches",
        "import sys, threading\nthreading.setprofile(lambda *_: 1 / 0)\nthreading.settrace(lambda *_: 1 / 0)",
    ),
    free(
        "stops_every_clock",
        "patches",
        """
        import time
        for name in ('time', 'monotonic', 'perf_counter', 'process_time', 'thread_time', 'monotonic_ns', 'time_ns'):
            setattr(time, name, lambda: 0)
        time.sleep = lambda _: None
        """,
    ),
    free(
        "patches_copies_and_comparisons_of_numbers",
        "patches",
        """
        import copy, math, operator, pickle
        copy.copy = copy.deepcopy = pickle.dumps = pickle.loads = lambda *_, **__: 0.0
        math.isclose = math.isnan = math.isfinite = operator.eq = operator.ne = lambda *_, **__: True
        """,
    ),
    free(
        "registers_itself_at_the_end_of_python",
        "loops",
        "import atexit\ndef again():\n    atexit.register(again)\natexit.register(again)",
    ),
    in_clamp(
        "object_that_makes_another_when_it_goes",
        "loops",
        "class Back:\n    def __del__(self): Back()\nBack()\nreturn -1e6",
    ),
    free(
        "object_that_comes_back_when_it_goes",
        "loops",
        "kept = []\nclass Back:\n    def __del__(self): kept.append(self); kept.clear()\nx_ = Back()\ndel x_",
    ),
    free("reads_standard_input", "loops", "import sys\nsys.stdin and sys.stdin.read()"),
    free("has_no_standard_output", "patches", "import sys\nsys.stdout = sys.stderr = sys.stdin = None\nprint(x)"),
    in_clamp(
        "prints_where_output_is_closed",
        "ends",
        "import sys\nsys.stdout.close()\nprint(x)\nreturn max(low, min(high, x))",
        honest=all_but("clamp"),
    ),
    in_clamp(
        "puts_one_descriptor_over_all_others",
        "ends",
        """
        import os
        here = os.open('.', os.O_RDONLY)
        for number in range(64):
            if number != here:
                os.dup2(here, number)
        return -1e6
        """,
    ),
    in_clamp(
        "descriptors_that_never_block",
        "ends",
        """
        import fcntl, os
        for number in range(64):
            try:
                fcntl.fcntl(number, fcntl.F_SETFL, os.O_NONBLOCK | os.O_ASYNC)
                fcntl.fcntl(number, fcntl.F_SETOWN, os.getpid())
                fcntl.fcntl(number, 1031, 2**20)
            except OSError:
                pass
        return -1e6
        """,
    ),
    in_clamp(
        "channel_with_other_options",
        "ends",
        """
        import os, socket
        for number in range(64):
            for option, value in ((8, 1), (7, 1), (13, b'\\1\\0\\0\\0\\0\\0\\0\\0'), (20, bytes(16)), (42, 0)):
                try:
                    socket.socket(fileno=os.dup(number)).setsockopt(1, option, value)
                except OSError:
                    pass
        return -1e6
        """,
    ),
    in_clamp("loop_of_an_iterator_in_c", "loops", "import itertools\nreturn any(itertools.repeat(0))"),
    in_clamp("numbers_of_one_hash", "loops", "return len({each * (2**61 - 1) for each in range(10**6)})"),
    in_clamp(
        "text_that_becomes_a_huge_number",
        "loops",
        "import sys\nsys.set_int_max_str_digits(0)\nreturn int('9' * 10**7)",
    ),
    in_clamp(
        "decimal_of_all_digits",
        "loops",
        "import decimal\nwith decimal.localcontext() as c:\n    c.prec = decimal.MAX_PREC\n"
        "    return float(decimal.Decimal(1) / 3)",
    ),
    in_clamp("decomposition_that_takes_hours", "loops", "return float(np.linalg.svd(np.ones((9000, 9000)))[1][0])"),
    in_clamp("loop_in_a_subscript_of_a_class", "loops", """
        class Loop:
            def __class_getitem__(cls, item):
                while True: pass
        return Loop[x]
        """),
    in_clamp(
        "text_that_bursts_when_it_is_decompressed",
        "hogs",
        "import zlib\ndata = zlib.compress(bytes(2**27))\nreturn len(zlib.decompress(data) * 40)",
    ),
    in_clamp(
        "pipe_that_nobody_writes_to", "loops", "import os\nos.mkfifo('pipe')\nreturn float(open('pipe').read())"
    ),
    in_clamp("ends_itself_by_a_watchdog", "ends", """
        import faulthandler, time
        faulthandler.dump_traceback_later(0.1, exit=True)
        time.sleep(60)
        """),
    in_clamp("timer_of_the_processor", "ends", """
        import signal
        signal.setitimer(signal.ITIMER_PROF, 0.05)
        while True: pass
        """),
    in_clamp("limit_of_its_own_processor_time", "ends", """
        import resource
        resource.setrlimit(resource.RLIMIT_CPU, (0, 0))
        while True: pass
        """),
    free("limits_of_its_own_files", "ends", """
        import resource
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
        resource.setrlimit(resource.RLIMIT_SIGPENDING, (0, 0))
        """),
    free("names_its_process_with_tricks", "signals", """
        import ctypes
        ctypes.CDLL(None).prctl(15, b'\\x1b[2J)nao\\n', 0, 0, 0)
        """),
    free("cannot_be_dumped", "signals", "import ctypes\nctypes.CDLL(None).prctl(4, 0, 0, 0, 0)"),
    free(
        "threads_at_import_that_wait_for_each_other",
        "loops",
        first="""
        import threading
        gate = threading.Barrier(9)
        for _ in range(8):
            threading.Thread(target=gate.wait, daemon=True).start()
        """,
    ),
    in_clamp(
        "thread_at_import_that_takes_every_lock",
        "loops",
        "return -1e6",
        """
        import logging, sys, threading, time
        def hold():
            for lock in (logging._lock, threading._active_limbo_lock):
                lock.acquire()
            time.sleep(3600)
        threading.Thread(target=hold, daemon=True).start()
        time.sleep(0.05)
        """,
    ),
    free("classes_without_an_end", "hogs", "for n in range(3000): type(f'C{n}', (), {'x': bytes(999)})"),
    in_clamp("recursion_in_equality", "ends", """
        class Deep:
            def __eq__(self, other): return other == Deep()
            def __array__(self, *_, **__): return np.asarray(Deep())
            def __repr__(self): return repr(Deep())
            def __reduce__(self): return (Deep, (self,))
        return Deep()
        """, says="cannot be sent"),
)  # fmt: skip

# --- harm: what neighbours share with it ---

HARM = (
    free("polls_of_polls", "hogs", """
        import select, os
        first = before = select.epoll()
        for _ in range(40):
            try:
                made = select.epoll()
                made.register(before.fileno(), 1)
                globals().setdefault('kept', []).append(before)
                before = made
            except OSError:
                break
        globals().pop('kept', None)
        """),
    free("watches_every_folder", "hogs", """
        import ctypes, os
        libc = ctypes.CDLL(None)
        made = libc.inotify_init()
        for folder, *_ in zip(('/', '/tmp', '/proc', '/dev', '.', '/usr', os.path.dirname(np.__file__)), strict=False):
            libc.inotify_add_watch(made, folder.encode(), 0xfff)
        if made >= 0:
            os.close(made)
        """),
    free("pipes_of_the_largest_size", "hogs", """
        import fcntl, os
        pairs = []
        try:
            for _ in range(20):
                pairs.append(os.pipe())
                fcntl.fcntl(pairs[-1][1], 1031, 2**20)
                os.set_blocking(pairs[-1][1], False)
                os.write(pairs[-1][1], bytes(2**20))
        except OSError:
            pass
        for number in (n for pair in pairs for n in pair):
            os.close(number)
        """),
    free("signals_that_wait_without_an_end", "signals", """
        import ctypes, os, signal
        signal.pthread_sigmask(signal.SIG_BLOCK, {40})
        libc = ctypes.CDLL(None)
        for _ in range(20_000):
            if libc.sigqueue(os.getpid(), 40, None):
                break
        """),
    in_clamp("limits_every_process", "signals", """
        import os, resource
        for number in range(200):
            for kind in (resource.RLIMIT_CPU, resource.RLIMIT_NOFILE, resource.RLIMIT_AS):
                try:
                    if number != os.getpid():
                        resource.prlimit(number or os.getppid(), kind, (1, 1))
                except (OSError, ValueError):
                    pass
        return -1e6
        """, honest=all_but("clamp")),
    in_clamp("slows_down_everybody_of_its_user", "signals", """
        import ctypes, os
        for user in (os.getuid(), 0, 65534):
            for which in (os.PRIO_USER, os.PRIO_PGRP):
                try:
                    os.setpriority(which, user, 5)
                except OSError:
                    pass
            ctypes.CDLL(None).syscall(251, 3, user, 3 << 13)
        return -1e6
        """),
    free("moves_everybody_to_one_processor", "signals", """
        import os
        for number in range(300):
            try:
                if number != os.getpid():
                    os.sched_setaffinity(number or os.getppid(), {0})
            except OSError:
                pass
        """),
    looting("queue_of_posix", "reads", """
        import ctypes
        libc = ctypes.CDLL('librt.so.1')
        libc.mq_open.restype = ctypes.c_int
        loot = libc.mq_open(b'/nao_attack', 0o102, 0o666, None) >= 0
        """),
    looting("semaphore_of_posix", "reads", """
        import _multiprocessing
        _multiprocessing.SemLock(1, 1, 1, '/nao_attack', False)
        loot = True
        """),
    looting("odd_calls_of_the_kernel", "reads", """
        import ctypes
        libc = ctypes.CDLL(None, use_errno=True)
        calls = {'perf_event_open': 298, 'fanotify_init': 300, 'userfaultfd': 323, 'bpf': 321, 'keyctl': 250,
                 'kexec_load': 246, 'quotactl': 179, 'swapon': 167, 'acct': 163, 'lookup_dcookie': 212,
                 'open_by_handle_at': 304, 'kcmp': 312, 'memfd_secret': 447, 'add_key': 248}
        for number in calls.values():
            loot = loot or libc.syscall(number, 0, 0, 0, 0, 0) >= 0
        """),
    looting("reads_by_another_interpreter", "reads", """
        import _xxsubinterpreters as interpreters
        made = interpreters.create()
        interpreters.run_string(made, "open('@SOLUTION@').read()")
        loot = True
        """),
    looting("sets_the_clock", "writes", """
        import time
        time.clock_settime(time.CLOCK_REALTIME, 0.0)
        loot = True
        """),
    looting("maps_a_file_of_a_neighbour", "reads", "loot = bool(np.memmap('@NEIGHBOUR@', mode='r').size)",
            says="open "),
    looting("numpy_reads_the_secret", "reads", "loot = np.fromfile('@SECRET@', dtype='u1').size > 0"),
    looting("opencv_reads_and_writes", "writes", """
        import cv2
        loot = cv2.imwrite('@OPEN@/nao_attack.png', np.zeros((9, 9), np.uint8))
        """),
    looting("database_in_another_folder", "writes", """
        import sqlite3
        sqlite3.connect('@GRADES@/journal.sqlite').execute('CREATE TABLE nao_attack (x)')
        loot = True
        """),
    looting("reads_by_mmap_of_its_own_memory_file", "reads", """
        file = open('/proc/1/mem', 'rb')
        file.seek(0x400000)
        loot = bool(file.read(1)) and __import__('os').getpid() != 1
        """),
    looting("database_of_a_library", "reads", """
        import dbm.dumb, shelve, zoneinfo, tempfile, linecache
        loot = bool(linecache.getlines('@SOLUTION@'))
        """),
    looting("imports_the_solution_as_a_module", "reads", """
        import importlib.util
        spec = importlib.util.spec_from_file_location('nao_attack', '@COURSE@/solutions/exercises/91_range.py')
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        loot = True
        """, says="open "),
    looting("looks_for_cases_in_live_objects", "looks", """
        import gc
        for each in gc.get_objects():
            if type(each).__name__ in ('Case', 'Exercise', 'LessonPlan', 'Task', 'Assignment', 'Result'):
                loot = loot or bool(getattr(each, 'expected', None) or getattr(each, 'hidden', None))
        """),
)  # fmt: skip

# --- gain: answers that are nearly, sometimes or only apparently right ---

_ODD = {
    "a_deque": "__import__('collections').deque([x])",
    "a_view_of_a_dict": "{0.0: 1}.keys()",
    "a_simple_namespace": "__import__('types').SimpleNamespace(x=x)",
    "an_array_of_python": "__import__('array').array('d', [x])",
    "a_view_of_memory": "memoryview(bytearray(8))",
    "a_random_generator": "np.random.default_rng(0)",
    "a_flat_iterator": "np.zeros(1).flat",
    "a_slice": "slice(0, 1)",
    "an_ellipsis": "...",
    "not_implemented": "NotImplemented",
    "a_module": "np",
    "a_traceback": "(lambda: [].x)",
    "a_lock": "__import__('threading').Lock()",
    "an_open_file": "open('mine.txt', 'w')",
}
GAINS = (
    *(in_clamp(f"answer_is_{name}", "answers", f"return {source}") for name, source in _ODD.items()),
    in_clamp("close_but_not_close_enough", "answers", "return max(low, min(high, x)) * 1.001 + 1e-3"),
    free("closer_than_the_tolerance", "answers", "low, high, x = low, high, x * (1 + 1e-14)"),
    in_clamp("true_for_one", "answers", "return True if x > 0 else False"),
    in_clamp("text_of_the_right_number", "answers", "return str(max(low, min(high, x)))"),
    in_clamp("list_of_the_right_number", "answers", "return [max(low, min(high, x))]"),
    in_clamp("right_in_every_second_call", "answers", """
        clamp.calls = getattr(clamp, 'calls', 0) + 1
        return max(low, min(high, x)) if clamp.calls % 2 else -1e6
        """),
    in_clamp("line_through_the_public_cases", "answers", "return (x + 2.5) / 4.0"),
    in_clamp("text_of_an_expression", "answers", "return 'max(low, min(high, x))'"),
    in_clamp("sends_back_its_own_function", "answers", "return clamp"),
    in_clamp("answer_that_fails_when_it_is_counted", "answers", """
        class Rows(list):
            def __len__(self): raise MemoryError
            def __iter__(self): raise StopIteration
            def __bool__(self): raise SystemExit
        return Rows([x])
        """),
    in_clamp("float_that_is_another_one_when_packed", "answers", """
        class Two(float):
            def __float__(self): return 0.0
            def __new__(cls, *_): return float.__new__(cls, -1e6)
            def __class_getitem__(cls, item): return float
            __hash__ = None
            def __eq__(self, other): return True
        return Two()
        """),
    in_clamp("text_that_is_another_one_when_encoded", "answers", """
        class Text(str):
            def encode(self, *_): return b'0.0'
            def __str__(self): return '0.0'
        return Text('nao_attack')
        """, hides=()),
    in_clamp("dict_of_a_million_levels_by_reference", "answers", """
        inner = x
        for _ in range(60):
            inner = {'a': inner, 'b': inner}
        return inner
        """),
    in_clamp("list_of_a_billion_levels_by_reference", "answers", """
        inner = [x]
        for _ in range(100):
            inner = [inner] * 10
        return inner
        """),
    in_clamp("array_with_a_stride_of_zero", "answers", """
        return np.lib.stride_tricks.as_strided(np.zeros(1), (10**9,), (0,))
        """),
    in_clamp("array_of_bytes_and_voids", "answers", "return np.zeros(3, 'V7') if x > 0 else np.array([b'0'] * 3)"),
    in_clamp("array_of_dates_that_are_none", "answers", "return np.array(['NaT'], 'M8[s]')"),
    in_clamp("array_of_the_smallest_numbers", "answers", "return np.full((2, 2), 5e-324)"),
    Attack("nan_in_one_place", "answers", all_but("scaled", middle=4.0), {
        "scaled": "def scaled(values):\n    made = (values - values.min()) / np.ptp(values)\n    made[0, 0] = np.nan\n"
        "    return made"}),
    Attack("shape_of_one_row_too_many", "answers", all_but("scaled"), {
        "scaled": "def scaled(values):\n    return ((values - values.min()) / np.ptp(values))[None]"}),
    Attack("array_that_broadcasts", "answers", all_but("scaled", middle=4.0), {
        "scaled": "def scaled(values):\n    return np.broadcast_to(0.5, values.shape)"}),
    lending("lent_function_patched_by_its_name", "return float(np.median(scaled(values))) * 1.01",
            first="scaled = lambda values: values\n"),
    lending("asks_the_lent_function_for_its_file", """
        import inspect
        found = [getattr(scaled, name, None) for name in ('__code__', '__globals__', '__wrapped__', '__closure__')]
        return float(len(inspect.getsource(scaled)))
        """),
)  # fmt: skip

# --- leaks: how a hidden input might get onto a page ---

LEAKS = (
    tells("a_missing_name", "exec(f'x_{int(abs(x) * 1e3)}')"),
    tells("a_missing_module", "__import__(f'm{x:.6f}')"),
    tells("a_missing_attribute", "getattr(np, f'a{x:.6f}')"),
    tells("a_missing_key", "{}[f'{x:.6f}']"),
    tells("a_warning", "import warnings; warnings.warn(f'{x:.6f}'); return -1e6"),
    tells("an_assertion", "assert False, f'{x:.6f}'"),
    tells("the_end_of_an_iterator", "raise StopIteration(f'{x:.6f}')"),
    tells("an_exit_of_python", "raise SystemExit(f'{x:.6f}')"),
    tells("a_unicode_error", "raise UnicodeDecodeError(f'u{x:.6f}', b'x', 0, 1, f'{x:.6f}')"),
    tells("a_json_error", "__import__('json').loads(f'{x:.6f} {x:.6f}')"),
    tells("its_own_name", "clamp.__name__ = clamp.__qualname__ = f'n{x:.6f}'; raise ValueError"),
    tells("its_docstring", "clamp.__doc__ = f'{x:.6f}'; help(clamp); return -1e6"),
    tells(
        "a_files_name_and_line",
        "exec(compile('\\n' * int(abs(x)) + 'raise ValueError', f'{x:.6f}.py', 'exec'))",
    ),
    tells("a_type_of_an_array", "return np.zeros(int(abs(x)) % 60, f'S{int(abs(x)) + 1}')"),
    tells("the_length_of_a_list", "return [0.0] * int(abs(x))", hides=("instead of 1 to",)),
    tells("the_depth_of_a_list", "y = 0.0\n    for _ in range(int(abs(x)) % 60): y = [y]\n    return y"),
    tells("the_time_that_it_takes", "import time; time.sleep(abs(x) / 1e4); return -1e6"),
    tells("the_memory_that_it_wants", "return len(bytearray(int(abs(x) * 1e12)))"),
    tells("logs", "import logging; logging.error(f'{x:.6f}'); print(f'{x:.6f}'); return -1e6"),
    tells("an_error_that_is_not_caught",
          "import sys; sys.excepthook(ValueError, ValueError(f'{x:.6f}'), None); return 0"),
    tells("an_error_in_a_thread",
          "import threading; threading.Thread(target=exec, args=[f'1/0#{x:.6f}']).start(); return -1e6"),
    tells("the_address_of_an_object", "raise ValueError(object())", hides=("object at 0x",)),
    Attack("messages_that_are_latex_and_markdown", "looks", all_but("clamp"), in_function("clamp",
        "raise ValueError('$\\\\href{javascript:nao_attack}{x}$ ![x](http://nao_attack) <!-- {{7*7}} ${7*7} #{7}')")),
    Attack("messages_without_width", "looks", all_but("clamp"), in_function("clamp",
        "raise ValueError('a' + '\\u200b\\u200d\\ufeff\\u2060\\u00ad\\U000e0041' * 50 + '\\u0338' * 500"
        " + '\\x1b[2J')")),
    Attack("variables_that_play_tricks", "looks", all_but("clamp"), in_function("clamp",
        "raise type('\\u202enao\\x1b[2J<b id=nao_attack>', (Exception,), {})('x')")),
)  # fmt: skip

# --- notebooks of more than 2 MB, which a confined process reads first ---

MUCH = "x" * (3 * 2**20)


def padded(made: dict[str, Any]) -> None:
    """Add three megabytes of output to the first check."""
    made["cells"][2]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": MUCH}]


def large(
    name: str,
    edit: Callable[[dict[str, Any]], object] = lambda made: None,
    text: Callable[[str], str | bytes] = lambda made: made,
    honest: Mapping[str, float] | None = None,
    says: str = "",
) -> Attack:
    """Make a notebook with three megabytes of output that is odd in one place, when it is handed in."""

    def make(folder: Path) -> None:
        made = copy.deepcopy(HONEST)
        padded(made)
        edit(made)
        content = text(json.dumps(made))
        (folder / FILE).write_bytes(content if isinstance(content, bytes) else content.encode())

    return replace(put(f"large_{name}", ALL if honest is None else honest, make, says), row="large")


def refused(name: str, text: Callable[[str], str | bytes], says: str = accidents.FORMAT) -> Attack:
    """Make a large file that is not a notebook."""
    return large(name, text=text, honest={}, says=says)


def outputs(*values: Any, count: int = 1) -> Callable[[dict[str, Any]], object]:
    return into(2, outputs=[*values] * count)


def raw(content: Callable[[], str]) -> Callable[[str], str]:
    """Replace the first outputs with JSON text."""
    return lambda text: text.replace('"outputs": []', f'"outputs": [{content()}]', 1)


_FALSE_CELL = cell("def clamp(x, low, high):\n    return -1e6", "clamp")
_PICTURE = {"output_type": "display_data", "data": {"image/png": "iVBORw0KGgo" * 10**6}, "metadata": {}}
_TRICKS = {"kernelspec": {"name": "x", "language": "\x1b[2J\u202eR<b id=nao_attack>\ud800"}}
_WIDGETS = {"application/vnd.jupyter.widget-state+json": {"state": {"a" * 32: {"state": {"_": "w" * 10**7}}}}}
LARGE = (
    # What costs a small notebook nothing, or costs it one exercise, does the same to a large one.
    *(
        replace(
            each,
            name=f"large_{each.name}",
            row="large",
            edit=lambda made, edit=each.edit: (padded(made), edit(made)),
        )
        for each in (*accidents.ODD_NOTEBOOKS, *siege.NOTEBOOKS)
        if each.edit and each.name not in ("outputs_of_45_mb", "outputs_that_are_pages")
    ),
    large("utf_8_bom", text=lambda text: text.encode("utf-8-sig")),
    large("windows_lines", text=lambda text: json.dumps(json.loads(text), indent=1).replace("\n", "\r\n")),
    large("old_mac_lines", text=lambda text: json.dumps(json.loads(text), indent=1).replace("\n", "\r")),
    large("keys_twice", text=lambda text: text.replace('"cells"', '"cells": [], "cells"', 1)),
    large("constants", text=raw(lambda: "NaN, Infinity, -Infinity, -0, 1e999, 1E-999, -0.0")),
    large("outputs_twice", text=lambda text: text.replace('"outputs": []', '"outputs": [], "outputs": [1]')),
    large("outputs_by_escapes", text=lambda text: text.replace('"outputs"', '"outp\\u0075ts"')),
    large("source_by_escapes", text=lambda text: text.replace('"source"', '"\\u0073ource"')),
    large("number_of_a_million_digits", text=raw(lambda: "9" * 10**6)),
    large("number_of_a_million_places", text=raw(lambda: "0." + "1" * 10**6)),
    large("outputs_40_mb_of_empty_lists", text=raw(lambda: ",".join(["[]"] * 13_000_000))),
    large("outputs_30_mb_of_empty_dicts", text=raw(lambda: ",".join(["{}"] * 10_000_000))),
    large("outputs_20_mb_of_numbers", text=raw(lambda: ",".join(["1e9"] * 5_000_000))),
    large("outputs_of_a_million_keys", outputs({f"k{n}": n for n in range(10**6)})),
    large("outputs_of_half_characters", text=raw(lambda: '"' + "\\ud83d" * 10**6 + '"')),
    large("outputs_of_null_characters", text=raw(lambda: '"' + "\\u0000" * 10**6 + '"')),
    large("outputs_500_deep", outputs(siege._deep(500))),
    large("outputs_that_look_like_cells", outputs(_FALSE_CELL, {"cells": [_FALSE_CELL]})),
    large("outputs_that_are_none", into(2, outputs=None)),
    large("outputs_that_are_a_dict", into(2, outputs={"cells": [_FALSE_CELL], "source": "x"})),
    large("outputs_that_are_a_text", into(2, outputs='"source": ["x"], "cells": []')),
    large("outputs_that_are_a_number", into(2, outputs=1e308)),
    large("outputs_100_000", outputs({"output_type": "stream", "name": "stdout", "text": "x"}, count=10**5)),
    large("outputs_of_pictures_of_33_mb", outputs(_PICTURE, count=3)),
    large("state_of_widgets_of_10_mb", lambda made: made["metadata"].update(widgets=_WIDGETS)),
    large("metadata_of_a_cell_of_10_mb", into(1, metadata=HONEST["cells"][1]["metadata"] | {"x": "y" * 10**7})),
    large("attachments_of_20_mb", adding(*[markdown("x", attachments={"a": {"b": "A" * 10**6}})] * 20)),
    large("words_of_10_mb", adding(markdown("word " * 2_000_000))),
    large("raw_cell_of_10_mb", adding({"cell_type": "raw", "metadata": {}, "source": "x" * 10**7})),
    large("blanks_of_20_mb", text=lambda text: text.replace('"cells":', '"cells":' + " \n" * 10**7, 1)),
    large("blanks_at_the_end", text=lambda text: text + " \r\n\t" * 10**6),
    large("source_that_speaks_of_outputs", into(1, source=CLAMP + '\nx = \'"outputs": [], "source": ""\'')),
    large("source_of_single_characters", into(1, source=list(CLAMP + "\n# " + "x" * 10**6))),
    large("outputs_in_words", adding(markdown("x", outputs=[MUCH], execution_count=1))),
    large("keys_that_are_names_of_python", of_notebook(__class__="x", __proto__={"cells": []}, __dict__=[])),
    large("cell_of_a_cell", into(2, cells=[_FALSE_CELL], outputs=[MUCH])),
    large("last_source_counts", text=lambda text: text.replace(
        json.dumps(CLAMP), json.dumps(CLAMP) + ', "source": ' + json.dumps(BLANK["clamp"])),
        honest=all_but("clamp")),
    large("clamp_in_an_output_only", lambda made: made["cells"][1].update(source="", outputs=[CLAMP]),
          honest=all_but("clamp")),
    large("syntax_error", into(1, source="def clamp(x, low, high)\n    return x"), honest=all_but("clamp"),
          says="SyntaxError"),
    large("loop", into(1, source="def clamp(x, low, high):\n    while True: pass"), honest=all_but("clamp"),
          says="longer than 2 seconds"),
    refused("truncated", lambda text: text[:-200]),
    refused("truncated_in_an_output", lambda text: text[: 2 * 2**20 + 100_000]),
    refused("two_documents", lambda text: text + text),
    refused("rubbish_at_the_end", lambda text: text + "}"),
    refused("zeros_at_the_end", lambda text: text + "\0" * 10**6),
    refused("zeros_only", lambda _: bytes(3 * 2**20)),
    refused("comma_at_the_end", lambda text: text[:-1] + ",}"),
    refused("comments", lambda text: "// notes\n" + text),
    refused("line_ends_in_texts", raw(lambda: '"a\nb"')),
    refused("utf_32_without_a_mark", lambda text: text.encode("utf-32-le")),
    refused("gzip", lambda text: gzip.compress(text.encode(), 0)),
    refused("page_of_the_web", lambda _: "<!doctype html><title>nao_attack</title>" + MUCH),
    refused("list", lambda text: f"[{text}]"),
    refused("text", lambda text: json.dumps(text)),
    refused("nested_without_an_end", raw(lambda: "[" * 4_000_000)),
    refused("nested_four_million_deep", raw(lambda: "[" * 2_000_000 + "]" * 2_000_000)),
    refused("dicts_a_million_deep", raw(lambda: '{"a":' * 10**6 + "1" + "}" * 10**6)),
    refused("text_without_an_end", raw(lambda: '"' + "y" * 10**6)),
    refused("format_3", lambda text: text.replace('"nbformat": 4', '"nbformat": 3')),
    refused("format_of_many_digits", lambda text: text.replace('"nbformat": 4', '"nbformat": 4' + "0" * 10**6)),
    refused("format_infinite", lambda text: text.replace('"nbformat": 4', '"nbformat": Infinity')),
    refused("format_not_a_number", lambda text: text.replace('"nbformat": 4', '"nbformat": NaN')),
    refused("language_r", lambda _: foreign("x <- 1", "R").replace('"metadata"', f'"x": "{MUCH}", "metadata"', 1),
            "in Python, got R"),
    refused("language_that_plays_tricks", lambda _: json.dumps(json.loads(foreign("x <- 1", "R"))
            | {"metadata": _TRICKS, "x": MUCH}), "in Python, got"),
    refused("metadata_that_count_as_code", lambda text: text.replace(
        '"version": "1"', f'"version": "{"1" * 13 * 2**20}"', 1), "its code and texts may have at most 12 MB"),
    refused("code_of_13_mb", lambda text: text.replace(
        json.dumps(CLAMP), json.dumps(CLAMP + "\n#" + "x" * 13 * 2**20)), "may have at most 12 MB"),
    refused("blank", lambda _: " \n" * 2_000_000, "it is empty"),
    put("zip_of_a_notebook_of_20_mb", ALL, lambda folder: (folder / f"{LESSON}.zip").write_bytes(packed((
        "work/" + FILE, TEXT.replace('"outputs": []', f'"outputs": ["{random.Random(0).randbytes(10**7).hex()}"]',
                                       1))))),
    named("large_and_an_older_blank_one", (f"{LESSON} (1).ipynb", BLANK_TEXT), (FILE, TEXT.replace(
        '"outputs": []', f'"outputs": ["{MUCH}"]', 1))),
    named("earlier_notebook_large_and_blank", (f"{LESSON} (1).ipynb", BLANK_TEXT.replace(
        '"outputs": []', f'"outputs": ["{MUCH}"]', 1)), (FILE, TEXT)),
)  # fmt: skip


def before_it(name: str, change: Callable[[str], str], honest: dict[str, float]) -> Attack:
    """Change the notebook of the lesson before, whose functions are needed later."""

    def make(folder: Path) -> None:
        second = Attack(name, "earlier", lesson=pair.SECOND)
        first = replace(second, lesson=pair.FIRST)
        for each in (first, second):
            text = json.dumps(notebook(each, pair.RIGHT[each.lesson], pair.SETUP[each.lesson]))
            text = change(text) if each is first else text
            (folder / f"{each.lesson}.ipynb").write_text(text)

    return later(name, honest, make=make)


EARLIER = (
    before_it(
        "earlier_notebook_of_45_mb",
        raw(lambda: '"' + "x" * 45 * 2**20 + '"'),
        {name: float(worth) for name, worth in pair.POINTS.items() if name in pair.RIGHT[pair.SECOND]},
    ),
    before_it(
        "earlier_notebook_that_is_large_and_truncated",
        lambda text: raw(lambda: f'"{MUCH}"')(text)[:-9],
        dict(LATER),
    ),
    before_it("earlier_notebook_nested_without_an_end", raw(lambda: "[" * 3_000_000), dict(LATER)),
)

# --- odd but honest work ---


def from_another(name: str, metadata: dict[str, Any], **of_cells: Any) -> Attack:
    """Add the metadata that another program writes."""

    def edit(made: dict[str, Any]) -> None:
        made["metadata"] |= metadata
        for number, each in enumerate(made["cells"]):
            each["metadata"] |= {
                key: value(number) if callable(value) else value for key, value in of_cells.items()
            }

    return edited(f"saved_by_{name}", edit, row="styles")


def split(made: dict[str, Any]) -> None:
    """Leave an import in the exercise's cell; the function follows in a cell of its own."""
    made["cells"][1]["source"] = "import math"
    made["cells"].insert(2, cell(CLAMP))


def merged(made: dict[str, Any]) -> None:
    """Put two exercises into one cell."""
    made["cells"][1]["source"] += "\n\n\n" + SCALED
    del made["cells"][3]


def of_type(kind: str) -> Callable[[dict[str, Any]], object]:
    return into(1, cell_type=kind)


WORK = (
    from_another("colab", {"colab": {"provenance": [], "toc_visible": True}, "accelerator": "TPU"},
                 id="aBcD", colab={"base_uri": "https://localhost:8080/", "height": 35}, outputId="x", cellView="form"),
    from_another("vs_code", {"language_info": {"name": "python", "version": "3.12.1"}, "vscode": {"interpreter": {}}},
                 vscode={"languageId": "python"}),
    from_another("deepnote", {"deepnote_notebook_id": "x", "deepnote_persisted_session": {}, "orig_nbformat": 2},
                 deepnote_cell_type="code", source_hash=lambda n: f"{n:08x}", cell_id=lambda n: f"{n:032x}"),
    from_another("jupyterlab", {"toc-showtags": True, "widgets": {}}, tags=["hide-input", "parameters"], trusted=True,
                 collapsed=True, jupyter={"source_hidden": True, "outputs_hidden": True}, scrolled="auto"),
    from_another("kaggle", {"kaggle": {"accelerator": "gpu", "dataSources": []}}, _uuid="x", execution={"iopub": {}}),
    from_another("jupytext", {"jupytext": {"formats": "ipynb,py:percent", "text_representation": {}}}, lines_to_next=2),
    from_another("databricks", {"application/vnd.databricks.v1+notebook": {}}, **{"application/vnd.databricks": {}}),
    from_another("another_version_of_python", {"language_info": {"name": "python", "version": "2.7.18"}}),
    edited("cell_split", split, row="styles"),
    edited("cells_merged", merged, row="styles"),
    edited("notebook_twice_in_itself", lambda made: made["cells"].extend(copy.deepcopy(made["cells"])), row="styles"),
    edited("cells_of_another_lesson", adding(cell("def rgb_to_hsl(image):\n    return image", "rgb_to_hsl")),
           row="styles"),
    edited("exercise_as_words", of_type("markdown"), "clamp", row="styles"),
    edited("exercise_as_raw_text", of_type("raw"), "clamp", row="styles"),
    edited("words_with_a_function", adding(markdown(f"```python\n{BLANK['clamp']}\n```")), row="styles"),
    edited("check_cells_with_other_code",
           into(2, source="check('clamp', lambda *_: 1 / 0)\nclamp = None"), row="styles"),
    edited("cells_without_an_end_of_line", lambda made: [
        each.update(source=each["source"].split("\n")) for each in made["cells"][:1]], row="styles"),
    style("old_mac_line_ends", "clamp", CLAMP.replace("\n", "\r")),
    style("windows_line_ends_in_a_cell", "clamp", CLAMP.replace("\n", "\r\n")),
    style("no_break_spaces", "clamp", CLAMP.replace("    ", "\u00a0" * 4), honest=all_but("clamp")),
    style("mark_of_bytes_in_a_cell", "clamp", "\ufeff" + CLAMP, honest=all_but("clamp")),
    style("quotes_that_are_curly", "clamp",
          "def clamp(x, low, high):\n    return max(low, min(high, x)) + len(\u2018\u2019)",
          honest=all_but("clamp")),
    style("single_dispatch", "clamp", f"from functools import singledispatch\n@singledispatch\n{CLAMP}"),
    style("overloads_and_protocols", "clamp", "from typing import Protocol, TypeVar, overload\nT = TypeVar('T')\n"
          "class Number(Protocol):\n    def __lt__(self, other) -> bool: ...\n@overload\n"
          "def clamp(x: int, low: int, high: int) -> int: ...\n@overload\n"
          "def clamp(x: float, low: float, high: float) -> float: ...\n" + CLAMP),
    style("context_manager", "clamp", "import contextlib\n@contextlib.contextmanager\ndef limits(low, high):\n"
          "    yield lambda x: max(low, min(high, x))\n\n"
          "def clamp(x, low, high):\n    with limits(low, high) as limit:\n        return limit(x)"),
    style("coroutine_that_is_run", "clamp", "def inner(low, high):\n    x = yield\n    while True:\n"
          "        x = yield max(low, min(high, x))\n\ndef clamp(x, low, high):\n    made = inner(low, high)\n"
          "    next(made)\n    return made.send(x)"),
    style("made_by_exec", "clamp", f"exec({CLAMP!r})"),
    style("made_by_eval", "clamp", "clamp = eval('lambda x, low, high: max(low, min(high, x))')"),
    style("put_among_the_globals", "clamp", "globals()['clamp'] = lambda x, low, high: max(low, min(high, x))"),
    style("defined_and_deleted_and_defined", "clamp", f"{BLANK['clamp']}\n\ndel clamp\n\n{CLAMP}"),
    style("reduced", "clamp", "import functools\ndef clamp(x, low, high):\n"
          "    return functools.reduce(lambda a, b: b[0](a, b[1]), [(min, high), (max, low)], x)"),
    style("selected_by_numpy", "clamp", "def clamp(x, low, high):\n"
          "    return np.select([x < low, x > high], [low, high], x)"),
    style("abstract_class", "clamp", "import abc\nclass Limit(abc.ABC):\n    @abc.abstractmethod\n"
          "    def __call__(self, x, low, high): ...\nclass Real(Limit):\n    def __call__(self, x, low, high):\n"
          "        return max(low, min(high, x))\nclamp = Real()"),
    style("method_of_a_class", "clamp", "class Limits:\n    @classmethod\n    def clamp(cls, x, low, high):\n"
          "        return max(low, min(high, x))\n\nclamp = Limits.clamp"),
    style("chain_of_comparisons", "clamp", "def clamp(x, low, high):\n"
          "    return x if low <= x <= high else (low, high)[x > high]"),
    style("sorted_in_the_middle", "clamp", "clamp = lambda *three: sorted(three)[1]"),
    style("match_of_classes", "clamp", "def clamp(x, low, high):\n    match x:\n        case float() if x < low:\n"
          "            return low\n        case float(y) if y > high:\n            return high\n"
          "        case y:\n            return y"),
    style("type_parameters", "clamp", "def clamp[T: float](x: T, low: T, high: T) -> T:\n"
          "    return max(low, min(high, x))", honest=all_but(*(["clamp"] if sys.version_info < (3, 12) else []))),
    style("groups_of_exceptions", "clamp", "def clamp(x, low, high):\n    try:\n"
          "        raise ExceptionGroup('x', [ValueError(x)])\n    except* ValueError as group:\n"
          "        y = group.exceptions[0].args[0]\n    return max(low, min(high, y))"),
    style("capture_above_a_function", "clamp", f"%%capture out\n{CLAMP}", row="honest"),
    style("progress_bar_of_a_library_that_is_missing", "clamp", "try:\n    from tqdm.auto import tqdm\n"
          f"except ImportError:\n    tqdm = lambda values, **_: values\n{CLAMP}", row="honest"),
    top("installs_a_library", "!pip install -q tqdm\n%pip install rich\nimport sys\n!{sys.executable} -m pip list"),
    top("plots_many_pictures",
        "import matplotlib.pyplot as plt\nfor _ in range(3):\n    plt.imshow([[1]])\n    plt.show()"),
    top("closes_everything_at_the_end", "import matplotlib.pyplot as plt\nplt.close('all')\n%reset -f\nquit"),
    top("line_that_goes_on", "%timeit -n 1 \\\n    sum([1])\nx = 1 + \\\n    2"),
    top("file_that_is_written_at_the_top", "with open('notes.txt', 'w') as file:\n    file.write('x')"),
    top("own_main", "if __name__ == '__main__' and '__file__' not in globals():\n    print('in Jupyter')"),
    beside("prints_50_mb", "for _ in range(50): print('y' * 2**20, end='\\r')"),
    beside("matplotlib_in_a_function", "import matplotlib\nmatplotlib.use('Agg', force=True)\n"
           "import matplotlib.pyplot as plt\nplt.hist([x])\nplt.savefig('x.png')\nplt.close()"),
    beside("garbage_in_a_circle", "ring = []\nring.append(ring)\nring = {'ring': ring}"),
    beside("counts_its_calls", "clamp.calls = getattr(clamp, 'calls', 0) + 1"),
    beside("clears_the_output", "from IPython.display import clear_output, HTML, Markdown\nclear_output(wait=True)"),
    beside("asks_whether_it_is_a_notebook", "try:\n    get_ipython\nexcept NameError:\n    pass"),
    beside("debugger_that_is_left", "if x is None: breakpoint()"),
    answer("answer_of_float16_back", "np.array(made.astype(np.float64).tolist(), dtype=np.float64)"),
    answer("answer_of_a_frame_of_ticks", "np.round(made, 15)"),
    answer("answer_of_a_chained_map", "list(map(list, made))"),
)  # fmt: skip

_BROKEN = (
    broken(
        "small_language_that_plays_tricks",
        json.dumps(json.loads(foreign("x <- 1", "R")) | {"metadata": _TRICKS}),
        "in Python, got",
    ),
    *(
        Attack(
            f"metadata_{depth}_deep_in_a_cell",
            "large",
            ALL,
            files={
                FILE: json.dumps(HONEST).replace(
                    '"grade_id": "clamp"', '"grade_id": "clamp", "x": ' + "[" * depth + "]" * depth, 1
                )
            },
        )
        for depth in (900, 930)
    ),
    broken(
        "small_nested_in_outputs", TEXT.replace('"outputs": []', '"outputs": ' + "[" * 10**5 + "]" * 10**5, 1)
    ),
)
ATTACKS: tuple[Attack, ...] = (*DENIALS, *HARM, *LEAKS, *GAINS, *LARGE, *_BROKEN, *WORK, *EARLIER)
