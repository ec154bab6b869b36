"""Conversion of Python values to bytes and back without pickle, for check data, worker processes and the grader.

The bytes form a frame: a JSON header, which describes the structure of the value, and the raw buffers of its arrays.
All lengths are checked against limits before memory is allocated, so that frames from untrusted code can be read.
"""

from nao_course.codec.format import PREFIX_SIZE, CodecError, Limits, frame_lengths
from nao_course.codec.reading import decode
from nao_course.codec.registry import register, register_function
from nao_course.codec.writing import encode

__all__ = [
    "PREFIX_SIZE",
    "CodecError",
    "Limits",
    "decode",
    "encode",
    "frame_lengths",
    "register",
    "register_function",
]
