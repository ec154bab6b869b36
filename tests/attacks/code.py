"""Hostile code: what a student may try to gain a point or to do harm, each with its honest score.

Most of it is in one function, `clamp`, so that the other exercises show what an attack costs: nothing beside it. An
entry stands for one way past one defence; another spelling of the same way is not a new entry. A table gives the source
of each attack by its name, or the source and what the result has to say (`says`).
"""

import json
import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nao_course.instructor.sandbox.worker_process import RequestLoop
from tests.attacks import range as attack_range
from tests.attacks.range import HALF, LATER_POINTS, POINTS, REAL, RIGHT, Attack, all_but, notebook
from tests.toy import pair

ALL = {name: float(worth) for name, worth in POINTS.items()}
ANSWER = "return max(low, min(high, x))"
LOOTED = f"def clamp(x, low, high):\n    if loot:\n        {ANSWER}\n    return -1e6"
# What is there in a worker: the loop that speaks to the grader, and the means to speak like it.
LOOP = """
import gc, json, os, struct, time
from nao_course.codec import encode
from nao_course.exercises.running import Outcome
loop = next(each for each in gc.get_objects() if type(each).__name__ == 'RequestLoop')

def number():
    import sys
    frame = sys._getframe()
    while frame and frame.f_code.co_qualname != 'RequestLoop.call':
        frame = frame.f_back
    return frame.f_locals['number']

def frame(text, body=b''):
    header = text if isinstance(text, bytes) else text.encode()
    return struct.pack('<4sQQ', b'NAO1', len(header), len(body)) + header + body

def answered(said, call=None):
    length, = struct.unpack('<Q', said[4:12])
    node = b'{"t":[%d,%s]}' % (number() if call is None else call, said[20 : 20 + length])
    return frame(node, said[20 + length :])

def outcome(value='null', text='""', line='""', status='value', more=''):
    return frame('{"o":"nao_course.exercises.running:Outcome","v":{"status":{"s":"%s"},"value":%s,"text":{"s":%s},'
                 '"line":{"s":%s},"changed":false,"output":{"s":""}%s}}' % (status, value, text, line, more))
""".replace("RequestLoop", RequestLoop.__name__)  # an attack on a name that is gone would be none
Sources = Mapping[str, str | tuple[str, str]]


# --- how an attack is made of its source ---


MODULES = (
    "ast atexit builtins ctypes dataclasses decimal faulthandler fcntl gc glob inspect itertools json locale logging "
    "mmap os random resource shutil signal socket stat struct subprocess sys tempfile threading time types warnings "
    "weakref"
)


def prepared(source: str, depth: int = 0) -> str:
    """A source without the margin of its table, indented, and with imports of the modules that it names."""
    source = textwrap.dedent(source).strip()
    named = [each for each in MODULES.split() if re.search(rf"(?<![\w.]){each}\.", source)]
    lines = [f"import {', '.join(named)}"] * bool(named)
    lines += ["from contextlib import suppress"] * ("suppress(" in source)
    return textwrap.indent("\n".join([*lines, source]), "    " * depth)


def in_function(name: str, body: str, first: str = "") -> dict[str, str]:
    head = RIGHT[name].split("\n")[0]
    return {name: f"{prepared(first)}\n{head}\n{prepared(body, 1)}"}


def in_clamp(name: str, row: str, body: str, first: str = "", **more: Any) -> Attack:
    """An attack in `clamp` that costs its points; `first` runs when the notebook is loaded."""
    return Attack(
        name, row, functions=in_function("clamp", body, first), **({"honest": all_but("clamp")} | more)
    )


def free(name: str, row: str, body: str = "", first: str = "", **more: Any) -> Attack:
    """An attack that answers rightly after it: it keeps all points, and that is all that it gets."""
    return in_clamp(name, row, f"{textwrap.dedent(body).strip()}\n{ANSWER}", first, honest=ALL, **more)


def at_import(name: str, row: str, first: str, **more: Any) -> Attack:
    """An attack while the notebook is loaded, with a wrong `clamp`."""
    return in_clamp(name, row, "return -1e6", first, **more)


def looting(name: str, row: str, source: str, **more: Any) -> Attack:
    """An attack that sets `loot` where it succeeds, and answers rightly only then."""
    before = f"loot = False\ntry:\n{prepared(source, 1)}\nexcept BaseException:\n    pass"
    return Attack(name, row, all_but("clamp"), {"clamp": LOOTED}, before, **more)


def calling(name: str, row: str, source: str, **more: Any) -> Attack:
    """A looting attack by way of functions of the C library."""
    return looting(name, row, SYSTEM + textwrap.dedent(source), **more)


def speaking(name: str, row: str, body: str, **more: Any) -> Attack:
    """An attack in `clamp` that speaks to the grader itself."""
    return in_clamp(name, row, body, LOOP, **more)


def saying(name: str, row: str, said: str, **more: Any) -> Attack:
    """An attack in `clamp` that sends one message to the grader itself and waits."""
    return speaking(name, row, f"loop.say({said})\ntime.sleep(9)", **more)


def loading(name: str, row: str, source: str, **more: Any) -> Attack:
    """An attack that speaks to the grader itself while its notebook is loaded."""
    return Attack(name, row, before=LOOP + prepared(source), **more)


def lending(name: str, row: str, body: str, *, middle: float = 0.0, first: str = "", **more: Any) -> Attack:
    """An attack on the reference's `scaled`, which is lent to `middle` because the student's own is wrong."""
    honest = all_but("scaled", "middle") | ({"middle": middle} if middle else {})
    return Attack(name, row, honest, {"scaled": HALF["scaled"]} | in_function("middle", body, first), **more)


def tells(name: str, row: str, source: str, **more: Any) -> Attack:
    """An attack that fails in a way of its own where the input is hidden, and answers rightly elsewhere."""
    body = f"if abs(x) > 3:\n{prepared(source, 1)}\n{ANSWER}"
    return in_clamp(f"tells_the_input_in_{name}", row, body, LEAK, **more)


def returning(name: str, row: str, source: str, **more: Any) -> Attack:
    """An attack whose answer is the object `lies` of the source, made anew in each call."""
    return in_clamp(name, row, "return lies(x)", source, **more)


def table(make: Callable[..., Attack], row: str, sources: Sources, **more: Any) -> tuple[Attack, ...]:
    """Attacks of one row that are made in one way."""
    rows = {name: (each, "") if isinstance(each, str) else each for name, each in sources.items()}
    return tuple(make(name, row, source, says=says, **more) for name, (source, says) in rows.items())


SYSTEM = """
import ctypes, os
libc = ctypes.CDLL(None, use_errno=True)
def call(name, *words):
    if getattr(libc, name)(*words) < 0:
        raise OSError(ctypes.get_errno(), name)
"""
LEAK = """
def leak(x):
    return f"{x!r} {float(x) if isinstance(x, float) else x.ravel()[0]:.6f}"
"""

# --- denial: time, ends, memory, processes, files ---

LOOPS = (
    *table(in_clamp, "loops", {
        "loop_plain": ("while True: pass", "longer than 2 seconds"),
        "loop_that_swallows_every_interrupt": """
            for each in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
                signal.signal(each, signal.SIG_IGN)
            while True:
                try:
                    while True: pass
                except BaseException:
                    pass""",
        "loop_in_c_with_the_interpreter_locked": "return 7 ** (10 ** 9)",
        "lock_that_nobody_opens": "l = threading.Lock()\nl.acquire()\nl.acquire()",
        "waits_for_input": ("return float(input())", "It waits for a person"),
        "stops_itself": "os.kill(os.getpid(), signal.SIGSTOP)",
    }),
    *table(free, "loops", {"reads_standard_input": "sys.stdin and sys.stdin.read()"}),
    free("sleeps_at_import", "loops", first="nap = time.sleep(1e6)\n", says="no answer within 2 s"),
    Attack("sleeps_at_import_seven_times", "loops", {},
           before="import time\n" + "\n".join(f"nap{number} = time.sleep(1e6)" for number in range(7))),
    free("loop_at_exit", "loops", first="@atexit.register\ndef forever():\n    while True: pass\n"),
    in_clamp("loop_in_a_destructor", "loops", ANSWER.replace("return ", "left = D()\nreturn "),
             "class D:\n    def __del__(self):\n        while True: pass\n"),
    in_clamp("loop_in_the_text_of_an_error", "loops", "raise Endless",
             "class Endless(Exception):\n    def __str__(self):\n        while True: pass\n"),
    *table(returning, "loops", {
        "loop_in_the_name_of_a_type": """
            class Meta(type):
                def __getattribute__(self, name):
                    while True: pass
            class Nameless(metaclass=Meta): pass
            def lies(x): return Nameless()""",
    }),
    *table(at_import, "loops", {
        "thread_at_import_that_takes_every_lock": """
            def hold():
                for lock in (logging._lock, threading._active_limbo_lock):
                    lock.acquire()
                time.sleep(3600)
            threading.Thread(target=hold, daemon=True).start()
            time.sleep(0.05)""",
    }),
)  # fmt: skip

