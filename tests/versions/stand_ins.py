"""Stand-ins for the packages that pyodide's npm package does not contain: every name in them is an empty class."""

import importlib.abc
import importlib.machinery
import sys
from types import ModuleType

PACKAGES = {"IPython", "cv2", "ipywidgets", "matplotlib", "mpmath", "nbformat", "numpy", "scipy", "sympy"}


class Kind(type):
    """A class whose attributes are classes of the same kind, and which can stand in a type."""

    def __getattr__(cls, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return kind(name)

    def __getitem__(cls, key):
        return cls


class Value:
    """What a stand-in returns: a value that can be calculated with."""

    def __init__(self, *values, **names):
        pass

    def __call__(self, *values, **names):
        return self

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return Value()

    def __neg__(self):
        return self


for _name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv", "pow", "getitem"):
    setattr(Value, f"__{_name}__", lambda self, other: self)


def kind(name):
    return Kind(name, (Value,), {})


class StandIn(ModuleType):
    """A module or package of stand-ins."""

    __path__ = ()

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        made = kind(name)
        setattr(self, name, made)  # so that `is` and issubclass work
        return made


class Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Find the packages that are left out."""

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in PACKAGES:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec):
        return StandIn(spec.name)

    def exec_module(self, module):
        pass


def install():
    """Let imports of the packages that are left out succeed."""
    sys.meta_path.insert(0, Finder())
