# SPDX-License-Identifier: MIT
"""Loads the C library. Its declarations are read from the headers beside it, so that they cannot differ."""

from __future__ import annotations

import ctypes
import enum
import operator
import os
import pathlib
import re
from typing import Any, Optional, Union

import numpy as np

_folder = pathlib.Path(__file__).resolve().parent


class ErrorCode(enum.IntEnum):
    """What kind of error: phymul_c.h says more."""

    INVALID_ARGUMENT = 1
    UNKNOWN_NAME = 2
    FILE_ACCESS = 3
    FILE_FORMAT = 4
    INVALID_MODEL = 5
    NOT_SUPPORTED = 6
    DEVICE = 7
    OUT_OF_MEMORY = 8
    STEP_FAILED = 9
    INTERNAL = 10


class Error(RuntimeError):
    """Something was refused or failed. The message says what was expected and what came; `code` is for programs."""

    def __init__(self, message: str, code: ErrorCode = ErrorCode.INVALID_ARGUMENT) -> None:
        super().__init__(message)
        self.code = code


_scalars = {
    "int32_t": ctypes.c_int32,
    "uint32_t": ctypes.c_uint32,
    "uint64_t": ctypes.c_uint64,
    "double": ctypes.c_double,
    "phymul_status": ctypes.c_int32,
}
structs: dict[str, Any] = {}
constants: dict[str, int] = {}
_ranges = {
    ctypes.c_int32: (-(2**31), 2**31 - 1),
    ctypes.c_uint32: (0, 2**32 - 1),
    ctypes.c_uint64: (0, 2**64 - 1),
}
Builder = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.POINTER(ctypes.c_void_p))


def _type_of(words: str, is_array_pointer: bool) -> Any:
    if words.endswith("*") or is_array_pointer:
        return ctypes.c_char_p if words.replace(" ", "") == "constchar*" else ctypes.c_void_p
    if words == "phymul_run_parts":  # threads of a host, which Python has not
        return ctypes.c_void_p
    return Builder if words == "phymul_builder" else _scalars.get(words) or structs[words]


def _require_range(value: Any, kind: Any, what: str) -> None:
    """ctypes takes any integer and drops its upper bits."""
    low, high = _ranges[kind]
    try:
        fits = low <= operator.index(value) <= high
    except TypeError:
        fits = False
    if not fits:
        raise Error(f"{what}: expected an integer from {low} to {high}, got {value!r:.100}")


def encoded(text: Any) -> Any:
    """As C has it, bytes that are not UTF-8 included. Throws Error for a number, which ctypes takes for an address, and
    for a zero, at which C would end it."""
    data = text.encode(errors="surrogateescape") if isinstance(text, str) else text
    if not isinstance(data, (bytes, type(None))):
        raise Error(f"expected a name or path, got {text!r:.100}")
    if data and b"\0" in data:
        raise Error(f"expected a name or path without a zero in it, got {text!r:.100}")
    return data


def decoded(text: Optional[bytes]) -> str:
    return (text or b"").decode(errors="surrogateescape")


def _for_c(value: Any, kind: Any, what: str) -> Any:
    if kind in _ranges:
        _require_range(value, kind, what)
    return encoded(value) if kind is ctypes.c_char_p else value


class _Struct(ctypes.Structure):
    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, _for_c(value, dict(self._fields_)[name], name))


def _checked(function: Any, names: list[str]) -> Any:
    """The function, with as many arguments as it has, integers that fit their types and text as str."""
    types = function.argtypes

    def call(*arguments: Any) -> Any:
        if len(arguments) != len(types):  # ctypes takes more
            raise TypeError(f"{function.__name__}: expected {len(types)} arguments, got {len(arguments)}")
        return function(*map(_for_c, arguments, types, names))

    call.argtypes = types  # type: ignore[attr-defined]
    return call