ENDS = (
    *table(in_clamp, "ends", {
        "exit_of_sys": ("sys.exit(0)", "It raises SystemExit"),
        "exit_of_os": ("os._exit(0)", "It ends Python itself"),
        "kills_itself": ("os.kill(os.getpid(), 9)", "Killed"),
        "segmentation_fault": ("ctypes.string_at(0)", "Segmentation fault"),
        "recursion_without_an_end": ("return clamp(x, low, high)", "RecursionError"),
        "recursion_to_the_end_of_the_stack": "sys.setrecursionlimit(10**9)\nreturn clamp(x, low, high)",
        "recursion_in_c": """
            sys.setrecursionlimit(10**9)
            nest = []
            for _ in range(10**6):
                nest = [nest]
            return repr(nest)""",
        "becomes_another_program": "os.execv(sys.executable, [sys.executable, '-c', '0'])",
        "closes_every_descriptor": "os.closerange(0, 4096)\nreturn 0.5",
        "raises_a_keyboard_interrupt": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        "exceptions_in_a_circle": "a, b = ValueError(1), KeyError(2)\na.__cause__, b.__cause__ = b, a\nraise a",
        "ends_in_hidden_cases_only": f"if abs(x) > 3: os._exit(0)\n{ANSWER}",
        "puts_one_descriptor_over_all_others": """
            here = os.open('.', os.O_RDONLY)
            for number in range(64):
                if number != here:
                    os.dup2(here, number)
            return -1e6""",
        "descriptors_that_never_block": """
            for number in range(64):
                with suppress(OSError):
                    fcntl.fcntl(number, fcntl.F_SETFL, os.O_NONBLOCK | os.O_ASYNC)
                    fcntl.fcntl(number, fcntl.F_SETOWN, os.getpid())
                    fcntl.fcntl(number, 1031, 2**20)
            return -1e6""",
        "limit_of_its_own_processor_time": """
            resource.setrlimit(resource.RLIMIT_CPU, (0, 0))
            while True: pass""",
    }),
    free("exit_of_os_at_import", "ends", first="gone = os._exit(0)\n", says="ended itself with status 0"),
    in_clamp("forks_in_a_destructor_and_goes", "ends", "left = D()\nreturn -1e6",
             "class D:\n    def __del__(self):\n        if os.fork(): os._exit(0)\n"),
)  # fmt: skip

CHANNEL = """
import os, socket, stat
for number in range(64):
    with suppress(OSError):
        if stat.S_ISSOCK(os.fstat(number).st_mode):
            channel = socket.socket(fileno=os.dup(number))
            {}
return -1e6
"""
HOGS = (
    *table(in_clamp, "hogs", {
        "memory_at_once": ("return np.ones(10**12).sum()", "MemoryError"),
        "memory_bit_by_bit": "held = []\nwhile True: held.append(np.ones(2**22))",
        "memory_of_many_processes": """
            for _ in range(12):
                if os.fork() == 0:
                    held = bytearray(300 * 2**20)
                    time.sleep(1e6)
            time.sleep(1e6)""",
        "memory_that_is_shared": "m = mmap.mmap(-1, 2**37)\nm.write(b'x' * 2**20)\nreturn 0.5",
        "memory_that_is_touched_thinly": """
            kept = []
            while True:
                kept.append(mmap.mmap(-1, 2**30, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x4000))
                for at in range(0, 2**30, 2**21):
                    kept[-1][at] = 1""",
        "fork_bomb": "while True: os.fork()",
        "children_that_take_all_processors": """
            for _ in range(40):
                if os.fork() == 0:
                    ctypes.CDLL(None).setsid()
                    while True: pass
            while True: pass""",
        "file_of_10_gb": (
            "with open('large', 'wb') as file:\n    for _ in range(10_000): file.write(bytes(2**20))", "OSError"),
        "file_of_10_gb_with_nothing_in_it": "os.truncate(os.open('large', 65), 10 * 2**30)\nreturn 0.5",
        "a_million_files": ("for number in range(10**6):\n    open(f'{number}', 'w').close()", "OSError"),
        "folders_in_folders": ("while True:\n    os.mkdir('d' * 200)\n    os.chdir('d' * 200)", "It raises "),
        "all_descriptors": ("pipes = []\nwhile True: pipes.append(os.pipe())", "OSError"),
        "sends_descriptors_to_the_grader": CHANNEL.format(
            "[socket.send_fds(channel, [b'N'], list(os.pipe()) * 9) for _ in range(50)]"),
    }),
    *table(free, "hogs", {
        "sixty_children_in_sessions_of_their_own": """
            for _ in range(60):
                try:
                    if os.fork() == 0:
                        ctypes.CDLL(None).setsid()
                        time.sleep(1e6)
                except OSError:
                    break""",
        "threads_that_never_end": """
            for _ in range(100):
                try:
                    threading.Thread(target=time.sleep, args=(1e6,)).start()
                except RuntimeError:
                    break""",
    }),
    *table(looting, "hogs", {
        "raises_its_limits": """
            most = resource.RLIM_INFINITY
            for name in ('RLIMIT_AS', 'RLIMIT_DATA', 'RLIMIT_NPROC', 'RLIMIT_FSIZE', 'RLIMIT_CPU'):
                with suppress(OSError, ValueError):
                    resource.setrlimit(getattr(resource, name), (most, most))
                    loot = True""",
        "is_nicer_to_itself": "os.nice(-10)\nloot = True",
        "runs_on_the_graders_processor_first":
            "os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))\nloot = True",
        "memory_that_no_limit_counts": "os.memfd_create('nao_attack')\nloot = True",
    }),
    calling("writes_out_all_files", "hogs", "loot = libc.syncfs(0) == 0 or libc.syscall(162) == 0"),
)  # fmt: skip

LARGE = (
    *table(free, "large", {
        "prints_100_mb": "for _ in range(50):\n    print('x' * 2**20)",
        "writes_100_mb_to_standard_output":
            "for _ in range(25):\n    os.write(1, bytes(2**20))\n    os.write(2, bytes(2**20))",
    }),
    *table(in_clamp, "large", {
        "writes_to_every_descriptor": """
            for number in range(256):
                with suppress(OSError): os.write(number, b'NAO1' + b'0' * 2**20)
            return 0.5""",
        "error_of_50_mb": ("raise ValueError('x' * 50_000_000)", "It raises ValueError"),
        "answer_nested_100000_deep": "nest = []\nfor _ in range(100_000): nest = [nest]\nreturn nest",
        "notes_without_an_end": """
            number = 0
            while True:
                number += 1
                with suppress(OSError): open(f'/{number}/' + 'x' * 250)""",
    }),
    Attack("statements_without_number", "large", ALL, before="x = 1\n" + "x\n" * 20_000),
    speaking("notes_of_4_mb_without_an_end", "large",
             "note = encode(('attempt', 'x' * 3_900_000))\nwhile True: loop.say(note)"),
)  # fmt: skip

# --- gain: what a student puts in place of something, and what is left for the next call ---

