"""Values as bytes and back, without pickle: what check data, workers and the grader speak.

A frame is a JSON header, which says what the value is made of, and the raw buffers of its arrays. Every length is
checked against limits before anything is allocated, so a frame from a stranger can be read.
"""

from nao_course.exercises.codec.format import PREFIX_SIZE, CodecError, Limits, frame_lengths
from nao_course.exercises.codec.reading import decode
from nao_course.exercises.codec.registry import register, register_function
from nao_course.exercises.codec.writing import encode

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