def _read_header(text: str, loaded: ctypes.CDLL) -> None:
    text = re.sub(r"//[^\n]*", "", text)
    for body in re.findall(r"enum \{([^}]*)\}", text):
        constants.update((name, int(value)) for name, value in re.findall(r"PHYMUL_(\w+) = (\d+)", body))
    for body, name in re.findall(r"typedef struct \w+ \{([^}]*)\} (\w+);", text):
        fields = []
        for words, field, count in re.findall(r"([^;]*?)(\w+)(?:\[(\d+)\])?;", body):
            kind = _type_of(" ".join(words.split()), False)
            fields.append((field, kind * int(count) if count else kind))
        structs[name] = type(name, (_Struct,), {"_fields_": fields})
    for result, name, parameters in re.findall(r"PHYMUL_API ([\w* ]+?)(\w+)\(([^)]*)\);", text):
        function = getattr(loaded, name)
        types, names = [], []
        for parameter in parameters.split(","):
            match = re.fullmatch(r"(.*?)(\w+)(\[\d+\])?", " ".join(parameter.split()))
            if match and match[1]:
                types.append(_type_of(match[1].strip(), bool(match[3])))
                names.append(match[2])
        function.argtypes = types
        function.restype = {"void": None, "const char*": ctypes.c_char_p}.get(result.strip(), ctypes.c_int32)
        if result.strip() == "phymul_status":
            function.errcheck = _check
        setattr(loaded, name, _checked(function, names))


def _check(status: int, function: Any, arguments: Any) -> int:
    if status:
        raise Error(decoded(library.phymul_last_error()), ErrorCode(status))
    return status


library = ctypes.CDLL(str(_folder / "libphymul_c.so.1"))
for _name in ("phymul_c.h", "phymul_c_interaction.h"):
    _read_header((_folder / _name).read_text(encoding="utf-8"), library)


class Handle:
    """Owns an object of the C library and frees it with the last reference, those of views of its memory included."""

    def __init__(self, kind: str, pointer: Optional[int]) -> None:
        self.kind = kind
        self.pointer = pointer
        self.was_viewed = False
        self._free = getattr(library, f"phymul_{kind}_free")

    def __reduce__(self) -> Any:
        raise TypeError(f"a {self.kind} of the library cannot be copied or pickled")  # both would free it

    def __del__(self) -> None:
        if self.pointer:
            self._free(self.pointer)


def instance(value: Any, kind: type, what: str) -> Any:
    """Throws Error unless it is one: C would take the memory of any handle."""
    if not isinstance(value, kind):
        raise Error(f"{what}: expected a {kind.__name__}, got {value!r:.100}")
    return value


class Owner:
    """Base of the classes that own a handle. close() lets it go; afterwards every use is an Error."""

    _handle: Optional[Handle]

    @property
    def _own(self) -> Handle:
        if self._handle is None or self._handle.pointer is None:
            raise Error(f"this {type(self).__name__} is closed")
        return self._handle

    @property
    def _pointer(self) -> int:
        pointer = self._own.pointer
        assert pointer is not None
        return pointer

    def close(self) -> None:
        """Gives back the memory, as soon as no array is a view of it."""
        self._handle = None

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def make(kind: str, function: Any, *arguments: Any) -> Handle:
    """Calls a function whose last parameter is where the new handle goes."""
    made = ctypes.c_void_p()
    function(*arguments, ctypes.byref(made))
    return Handle(kind, made.value)


def text_of(function: Any, *arguments: Any) -> str:
    """Calls a function whose last parameter is where a string goes."""
    text = ctypes.c_char_p()
    function(*arguments, ctypes.byref(text))
    return decoded(text.value)


def lines_of(function: Any, *arguments: Any) -> list[str]:
    """The same of a list, a line each."""
    text = text_of(function, *arguments)
    return text.split("\n") if text else []


def sized(name: str, **fields: Any) -> Any:
    """A struct that begins with its size."""
    struct = structs[name](**fields)
    struct.size = ctypes.sizeof(struct)
    return struct