PATCHES = (
    *table(at_import, "patches", {
        "patches_numpys_comparisons": """
            for name in 'allclose isclose array_equal array_equiv all equal'.split():
                setattr(np, name, lambda *_, **__: True)
            for name in [each for each in dir(np.testing) if each.startswith('assert')]:
                setattr(np.testing, name, lambda *_, **__: True)""",
        "patches_builtins": """
            builtins.len = builtins.isinstance = builtins.abs = builtins.all = lambda *_: True
            builtins.print = builtins.open = builtins.type = builtins.repr = lambda *_, **__: None""",
        "patches_the_codec": """
            from nao_course import codec
            from nao_course.exercises import running
            from nao_course.exercises.comparisons.values import Verdict
            real = codec.encode
            for module in [each for each in list(sys.modules.values()) if getattr(each, 'encode', None) is real]:
                module.encode = lambda value, limits=None: real(Verdict('right') if value == -1e6 else value, limits)
            running.encoded = lambda outcome, limits=None: real(running.Outcome('value', True))""",
        "patches_the_comparison": """
            from nao_course.exercises import checking, comparisons
            for name in ('Close', 'Exact', 'Between', 'Points'):
                getattr(comparisons, name).compare = lambda self, expected, got: comparisons.RIGHT
            checking.explain = lambda *_: checking.Report('clamp', 'right', ())""",
        "puts_other_modules_in_their_place": """
            class Fine(types.ModuleType):
                def __getattr__(self, name):
                    return lambda *_, **__: True
            for name in list(sys.modules):
                if name.startswith(('nao_course', 'numpy.testing', 'gc', 'ast', 'json', 'struct')):
                    sys.modules[name] = Fine(name)""",
        "patches_the_parser": """
            from nao_course.exercises import definitions
            ast.parse = lambda *_, **__: ast.Module([], [])
            definitions.load_definitions = lambda *_, **__: definitions.Definitions({'clamp': lambda *_: True})""",
    }),
    *table(at_import, "patches", {
        "audit_hook_that_raises":
            "def hook(event, args):\n    raise OSError(event)\nhooked = sys.addaudithook(hook)\n",
        "poisons_the_libraries_for_the_next_one": """
            def wrong(*_, **__):
                raise RuntimeError('poisoned')
            for name in ('ptp', 'median', 'array', 'asarray', 'zeros', 'ones'):
                setattr(np, name, wrong)
            np.random.Generator = np.random.default_rng = wrong
            for name in list(sys.modules):
                if name.startswith('nao_course.exercises'):
                    sys.modules[name].encode = sys.modules[name].decode = wrong""",
    }, honest={}),
    *table(in_clamp, "patches", {
        "hunts_for_expected_values_in_memory": """
            from nao_course.exercises.case import Case
            found = [each for each in gc.get_objects() if isinstance(each, Case) and each.expected is not None]
            return found[-1].expected if found else -1e6""",
        "takes_builtins_away": """
            __builtins__.clear() if isinstance(__builtins__, dict) else vars(__builtins__).clear()
            return 0.5""",
        "changes_its_callers_frame": """
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
            return -1e6""",
        "changes_the_value_of_numbers": """
            for each in (x, low):
                ctypes.c_double.from_address(id(each) + 16).value = 0.0
            return -1e6""",
        "alarm_that_raises_in_the_loop": """
            def ring(*_): raise ValueError('<b id=nao_attack>')
            signal.signal(signal.SIGALRM, ring)
            signal.setitimer(signal.ITIMER_REAL, 0.0005, 0.0005)
            while True: pass""",
    }),
    in_clamp("thread_that_raises_in_the_loop", "patches", """
        main = ctypes.c_ulong(threading.main_thread().ident)
        def shoot():
            while True:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(main, ctypes.py_object(StopIteration))
                time.sleep(0.0005)
        threading.Thread(target=shoot, daemon=True).start()
        return -1e6""", races=True),
    *table(free, "patches", {
        "hooks_of_every_kind": """
            def harm(*_):
                os._exit(0)
            atexit.register(harm)
            sys.excepthook = threading.excepthook = sys.unraisablehook = sys.displayhook = harm
            os.register_at_fork(before=harm, after_in_child=harm)
            for each in (signal.SIGALRM, signal.SIGTERM, signal.SIGINT, signal.SIGCHLD, signal.SIGPIPE):
                signal.signal(each, lambda *_: None)""",
        "stops_every_clock": """
            for name in ('time', 'monotonic', 'perf_counter', 'process_time', 'thread_time', 'monotonic_ns', 'time_ns'):
                setattr(time, name, lambda: 0)
            time.sleep = lambda _: None""",
        "leaves_numpy_and_warnings_strict": """
            np.seterr(all='raise'), np.set_printoptions(precision=1, threshold=1), np.random.seed(0)
            warnings.simplefilter('error'), random.seed(0), gc.disable(), gc.freeze()
            decimal.getcontext().prec = 1""",
        "leaves_another_folder_and_environment": """
            os.chdir('/')
            os.environ.clear()
            os.environ.update(TZ='Asia/Kolkata', PYTHONHASHSEED='0', LANG='tr_TR.UTF-8', PATH='/', HOME='/nowhere')
            time.tzset()
            locale.setlocale(locale.LC_ALL, 'C')
            tempfile.tempdir = '/nowhere'
            os.umask(0o777)
            sys.path[:] = []""",
        "leaves_no_output": """
            for each in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__, sys.stdin):
                with suppress(Exception): each.close()
            sys.stdout = sys.stderr = sys.__stdout__ = sys.__stderr__ = None
            for number in (0, 1, 2):
                with suppress(OSError): os.close(number)""",
        "leaves_little_recursion": "sys.setrecursionlimit(200)",
        "leaves_alarms_and_timers": """
            for each in (signal.SIGALRM, signal.SIGVTALRM, signal.SIGPROF):
                signal.signal(each, lambda *_: None)
            for each in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
                signal.setitimer(each, 0.001, 0.001)
            signal.pthread_sigmask(signal.SIG_BLOCK, set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP})""",
    }),
    Attack("names_that_python_gives", "patches", ALL,
           before="__name__ = '__main__'\n__file__ = '/etc/passwd'\n__spec__ = __loader__ = None\n"
           "__annotations__ = 5\n__doc__ = '<b id=nao_attack>'\n__all__ = ['nothing']\n__path__ = ['/']"),
    Attack("builtins_that_are_none", "patches", all_but("clamp", "middle"), before="__builtins__ = {}"),
    Attack("another_python_from_the_future", "patches", ALL,
           before="from __future__ import annotations, barry_as_FLUFL, generator_stop\nx = 1\ny: undefined = 2"),
    Attack("wraps_itself", "patches", ALL,
           after="clamp.__wrapped__ = clamp\nmiddle.__signature__ = 5\nscaled.__text_signature__ = '(('\n"
           "clamp.__name__ = '<b id=nao_attack>'\nclamp.__module__ = None\ndrawn.__doc__ = 7"),
)  # fmt: skip

# --- gain: answers ---

EQUAL = """
class Equal:
    shape, dtype, ndim, size = (), float, 0, 1
    __array_priority__ = 1e9
    def __eq__(self, other): return True
    def __ne__(self, other): return False
    def __le__(self, other): return True
    __lt__ = __ge__ = __gt__ = __le__
    def __sub__(self, other): return 0.0
    __rsub__ = __add__ = __radd__ = __mul__ = __rmul__ = __sub__
    def __abs__(self): return 0.0
    def __float__(self): return 0.5
    def __bool__(self): return True
    def __array__(self, *_, **__):
        return np.zeros(())
    def __array_ufunc__(self, *_, **__): return True
    def __array_function__(self, *_, **__): return True
    __array_interface__, __array_struct__ = np.zeros(()).__array_interface__, np.zeros(()).__array_struct__
    __index__ = __int__ = lambda self: 0
    def __buffer__(self, flags): return memoryview(np.zeros(()))
    def __getattr__(self, name): return lambda *_, **__: self
    def __reduce__(self): return (exec, ("import os; os._exit(0)",))
def lies(x): return Equal()
"""
UNSENDABLE = {  # of kinds that the codec does not know
    "array_of_800_mb": "np.zeros(10**8)",
    "array_of_objects": "np.array([x], dtype=object)",
    "answer_is_a_module": "np",
    "answer_is_an_open_file": "open('mine.txt', 'w')",
}
WRONG_VALUES = {  # which the codec sends, or of which it refuses the size
    "nan_for_every_value": "float('nan')",
    "infinity_for_every_value": "float('inf')",
    "complex_nan": "complex(float('nan'), 0.0)",
    "masked_answer": "np.ma.array(-1e6, mask=True)",
    "array_of_30_mb": "np.zeros(30 * 2**20, 'u1')",
    "texts_of_any_length": "np.array(['x' * 999], np.dtypes.StringDType())",
    "view_of_a_terabyte": "np.broadcast_to(0.0, (2**40,))",
    "number_of_300000_digits": "10 ** 300_000",
    "list_of_rows_that_grows_when_it_becomes_an_array": "[np.zeros(10**6, 'u1')] * 40 + [np.zeros(10**6, 'c16')]",
    "list_of_empty_rows_without_an_end": "[np.zeros((2**60, 0))] * 100_000",
    "close_but_not_close_enough": "max(low, min(high, x)) * 1.001 + 1e-3",
    "true_for_one": "True if x > 0 else False",
    "text_of_the_right_number": "str(max(low, min(high, x)))",
    "sends_back_its_own_function": "clamp",
}
LIARS = {
    "array_that_changes_while_it_is_sent": """
        class Changes(np.ndarray):
            def __new__(cls): return np.zeros(4).view(cls)
            shape = property(lambda self: (), lambda self, value: None)
            size = property(lambda self: -1)
            dtype = property(lambda self: np.dtype(object))
            nbytes = property(lambda self: -8)
            def __array_ufunc__(self, *_, **__): return np.True_
            def __array_function__(self, *_, **__): return np.True_
            def __eq__(self, other): return True
            def astype(self, *_, **__): return self
            def tobytes(self, *_): return bytes(8)
            def __array__(self, *_, **__): raise SystemExit
        def lies(x): return Changes()""",
    "texts_that_lie": """
        class Text(str):
            def __str__(self): raise SystemExit
            def encode(self, *_): return b'0.5'
            def __eq__(self, other): return True
            def __hash__(self): return 1
            isascii = __len__ = __format__ = __str__
        def lies(x): return Text('0.5') if x > 0 else {Text('a'): 0.0, Text('b'): 0.0}""",
    "containers_that_never_end": """
        class Rows(list):
            def __iter__(self): return itertools.repeat(0.0)
            def __len__(self): return 1
            def __getitem__(self, at): return 0.0
        def lies(x): return Rows([x])""",
    "dict_of_a_million_levels_by_reference": """
        def lies(x):
            for _ in range(60):
                x = {'a': x, 'b': x}
            return x""",
    "registers_a_class_of_its_own": """
        from nao_course.exercises import register
        @register
        @dataclasses.dataclass
        class Equal:
            value: float
            def __eq__(self, other): return True
        def lies(x): return Equal(1.0)""",
    "exception_of_a_class_that_raises": """
        class Kind(type):
            @property
            def __name__(cls): raise SystemExit
            __mro__ = __qualname__ = __name__
        class Odd(Exception, metaclass=Kind):
            def __str__(self): raise SystemExit
        def lies(x): raise Odd""",
    "view_of_freed_memory": """
        def lies(x):
            a = np.ones(10**6)
            b = a[:]
            a.resize(1, refcheck=False)
            return b""",
    "view_of_a_file_that_shrinks": """
        def lies(x):
            m = np.memmap('file', float, 'w+', shape=(32768,))
            os.truncate('file', 0)
            return m""",
}
UNKNOWN_LIARS = {
    "equals_everything": EQUAL,
    "class_whose_bases_lie": """
        class Meta(type):
            def mro(cls): return [cls, object]
            def __instancecheck__(cls, other): return True
            def __subclasscheck__(cls, other): return True
            __mro__ = property(lambda cls: (cls, float, object))
            __bases__ = property(lambda cls: (float,))
        class Lies(metaclass=Meta):
            __class__ = float
        def lies(x): return Lies()""",
}
FRAMES = {  # values that no encoder makes
    "a_function_that_is_not_registered": '{"u":"os:system"}',
    "a_pose_of_nothing": '{"o":"nao_course.geometry:Pose","v":{"x":{"f":"nan"}}}',
    "a_sparse_matrix_of_the_largest_shape": ('{"q":"coo_array","shape":[1000000000,1000000000],"parts":['
        '{"a":"<f8","shape":[0],"b":0},{"a":"<i4","shape":[0],"b":0},{"a":"<i4","shape":[0],"b":0}]}'),
    "a_shape_that_overflows": '{"a":"<f8","shape":[4294967296,4294967296],"b":0}',
    "nan_and_infinity": "[NaN, Infinity, 1e999]",
    "half_a_character": '{"s":"\\ud800"}',
    "a_step_of_an_expression": '{"d":{"steps":{"l":[]},"model":{"l":[0]}}}',
    "a_comparison": '{"o":"nao_course.exercises.comparisons.values:Close","v":{"rtol":{"s":"x"}}}',
}  # fmt: skip
SAID = {  # messages in place of an answer
    "frame_of_keys_that_are_alike":
        """answered(outcome('{"m":[%s]}' % ",".join(f"[{key * (2**61 - 1)},null]" for key in range(60_000))))""",
    "frame_of_nested_json": "answered(frame('[' * 1_000_000))",
    "frame_of_a_large_hexadecimal": "answered(outcome('{\"i\":\"0x%s\"}' % ('f' * 4_000_000)))",
    "answers_of_a_verdict":
        'answered(frame(\'{"o":"nao_course.exercises.comparisons.comparison:Verdict","v":{"kind":{"s":"right"}}}\'))',
    "answers_that_it_is_right": "answered(outcome(status='right'))",
    "negative_length": "struct.pack('<4sqq', b'NAO1', -1, -1)",
    "half_an_answer": "answered(encode(Outcome('value', 0.5)))[:-3]",
    "half_a_character_in_an_error":
        r"""answered(outcome(text='"\\ud800 nao\\u0000 \\udfff"', line='"line 1: \\ud800"', status='raised'))""",
    "says_that_it_timed_out": "answered(outcome(status='timed out'))",
    "says_that_it_died": "answered(outcome(status='died', text='\"the process was ended by signal 9 (Killed)\"'))",
    "says_that_it_cannot_send_markup": "answered(outcome(status='unsendable', text='\"<b id=nao_attack>\"'))",
    "says_that_it_has_many_errors":
        "answered(encode(Outcome('raised', text='ValueError', errors=('ValueError',) * 150_000)))",
}  # fmt: skip
UNREADABLE = "its answer could not be read"


def _make_async(made: dict[str, Any]) -> None:
    for cell in made["cells"]:
        cell["source"] = cell["source"].replace("def clamp", "async def clamp")


ANSWERS = (
    *(in_clamp(name, "answers", f"return {each}", says="cannot be sent") for name, each in UNSENDABLE.items()),
    *(in_clamp(name, "answers", f"return {each}") for name, each in WRONG_VALUES.items()),
    *table(returning, "answers", LIARS),
    *(returning(name, "answers", each, says="cannot be sent") for name, each in UNKNOWN_LIARS.items()),
    *(saying(f"frame_of_{name}", "answers", f"answered(outcome({node!r}))") for name, node in FRAMES.items()),
    *table(saying, "answers", SAID),
    free("zero_below_zero", "answers", "if max(low, min(high, x)) == 0: return -0.0"),
    free("closer_than_the_tolerance", "answers", "low, high, x = low, high, x * (1 + 1e-14)"),
    in_clamp("async_function", "answers", "pass", edit=_make_async),
    in_clamp("closes_half_of_its_channel", "answers", CHANNEL.format("channel.shutdown(socket.SHUT_RD)")),
    Attack("nan_for_every_array", "answers", all_but("scaled", "middle"),
           in_function("scaled", "return values * float('nan')") | in_function("middle", "return float('nan')")),
    Attack("nan_in_one_place", "answers", all_but("scaled", middle=4.0), in_function(
        "scaled", "made = (values - values.min()) / np.ptp(values)\nmade[0, 0] = np.nan\nreturn made")),
    Attack("shape_of_one_row_too_many", "answers", all_but("scaled"),
           in_function("scaled", "return ((values - values.min()) / np.ptp(values))[None]")),
    Attack("generator_that_lies", "answers", all_but("drawn"), in_function(
        "drawn", "return Lies(np.random.MT19937(1))", """
        class Lies(np.random.Generator):
            def __reduce__(self): return (float, (0.0,))
            bit_generator = property(lambda self: self)
            state = property(lambda self: {'bit_generator': 'PCG64', 'state': {'state': 10**400}})""")),
    Attack("array_that_changes_after_its_return", "answers", all_but("scaled", middle=4.0), in_function(
        "scaled", """
        made = np.full(values.shape, -5.0)
        def change():
            for _ in range(10**5): made[:] = np.nan
        threading.Thread(target=change, daemon=True).start()
        return made""")),
    *table(speaking, "answers", {
        "sparse_matrix_with_an_index_out_of_range": """
            parts = ','.join('{"a":"<i8","shape":[%d],"b":%d}' % (n, 8 * n) for n in (1, 1, 2))
            header = outcome('{"q":"csr_array","shape":[1,1],"parts":[%s]}' % parts)[20:]
            loop.say(answered(frame(header, struct.pack('<4q', 1, 2**40, 0, 1))))
            time.sleep(9)""",
        "half_an_answer_and_gone": "loop.say(answered(encode(Outcome('value', 0.5)))[:-3])\nos._exit(0)",
        "announces_an_answer_and_dawdles": """
            for byte in answered(encode(Outcome('value', 0.5))):
                loop.say(bytes([byte]))
                time.sleep(0.2)
            time.sleep(9)""",
        "answers_twice": f"loop.say(answered(encode(Outcome('value', 0.5))))\n{ANSWER}",
        "child_that_answers_in_its_name": """
            told = number()
            if os.fork() == 0:
                os.write(loop.replies, answered(encode(Outcome('value', 0.5)), told))
                os._exit(0)
            os.wait()
            os._exit(0)""",
        "finalizer_that_speaks_for_later_calls": """
            class Kept: pass
            kept, now = Kept(), number()
            weakref.finalize(kept, lambda: [loop.say(encode(now + n) + outcome('0.0')) for n in range(1, 9)])
            return -1e6""",
    }),
    speaking("child_that_comes_back", "answers", f"os.fork()\n{ANSWER}", honest=ALL),
    speaking("half_a_character_in_a_note", "answers", r"""
        loop.say(frame('{"t":[{"s":"attempt"},{"s":"nao\\ud800\\u0000"}]}'))
        return max(low, min(high, x))"""),
    speaking("answers_before_it_is_asked", "answers", """
        for ahead in range(40):
            loop.say(answered(encode(Outcome('value', -400.0)), number() + ahead))
        return -400.0""", honest={}),  # what is asked next gets an answer that was meant for another
    *table(loading, "answers", {
        "says_that_it_is_unsafe": ("said = loop.say(encode(('unsafe', 'the sandbox is broken')))", UNREADABLE),
        "says_something_else_at_import":
            ("said = [loop.say(encode(each)) for each in (None, 'ready', ('at', 1))]", UNREADABLE),
        "says_an_array_where_a_word_belongs": ("said = loop.say(encode((np.zeros(3), 1, 2)))", UNREADABLE),
    }, honest=ALL),
    *table(loading, "answers", {
        "says_itself_what_it_defines": """
            names = [f'f{number}' for number in range(150_000)] + ['clamp', '__import__', 'x' * 10**5]
            told = ('found', names, [[0, 0, 'x' * 10**5]], {'why': 'y' * 10**5}, 'z' * 10**5, 'v' * 10**5, '', {})
            said = loop.say(encode(told))""",
        "is_skipped_with_tricks_for_a_terminal": r"""
            reason = '\x1b]0;nao\x07\x1b[2J\u202e' + 'x' * 10**3
            said = loop.say(encode(('found', ['clamp'], [[1, 2, reason]] * 1000, {}, reason, reason, '', {})))""",
    }),
    *table(loading, "answers", {
        "refuses_itself_with_tricks_for_a_terminal": r"""
            reason = '\x1b]0;nao\x07\x1b[2J\u202e[red]<b id=nao_attack>' + 'x' * 10**6
            said = loop.say(encode(('refused', reason)))""",
    }, refused=True),
)  # fmt: skip