class _Memory:
    """What numpy needs to see memory of a handle, read-only, and to keep it alive."""

    def __init__(self, address: int, shape: tuple[int, ...], typestr: str, owner: Handle) -> None:
        self.owner = owner
        owner.was_viewed = True
        self.__array_interface__ = {"version": 3, "data": (address, True), "shape": shape, "typestr": typestr}


def view(address: Optional[int], shape: tuple[int, ...], typestr: str, owner: Handle) -> np.ndarray:
    """An array of the owner's memory, read-only."""
    return np.asarray(_Memory(address, shape, typestr, owner)) if address else np.zeros(shape, typestr)


def view_of(function: Any, owner: Handle, columns: int, typestr: str) -> np.ndarray:
    """The same of a function whose last parameters are where an array and its number of rows go."""
    address, count = ctypes.c_void_p(), ctypes.c_int32()
    function(owner.pointer, ctypes.byref(address), ctypes.byref(count))
    return view(address.value, (count.value, columns) if columns > 1 else (count.value,), typestr, owner)


def floats(values: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """As doubles, row by row; -1 in the shape: any number. Throws Error for another shape, and for other things."""
    try:
        if np.asarray(values).dtype.kind in "cSU":  # numpy drops imaginary parts, and reads text
            raise TypeError
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise Error(f"{what}: expected numbers of shape {_words(shape)}, got {values!r:.200}") from None
    if array.ndim != len(shape) or any(wanted not in (-1, got) for wanted, got in zip(shape, array.shape)):
        raise Error(f"{what}: expected numbers of shape {_words(shape)}, got the shape {array.shape}")
    return array


def integers(values: Any, columns: int, what: str) -> np.ndarray:
    """As 32-bit integers, [n] or [n][columns]. Throws Error for fractions: a cast would hide a mistake."""
    array = np.asarray(values)
    if array.size == 0:
        array = array.astype(np.int32).reshape((0, columns) if columns > 1 else (0,))
    wanted = 2 if columns > 1 else 1
    if array.dtype.kind not in "iu" or array.ndim != wanted or (wanted == 2 and array.shape[1] != columns):
        shape = _words((-1, columns) if columns > 1 else (-1,))
        raise Error(f"{what}: expected integers of shape {shape}, got {array.dtype} of the shape {array.shape}")
    if array.size and (array.min() < -(2**31) or array.max() >= 2**31):
        raise Error(f"{what}: expected integers of 32 bits, got {array.min()} to {array.max()}")
    return np.ascontiguousarray(array, dtype=np.int32)


def rows_of(chosen: Any, count: int, what: str) -> np.ndarray:
    """Rows by number, or by a mask of `count` booleans."""
    array = np.asarray(chosen)
    if array.dtype == bool:
        if array.shape != (count,):
            raise Error(f"{what}: expected a mask of shape ({count},), got the shape {array.shape}")
        array = np.flatnonzero(array)
    return integers(array, 1, what)


def _words(shape: tuple[int, ...]) -> str:
    return "(" + ", ".join("n" if size < 0 else str(size) for size in shape) + ("," if len(shape) == 1 else "") + ")"


def other_than_zero(value: Any, what: str) -> Any:
    """Throws Error for 0, which in C stands for a default."""
    if value == 0:
        raise Error(f"{what}: expected a number other than 0")
    return value


def cut_along(function: Any, body: int, point: Any, normal: Any, front: Any, out: Any) -> None:
    """Calls a function of a body, a plane, that of a front or none, and a place for the result."""
    if front is not None and len(front) != 2:
        raise Error(f"front: expected a point and a normal, got {front!r:.200}")
    planes = [floats(value, (3,), "a point or normal") for value in (point, normal, *(() if front is None else front))]
    function(body, *(value.ctypes.data for value in planes), *[None] * (4 - len(planes)), out)


def path_of(path: Union[str, "os.PathLike[str]"]) -> bytes:
    return os.fsencode(path)