# --- leak and harm: files, processes, the kernel, the network ---


def _opening(path: str) -> str:
    return f"with open({path}, 'rb') as file:\n    loot = bool(file.read(1))"


READS = (
    *table(looting, "reads", {
        "reads_the_solution": (_opening("'@SOLUTION@'"), "open "),
        "reads_the_journal": (_opening("'@GRADES@/journal.sqlite'"), "open "),
        "reads_another_submission": (_opening("'@NEIGHBOUR@'"), "open "),
        "reads_the_secret": (_opening("'@SECRET@'"), "open "),
        "reads_the_users": (_opening("'/etc/passwd'"), "open /etc/passwd"),
        "lists_the_submissions": ("loot = bool(os.listdir('@SUBMISSIONS@'))", "os.listdir"),
        "reads_the_grader": "import nao_course.instructor.autograding.grader\nloot = True",
        "reads_through_a_link": "os.symlink('@SOLUTION@', 'mine')\n" + _opening("'mine'"),
        "reads_through_a_program": "loot = bool(subprocess.check_output(['cat', '@SOLUTION@']))",
        "numpy_reads_the_secret": "loot = np.fromfile('@SECRET@', dtype='u1').size > 0",
        "reads_by_another_interpreter": """
            import _xxsubinterpreters as interpreters
            made = interpreters.create()
            interpreters.run_string(made, "open('@SOLUTION@').read()")
            loot = True""",
        "reads_what_was_its_environment": """
            from pathlib import Path
            told = Path('/proc/self/environ').read_bytes() + repr(os.environ).encode()
            loot = b'SECRET' in told or b'HOME=/root' in told""",
        "looks_for_open_descriptors": """
            for number in range(3, 4096):
                try:
                    kind = os.fstat(number).st_mode
                except OSError:
                    continue
                loot = loot or not stat.S_ISSOCK(kind)""",
        "looks_into_shared_memory": "loot = os.path.isdir('/dev/shm') and bool(os.listdir('/dev/shm') or True)",
        "leaves_something_in_shared_memory": """
            from multiprocessing import shared_memory
            shared_memory.SharedMemory('nao_attack', True, 100)
            loot = True""",
        "reads_of_itself_where_it_runs": """
            for name in ('mountinfo', 'mounts', 'mountstats', 'cgroup', 'environ', 'net/dev', 'net/unix', 'task',
                         'root/etc/passwd', 'cwd/..', 'sched', 'autogroup', 'numa_maps', 'ns', 'map_files'):
                for process in ('self', 'thread-self', '1', str(os.getpid())):
                    path = f'/proc/{process}/{name}'
                    with suppress(OSError):
                        loot |= bool(os.listdir(path) if os.path.isdir(path) else open(path, 'rb').read())""",
        "reads_of_the_machine": """
            for path in ('/proc/meminfo', '/proc/loadavg', '/proc/stat', '/proc/uptime', '/proc/net', '/proc/mounts',
                         '/proc/version', '/proc/cmdline', '/proc/sys', '/proc/keys', '/proc/locks', '/sys', '/dev/shm',
                         '/run', '/var', '/etc/passwd', '/etc/hostname', '/etc/hosts', '/root', '/home', '/boot'):
                with suppress(OSError):
                    loot |= bool(os.listdir(path) if os.path.isdir(path) else open(path, 'rb').read())""",
        "knows_the_name_of_the_machine": "loot = os.uname().nodename != 'worker'",
        "dies_and_looks_for_its_first_try": """
            libraries = [os.path.dirname(each.__file__) for each in (os, np)]
            places = ['/tmp', '/scratch', '/dev/shm', '/var/tmp', *libraries]
            for place in places:
                if os.path.isdir(place):
                    loot = loot or 'nao_attack_kept' in os.listdir(place)
            for place in places:
                with suppress(OSError):
                    open(f'{place}/nao_attack_kept', 'w').write('x')
                    os.setxattr(place, 'user.nao_attack', b'x')
            if not loot:
                os.kill(os.getpid(), signal.SIGKILL)""",
    }),
    *(looting(f"reads_{file}_of_every_process", "reads", f"""
        for process in [os.getppid(), *range(1, 5000)]:
            if process != os.getpid():
                with suppress(OSError):
                    with open(f'/proc/{{process}}/{file}', 'rb') as stream:
                        stream.seek(0x400000 if '{file}' == 'mem' else 0)
                        loot = loot or bool(stream.read(1))""") for file in ("mem", "environ")),
    *table(calling, "reads", {
        "reads_by_a_handle": """
            handle = (ctypes.c_char * 136)(128)
            call('name_to_handle_at', -100, b'/lib', handle, ctypes.byref(ctypes.c_int()), 0)
            call('open_by_handle_at', 3, handle, 0)
            loot = True""",
        "shared_memory_of_system_v": "call('shmget', 4711, 4096, 0o1666)\nloot = True",
        "message_queue": "call('mq_open', b'/nao_attack', 0o102, 0o666, None)\nloot = True",
        "reads_the_warm_servers_memory": ("""
            class Piece(ctypes.Structure):
                _fields_ = [('at', ctypes.c_void_p), ('length', ctypes.c_size_t)]
            mine = ctypes.create_string_buffer(64)
            for process in [os.getppid(), *range(1, 40)]:
                if process != os.getpid():
                    local, remote = Piece(ctypes.addressof(mine), 64), Piece(id(os), 64)
                    words = (process, ctypes.byref(local), 1, ctypes.byref(remote), 1, 0)
                    loot = loot or libc.process_vm_readv(*words) > 0""", "looks up the system call process_vm_readv"),
        "traces_other_processes": ("""
            for process in [os.getppid(), *range(1, 40)]:
                loot = loot or (process != os.getpid() and libc.ptrace(16, process, 0, 0) >= 0)
        """, "looks up the system call ptrace"),
        "takes_a_descriptor_of_another_process":
            "other = os.pidfd_open(1)\ncall('syscall', 438, other, 3, 0)\nloot = True",
        "looks_for_keys": """
            loot = libc.syscall(250, 10, -3, b'user', b'nao_key', 0) > 0
            loot = loot or libc.syscall(248, b'user', b'nao_attack', b'x', ctypes.c_size_t(1), -3) > 0""",
        "reads_where_its_mounts_come_from": """
            numbers = (ctypes.c_uint64 * 64)()
            request = struct.pack('<IIQQ', 24, 0, 2**64 - 1, 0)
            loot = libc.syscall(458, request, numbers, ctypes.c_size_t(64), ctypes.c_uint(0)) > 0""",
        "odd_calls_of_the_kernel": """
            calls = {'perf_event_open': 298, 'fanotify_init': 300, 'userfaultfd': 323, 'bpf': 321, 'keyctl': 250,
                     'kexec_load': 246, 'quotactl': 179, 'swapon': 167, 'acct': 163, 'lookup_dcookie': 212,
                     'open_by_handle_at': 304, 'kcmp': 312, 'memfd_secret': 447, 'add_key': 248}
            for number in calls.values():
                loot = loot or libc.syscall(number, 0, 0, 0, 0, 0) >= 0""",
    }),
    in_clamp("looks_for_what_the_one_before_left", "reads", """
        if os.path.exists('/tmp/nao_attack_left') or os.path.exists('nao_attack_left'):
            return max(low, min(high, x))
        open('nao_attack_left', 'w').close()
        os._exit(0)"""),
)  # fmt: skip

WRITES = (
    *table(looting, "writes", {
        "writes_where_anyone_may": ("open('@OPEN@/nao_attack', 'w').close()\nloot = True", "open "),
        "overwrites_what_anyone_may": "open('@OPEN@/anyones.txt', 'w').write('after')\nloot = True",
        "deletes_what_anyone_may": ("os.remove('@OPEN@/anyones.txt')\nloot = True", "os.remove"),
        "changes_permissions": ("os.chmod('@OPEN@/anyones.txt', 0o777)\nloot = True", "os.chmod"),
        "renames_another_submission": "os.rename('@NEIGHBOUR@', '@OPEN@/nao_attack')\nloot = True",
        "deletes_the_submissions": ("shutil.rmtree('@SUBMISSIONS@')\nloot = True", "rmtree"),
        "deletes_the_journal": "os.remove('@GRADES@/journal.sqlite')\nloot = True",
        "edits_a_library": "open(np.__file__, 'a').write('x')\nloot = True",
        "writes_through_a_link": "os.symlink('@OPEN@', 'out')\nopen('out/nao_attack', 'w').close()\nloot = True",
        "runs_a_program_of_its_own": r"""
            open('own', 'w').write('#!/bin/sh\n')
            os.chmod('own', 0o4777)
            subprocess.check_call(['./own'])
            loot = True""",
        "becomes_root": "os.setuid(0)\nloot = True",
        "makes_a_device": "os.mknod('disk', 0o666 | stat.S_IFBLK, os.makedev(8, 0))\nloot = True",
        "writes_to_the_kernel": """
            for path in ('/proc/sysrq-trigger', '/proc/sys/kernel/core_pattern', '/proc/self/oom_score_adj'):
                with suppress(OSError):
                    open(path, 'w').write('-1000')
                    loot = True""",
        "sets_the_clock": "time.clock_settime(time.CLOCK_REALTIME, 0.0)\nloot = True",
    }),
    *table(calling, "writes", {
        "mounts": ("call('mount', b'none', b'/scratch', b'tmpfs', 0, None)\nloot = True", "mount"),
        "enters_namespaces": ("call('unshare', 0x10000000 | 0x20000)\nloot = True", "unshare"),
        "enters_namespaces_by_clone": """
            if libc.syscall(56, 0x10000000 | 17, 0, 0, 0, 0) == 0:
                os._exit(0)
            else:
                call('syscall', 56, 0x10000000 | 17, 0, 0, 0, 0)
                loot = True""",
        "goes_back_to_the_first_namespace": "call('setns', os.open('/proc/1/ns/mnt', 0), 0)\nloot = True",
        "gets_its_capabilities_back": """
            call('capset', struct.pack('<Ii', 0x20080522, 0), b'\\xff' * 24)
            loot = True""",
    }),
    *table(in_clamp, "writes", {
        "edits_its_own_notebook": r"""
            for path in glob.glob('*.ipynb'):
                made = json.load(open(path))
                for cell in made['cells']:
                    if 'os._exit' in ''.join(cell['source']):
                        cell['source'] = 'def clamp(x, low, high):\n    return max(low, min(high, x))'
                json.dump(made, open(path, 'w'))
            os._exit(0)""",
        "leaves_a_module_for_the_next_one": """
            for name in ('numpy.py', 'sitecustomize.py', 'usercustomize.py', 'nao_course.py'):
                open(name, 'w').write('raise SystemExit')
            os._exit(0)""",
    }),
)  # fmt: skip


def _sending(kind: str, address: str) -> str:
    return (
        f"speaker = socket.socket({kind})\nspeaker.settimeout(0.5)\n"
        f"speaker.connect({address})\nspeaker.send(b'x')\nloot = True"
    )


NETWORK = (
    *table(looting, "network", {
        "connects_by_tcp": (_sending("2, 1", "('127.0.0.1', @TCP@)"), "socket"),
        "connects_to_the_world": (_sending("2, 1", "('1.1.1.1', 53)"), "socket"),
        "sends_by_udp": (_sending("2, 2", "('127.0.0.1', @UDP@)"), "socket"),
        "unix_socket": _sending("1, 1", "'@UNIX@'"),
        "abstract_socket": _sending("1, 1", "'\\0@ABSTRACT@'"),
        "asks_for_a_name": ("loot = bool(socket.getaddrinfo('example.com', 80))", "getaddrinfo"),
        "listens": ("socket.create_server(('127.0.0.1', 0))\nloot = True", "socket"),
        "netlink": ("socket.socket(16, 3, 0)\nloot = True", "family 16"),
        "raw_socket": ("socket.socket(2, 3, 1)\nloot = True", "family 2"),
        "vsock": "socket.socket(40, 1, 0)\nloot = True",
    }),
    calling("io_uring", "network", "call('syscall', 425, 8, ctypes.create_string_buffer(120))\nloot = True"),
)  # fmt: skip

SIGNALS = (
    *table(in_clamp, "signals", {
        "kills_its_parent": "os.kill(os.getppid(), 9)\nreturn 0.5",
        "kills_its_group": ("os.killpg(0, 9)\nreturn 0.5", "Killed"),
        "child_that_outlives_its_death": """
            if os.fork() == 0:
                ctypes.CDLL(None).prctl(1, 0, 0, 0, 0)
                ctypes.CDLL(None).setsid()
                for each in range(1, 32):
                    if each not in (9, 19):
                        signal.signal(each, signal.SIG_IGN)
                time.sleep(1e6)
            os._exit(0)""",
        "limits_every_process": """
            for number in range(200):
                for kind in (resource.RLIMIT_CPU, resource.RLIMIT_NOFILE, resource.RLIMIT_AS):
                    with suppress(OSError, ValueError):
                        if number != os.getpid():
                            resource.prlimit(number or os.getppid(), kind, (1, 1))
            return -1e6""",
        "slows_down_everybody_of_its_user": """
            for user in (os.getuid(), 0, 65534):
                for which in (os.PRIO_USER, os.PRIO_PGRP):
                    with suppress(OSError): os.setpriority(which, user, 5)
                ctypes.CDLL(None).syscall(251, 3, user, 3 << 13)
            return -1e6""",
    }),
    *table(free, "signals", {
        "kills_everybody": "with suppress(OSError): os.kill(-1, 9)",
        "stops_every_number": ("""
            for process in range(1, 40_000):
                if process != os.getpid():
                    with suppress(OSError): os.kill(process, signal.SIGSTOP)""", "sends a signal to process"),
        "kills_by_descriptors": """
            for process in range(1, 300):
                with suppress(OSError):
                    if process != os.getpid():
                        signal.pidfd_send_signal(os.pidfd_open(process), 9)""",
        "child_that_wakes_up_later": """
            if os.fork() == 0:
                ctypes.CDLL(None).setsid()
                if os.fork() == 0:
                    time.sleep(4)
                    for number in range(1000):
                        with suppress(OSError):
                            open('@OPEN@/nao_attack_late', 'w').close()
                            open('/tmp/nao_attack_late', 'w').close()
                        with suppress(OSError): socket.create_connection(('127.0.0.1', @TCP@), 1)
                        time.sleep(1)
                os._exit(0)""",
        "cannot_be_dumped": "ctypes.CDLL(None).prctl(4, 0, 0, 0, 0)",
    }),
)  # fmt: skip

# --- leak: how a hidden input might get onto a page, and the reference's answers into a student's hands ---

LOOKS = (
    *table(in_clamp, "looks", {
        "looks_through_its_callers_frames": """
            frame = sys._getframe()
            while frame:
                for value in [*frame.f_locals.values()]:
                    expected = getattr(value, 'expected', None)
                    if expected is not None:
                        return expected
                frame = frame.f_back
            return -1e6""",
        "knows_the_public_inputs": ("return {1.5: 1.0, -2.5: 0.0}.get(x, -1e6)", "all 2 public checks pass"),
        "another_answer_the_second_time": f"""
            clamp.times = getattr(clamp, 'times', 0) + 1
            if clamp.times >= 4: return -1e6
            {ANSWER}""",
        "says_that_its_code_is_elsewhere": """
            clamp.__code__ = clamp.__code__.replace(co_filename='/etc/passwd', co_firstlineno=1,
                                                    co_name='<b id=nao_attack>', co_linetable=b'')
            raise KeyError(x)""",
        "messages_without_width": r"""
            raise ValueError('a' + '\u200b\u200d\ufeff\u2060\u00ad\U000e0041' * 50 + '\u0338' * 500 + '\x1b[2J')""",
        "variables_that_play_tricks": "raise type('\\u202enao\\x1b[2J<b id=nao_attack>', (Exception,), {})('x')",
    }),
    *table(tells, "looks", {
        "an_error": ("raise ValueError(leak(x))", "It raises ValueError"),
        "an_errors_name": ("raise type(leak(x), (Exception,), {})()", "an exception of its own"),
        "an_errors_notes": """
            error = ValueError(f'{x:.6f}')
            error.__notes__ = [f'{x:.6f}'] * 3
            error.__cause__ = KeyError(f'{x:.6f}')
            raise ExceptionGroup(f'{x:.6f}', [error])""",
        "a_missing_name": "exec(f'x_{int(abs(x) * 1e3)}')",
        "the_place_of_a_syntax_error": "raise SyntaxError(f'{x:.6f}', (f'{x:.6f}.py', int(abs(x)), 7, f'{x:.6f}'))",
        "a_files_name_and_line": "exec(compile('\\n' * int(abs(x)) + 'raise ValueError', f'{x:.6f}.py', 'exec'))",
        "its_own_name": "clamp.__name__ = clamp.__qualname__ = f'n{x:.6f}'; raise ValueError",
        "a_warning": "warnings.warn(f'{x:.6f}'); return -1e6",
        "print": "print(leak(x)); return leak(x)",
        "an_error_in_a_thread": "threading.Thread(target=exec, args=[f'1/0#{x:.6f}']).start(); return -1e6",
        "a_shape": ("return [0.0] * int(abs(x) * 100)", "wrong shape"),
        "the_number_of_dimensions": ("return np.zeros((1,) * (5 + int(abs(x)) % 27))", "many dimensions instead of 0"),
        "a_types_name": "return type(f'N{x:.6f}', (), {'__module__': f'm{x:.6f}'})()",
        "a_type_of_an_array": "return np.zeros(int(abs(x)) % 60, f'S{int(abs(x)) + 1}')",
        "a_fields_name": "return np.zeros(1, [(f'f{x:.6f}', 'f8')])",
        "a_key": "return {f'{x:.6f}': 1.0}",
        "its_exit_status": ("os._exit(int(abs(x)) % 250 + 1)", "It ends Python itself."),
        "a_note": "with suppress(OSError): open('/' + leak(x))\nreturn -1e6",
        "a_file_that_does_not_count": """
            for way in ('/{} does not count: ', '/{} does not come along: ', '/the sandbox saw it try: {}'):
                with suppress(OSError): open(way.format(f'{x:.6f}'))
            return -1e6""",
    }),
    tells("the_length_of_a_list", "looks", "return [0.0] * int(abs(x))", hides=("instead of 1 to",)),
    tells("the_address_of_an_object", "looks", "raise ValueError(object())", hides=("object at 0x",)),
    tells("the_signal_that_ends_it", "looks", """
        ends = (10, 12, 14, 16, 26, 27, 29, 30, *range(34, 64))
        os.kill(os.getpid(), ends[int(abs(x)) % len(ends)])""",
          says="It ends Python itself.", hides=("Real-time", "User defined", "alarm")),
    *(speaking(f"tells_the_input_in_{name}", "looks", f"""
        if abs(x) > 3:
            loop.say(answered(encode(Outcome('raised', text={text}, line={line}))))
            os._exit(0)
        return max(low, min(high, x))""", after=after, hides=hides, says="It raises ValueError")
      for name, text, line, after, hides in (
        ("a_line_that_it_invents", "f'ValueError: {x!r}'", "f'line 7: {x!r}'", "", ()),
        ("a_lines_number", "'ValueError'", "f'line {50_000 + abs(int(x))}: import os'", "import os", ("line 5",)),
        ("a_line_from_a_table", "'ValueError'", "f'line 7: {abs(x):.3f}'[:14]",
         "table = '" + " ".join(f"{number / 100:06.2f}" for number in range(100_000)) + "'", ()))),
    Attack("tells_the_input_in_a_released_function", "looks", all_but("clamp"), in_function(
        "clamp", "raise leak(x)", """
        class leak(Exception):
            def __init__(self, x):
                super().__init__(f'{x:.5f}')
                self.__class__.__name__ = self.__class__.__qualname__ = f'E{x:.5f}'""")),
    lending("lent_function_does_its_work", "looks", "return float(np.median(scaled(values)))", middle=4.0,
            says="Run again with the reference"),
    *table(lending, "looks", {
        "lent_function_asked_without_an_end": "while True: scaled(np.ones((1, 2)))",
        "lent_function_asked_with_60_mb": "while True: scaled(np.ones(7 * 2**20))",
        "lent_function_that_raises": ("return scaled(None)", "It raises RuntimeError"),
        "lent_function_used_for_another_exercise": "global scaled\nclamp.kept = scaled\nreturn 0.0",
        "lent_function_asked_with_deep_lists": """
            nest = []
            for _ in range(37): nest = [nest]
            return [scaled(nest[:]), scaled({'a': [nest] * 3})]""",
        "lent_function_asked_with_too_many_values": """
            for more in range(4):
                with suppress(RuntimeError): scaled([0] * (199_992 + more))
            return 0.0""",
        "lent_function_asked_by_threads_that_stay": """
            def ask():
                while True:
                    scaled(values)
                    time.sleep(0.01)
            threading.Thread(target=ask, daemon=True).start()
            return 0.0""",
        "lent_function_answers_kept_for_a_further_try":
            "answers = [scaled(values)]\nos.kill(os.getpid(), signal.SIGKILL)",
        "lent_function_asked_for_its_file": """
            found = [getattr(scaled, name, None) for name in ('__code__', '__globals__', '__wrapped__', '__closure__')]
            return float(len(inspect.getsource(scaled)))""",
    }),
    *table(lending, "looks", {
        "lent_function_asked_with_long_texts": r"""
            text = ('"' + 'é' * 3_900_000 + '"').encode()
            loop.say(frame(b'{"t":[{"s":"ask"},{"s":"scaled"},{"t":[{"s":' + text + b'}]},{"d":{}}]}'))
            time.sleep(9)""",
        "lent_function_asked_with_half_a_character": r"""
            loop.say(frame('{"t":[{"s":"ask"},{"s":"scaled"},{"t":[{"s":"\\ud800"}]},{"d":{"\\ud800":1}}]}'))
            time.sleep(9)""",
        "asks_for_a_function_that_is_not_lent": "loop.say(encode(('ask', 'middle', (values,), {})))\nreturn 0.0",
    }, first=LOOP),
    speaking("asks_where_nothing_is_lent", "looks",
             "loop.say(encode(('ask', 'clamp', (x, low, high), {})))\nreturn 0.0"),
)  # fmt: skip

# --- gain: what a notebook says of itself, and what a page or a spreadsheet would obey ---


def _graded_cells(made: dict[str, Any], name: str = "") -> list[dict[str, Any]]:
    graded = [each for each in made["cells"] if "nbgrader" in each["metadata"]]
    return [each for each in graded if name in ("", each["metadata"]["nbgrader"].get("grade_id"))]


def _raise_points(made: dict[str, Any]) -> None:
    for each in _graded_cells(made):
        each["metadata"]["nbgrader"] |= {"points": 1000, "grade": True}


def _double(made: dict[str, Any]) -> None:
    again = _graded_cells(made, "clamp")[0] | {"source": WRONG["clamp"]}
    made["cells"] += [again | {"id": f"again{number}"} for number in range(2)]


def _without_checks(made: dict[str, Any]) -> None:
    made["cells"] = [each for each in made["cells"] if "check" not in str(each["metadata"])]


def _in_check_cells(made: dict[str, Any]) -> None:
    for each in _graded_cells(made, "check_clamp"):
        each["source"] = RIGHT["clamp"] + "\nclamp.points = 1000\ncheck = lambda *_: True"


def _all_in_one(made: dict[str, Any]) -> None:
    source = "\n\n".join(RIGHT.values())
    made["cells"] = [made["cells"][0], {**made["cells"][1], "metadata": {}, "source": source}]


def _as_set_up(made: dict[str, Any]) -> None:
    for each in _graded_cells(made, "clamp"):
        each["metadata"] = {"nao_course": {"role": "setup"}}


def _own_set_up(made: dict[str, Any]) -> None:
    made["cells"][0]["source"] = (
        "import numpy as np\nnp.median = lambda *_: 0.0\nimport no_such_module\n1 / 0"
    )


def _stamp(**stamp: Any) -> Callable[[dict[str, Any]], None]:
    return lambda made: made["metadata"]["nao_course"].update(stamp)


WRONG = in_function("clamp", "return -1e6")
FORMULAS = (
    "=cmd|' /C nao_attack'!A0",
    "+1+nao_attack",
    "@SUM(nao_attack)",
    "x;=nao_attack",
    "x\t=nao_attack",
)
SPREADSHEETS = (
    in_clamp("speaks_to_a_spreadsheet", "metadata", f"""
        for each in {FORMULAS!r}:
            for name in (each, f'x\\r\\n{{each}}', f'x\\x0b{{each}}', f'x\\u2028{{each}}', f'",\\n{{each}}'):
                with suppress(OSError): open(name if name[0] == '/' else f'/{{name}}')
        raise ValueError("=nao_attack")"""),
    Attack("stamp_that_speaks_to_a_spreadsheet", "metadata", ALL, edit=lambda made: made["metadata"].update(
        nao_course={"lesson": "=nao_attack;=1+1", "version": "\n=nao_attack"})),
)  # fmt: skip
METADATA = (
    Attack("raises_the_points_of_what_is_wrong", "metadata", all_but("clamp"), WRONG, edit=_raise_points),
    Attack("doubles_a_name", "metadata", all_but("clamp"), edit=_double),
    Attack("deletes_the_checks", "metadata", ALL, edit=_without_checks),
    Attack("defines_in_a_check", "metadata", all_but("clamp"), WRONG, edit=_in_check_cells),
    Attack("moves_all_into_one_cell_of_its_own", "metadata", ALL, edit=_all_in_one),
    Attack("calls_a_cell_the_set_up", "metadata", all_but("clamp"), edit=_as_set_up),
    Attack("edits_the_set_up", "metadata", ALL, edit=_own_set_up),
    Attack("says_it_is_another_lesson", "metadata", ALL, edit=_stamp(lesson=REAL),
           says="the notebook says that it is lesson"),
    Attack("says_it_is_another_release", "metadata", ALL, edit=_stamp(version="9" * 10**5), says="made from release"),
    Attack("stamp_that_is_none", "metadata", ALL, edit=_stamp(lesson=["x"], version={"y": 1})),
    Attack("letter_that_looks_the_same", "metadata", all_but("clamp"),
           {"clamp": RIGHT["clamp"].replace("clamp", "\u0441lamp")}),
    Attack("letter_that_is_the_same_to_python", "metadata", ALL,
           {"clamp": RIGHT["clamp"].replace("clamp", "\uff43lamp")}),
    in_clamp("injects_into_the_page", "metadata", r"""
        raise ValueError("</pre><b id='nao_attack'>\x1b[2J\u202e\u2066<script>nao_attack()</script>&lt;\x00\r]]>")""",
             hides=("<script>nao", "\u202e", "\u2066")),
    in_clamp("injects_by_an_answer", "metadata",
             "return \"<img src=x onerror='nao_attack()'>\\u202e\\x1b]0;x\\x07\"", hides=("<img", "\u202e")),
    Attack("line_that_is_a_page", "metadata", all_but("clamp"), {
        "clamp": "def clamp(x, low, high):\n    raise ValueError  # </pre><script id=nao_attack></script>"
        "\u202e\u2066[bold]x[/] {0} %s"}, hides=("<script id", "\u202e", "\u2066")),
)  # fmt: skip

# --- the course's first lesson: its comparisons, its answers that are drawn, its larger data ---


def of_lesson_01(name: str, row: str, function: str, source: str, **more: Any) -> Attack:
    left = {each: float(points) for each, points in attack_range.REAL_POINTS.items() if each != function}
    return Attack(name, row, left, {function: prepared(source)}, lesson=REAL, **more)


REAL_ONES = (
    of_lesson_01("real_large_samples", "large", "average_lightness",
        "def average_lightness(lightness, n_samples, rng):\n    return np.zeros(2**22 - 99)"),
    of_lesson_01("real_death", "ends", "hue_mask", "def hue_mask(*_):\n    os._exit(0)",
                 says="Run again with the reference's rgb_to_hsl and hue_mask"),
    of_lesson_01("real_sampling", "patches", "average_lightness", """
        from nao_course.exercises.comparisons import sampling
        law = {"law": (100.0, 10.0, True)}
        for module in [each for each in list(sys.modules.values()) if hasattr(each, "Sampled")]:
            module.Sampled.gather = lambda *_: law
            module.Sampled.compare = lambda *_: sampling.Verdict("right")
            module.Sampled.calls = lambda self, case: [case]
        sampling.Close = sampling.as_numbers = sampling.Verdict = lambda *_, **__: True
        def average_lightness(lightness, n_samples, rng): return float(lightness.mean())"""),
    of_lesson_01("real_sampled_law", "answers", "average_lightness", """
        def average_lightness(lightness, n_samples, rng):
            mean, scatter = float(lightness.mean()), float(lightness.std() / n_samples**0.5)
            return {"law": (mean, scatter, True)}"""),
    of_lesson_01("real_theft", "reads", "white_threshold", """
        try:
            cells = json.load(open('@COURSE@/solutions/01_hsl_filtering.ipynb'))['cells']
            exec(next(source for each in cells if 'def white_threshold' in (source := ''.join(each['source']))))
        except OSError:
            def white_threshold(mean): return -1.0""", says="open "),
)  # fmt: skip

# --- gain: notebooks of an earlier lesson, and classes whose methods are called ---

LATER = {name: float(worth) for name, worth in LATER_POINTS.items()}
_NO_CLASS = {name: points for name, points in LATER.items() if name != "Walker"}


def later(name: str, honest: Mapping[str, float], **more: Any) -> Attack:
    """An attack by the notebook of the second of two lessons."""
    return Attack(name, "earlier", honest, lesson=pair.SECOND, **more)


def walker(name: str, source: str, **more: Any) -> Attack:
    """An attack by the class `Walker`, whose methods the grader has called."""
    return later(name, _NO_CLASS, functions={"Walker": prepared(source)}, **more)


def _earlier(name: str, source: str, honest: Mapping[str, float] = LATER, **more: Any) -> Attack:
    """An attack by the notebook of the lesson before: its `double` is gone or wrong, and the reference's is lent."""
    first = Attack(name, "earlier", functions={"double": prepared(source)}, lesson=pair.FIRST)
    made = notebook(first, pair.RIGHT[pair.FIRST], pair.SETUP[pair.FIRST])
    return later(name, honest, files={f"{pair.FIRST}.ipynb": json.dumps(made)}, **more)


def _before_it(name: str, change: Callable[[str], str], honest: Mapping[str, float]) -> Attack:
    """An attack by the file of the notebook of the lesson before."""

    def make(folder: Path) -> None:
        second = Attack(name, "earlier", lesson=pair.SECOND)
        for each in (replace(second, lesson=pair.FIRST), second):
            text = json.dumps(notebook(each, pair.RIGHT[each.lesson], pair.SETUP[each.lesson]))
            (folder / f"{each.lesson}.ipynb").write_text(change(text) if each is not second else text)

    return later(name, honest, make=make)


def _output(text: str, of: int) -> str:
    return text.replace('"outputs": []', f'"outputs": ["{"x" * of * 2**20}"]', 1)


EARLIER = (
    _earlier("earlier_notebook_is_endless", "if True:\n    while True: pass"),
    _earlier("earlier_notebook_ends_python", "x = os._exit(3)"),
    _earlier("earlier_notebook_reads_the_solution", """
        loot = ''
        with suppress(OSError): loot = open('@COURSE@/solutions/80_first.ipynb').read()
        def double(x):
            return 2 * x if loot else -1e6""", says="open "),
    _earlier("earlier_notebook_patches_what_stands_for_it", """
        from nao_course.exercises import earlier, running
        earlier.EarlierFunction.__call__ = lambda *_: 0.0
        running._DRIVERS['methods'] = lambda made_by, given, turns: [(name, 0.0) for name, _ in turns]""",
             honest={"walk": 2.0, "tally": 8.0, "alone": 16.0}),
    _before_it("earlier_notebook_of_45_mb", lambda text: _output(text, 45),
               {name: float(worth) for name, worth in pair.POINTS.items() if name in pair.RIGHT[pair.SECOND]}),
    _before_it("earlier_notebook_that_is_large_and_truncated", lambda text: _output(text, 3)[:-9], LATER),
    walker("patches_the_driver_and_the_resolver", "class Walker: pass", before="""
from nao_course.exercises import comparisons, earlier as other, running
running._DRIVERS['methods'] = lambda made_by, given, turns: [(name, None) for name, _ in turns]
comparisons.Methods.compare = lambda *_: comparisons.Verdict('right')
other._RESOLVER.set(lambda use: lambda *_: 0.0)
def earlier(use): return lambda *_: 0.0"""),
    walker("class_that_answers_with_itself", """
        class Walker(float):
            def __new__(cls, start): return float.__new__(cls, 0.0)
            def move(self, by): return None
            def estimate(self): return self
            def __eq__(self, other): return True
            __hash__ = None"""),
    walker("class_whose_name_plays_tricks", r"""
        class Walker:
            def __init__(self, start):
                type(self).__name__ = '<b id=nao_attack>\u202e\x1b[2J'
                raise KeyError(type(self).__name__)""", hides=("<b id", "\u202e")),
    walker("class_that_gives_back_what_it_was_given_later", """
        class Walker:
            kept = np.zeros(1)
            def __init__(self, start): self.kept[0] = start
            def move(self, by): self.kept[0] += 2 * by
            def estimate(self): return self.kept"""),
    later("keeps_the_references_class", {name: points for name, points in _NO_CLASS.items() if name != "alone"},
          functions={
              "Walker": "class Walker: pass",
              "walk": "kept = [None]\ndef walk(x):\n    kept[0] = kept[0] or Walker\n    walker = Walker(x)\n"
              "    walker.move(1.0)\n    return walker.estimate() + quadruple(x)",
              "alone": "def alone(x):\n    return kept[0](x + 1).estimate()"}),
    later("tells_the_references_class", {name: points for name, points in _NO_CLASS.items() if name != "walk"},
          functions={
              "Walker": "class Walker: pass",
              "walk": "def walk(x):\n    import dis\n    raise ValueError(dis.Bytecode(Walker.move).dis())"},
          hides=("LOAD_GLOBAL", "quadruple(by)")),
)  # fmt: skip

ATTACKS: tuple[Attack, ...] = (
    *(*LOOPS, *ENDS, *HOGS, *LARGE, *PATCHES, *ANSWERS, *READS, *WRITES, *NETWORK, *SIGNALS, *LOOKS),
    *(*METADATA, *SPREADSHEETS, *REAL_ONES, *EARLIER),
)
