"""Numbers out of text, fast and in little memory: a token costs its eight bytes."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from scenewidget.engine.mesh import FloatArray, IntArray, MeshError

__all__ = [
    "as_utf8",
    "chunks",
    "numbers",
    "row_lengths",
    "rows",
    "whole_numbers",
    "without_remarks",
    "words_per_line",
]

CHUNK = 1 << 22  # bytes of text that are looked at together

_REMARK = re.compile(rb"(?<![.\d])#[^\n]*")
_WINDOWS_NAN = re.compile(rb"[-+]?\d\.#\w+")  # -1.#IND, 1.#QNAN: what old C libraries print for NaN


def numbers(block: bytes) -> FloatArray:
    """(n,) float64: all numbers of a text, ``block``, which blanks or line ends part.

    Raises
    ------
    MeshError
        Something else among them; the message quotes it.
    """
    return np.asarray(_parsed(without_remarks(block), np.float64))


def whole_numbers(block: bytes) -> IntArray:
    """(n,) int64: all whole numbers of a text, ``block``; see `numbers`."""
    return np.asarray(_parsed(block, np.int64))


def rows(pieces: Iterable[bytes]) -> tuple[FloatArray, IntArray]:
    """All numbers of a text that comes in pieces, and how many each line has; see `numbers`, `row_lengths`.

    Lines end with their piece. Memory is needed for one piece of text at a time.
    """
    values, widths, line = [np.empty(0)], [np.empty(0, dtype=np.int32)], 0
    for piece in map(without_remarks, pieces):
        count = words_per_line(piece)
        values.append(_parsed(piece, np.float64, line))
        widths.append(count[count > 0].astype(np.int32))
        line += len(count)
    return np.concatenate(values), np.concatenate(widths)


def without_remarks(block: bytes) -> bytes:
    """A text, ``block``, without what stands behind a #, and with the NaN of old C libraries as others do."""
    return _REMARK.sub(b"", _WINDOWS_NAN.sub(b"nan", block)) if b"#" in block else block


def as_utf8(data: bytes) -> bytes:
    """The text of a file, ``data``, without its byte order mark, in UTF-8 if it was UTF-16."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace").encode()
    return data.removeprefix(b"\xef\xbb\xbf")


def _parsed(block: bytes, dtype: type, line: int = 0) -> Any:
    if not block or block.isspace():
        return np.empty(0, dtype=dtype)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            return np.fromstring(block, dtype=dtype, sep=" ")
    except (ValueError, DeprecationWarning):
        raise MeshError(_complaint(block, dtype, line)) from None


def _complaint(block: bytes, dtype: type, before: int) -> str:
    kind = int if dtype is np.int64 else float
    for found in re.finditer(rb"\S+", block):
        token = found[0]
        try:
            if b"_" in token or b"x" in token.lower():
                raise ValueError
            kind(token)
        except ValueError:
            line = before + block.count(b"\n", 0, found.start()) + 1
            hint = "; decimals must have a point" if re.fullmatch(rb"-?\d+,\d+", token) else ""
            text = token[:40].decode("ascii", "replace")
            return f"is damaged: {text!r} stands where a number is expected (line {line} of its data{hint})"
    return "is damaged: its numbers can't be read"


def chunks(block: bytes | memoryview) -> Iterator[bytes]:
    """A text, ``block``, in pieces of some megabytes that end with their lines."""
    view = memoryview(block)
    start = 0
    while start < len(view):
        piece = bytes(view[start : start + CHUNK])
        if start + CHUNK < len(view):
            end = piece.rfind(b"\n") + 1
            piece = piece[:end] if end else bytes(view[start:])  # one endless line
        start += len(piece)
        yield piece


def row_lengths(block: bytes | memoryview) -> IntArray:
    """(n_rows,) how many words each line of ``block`` has; empty lines are left out."""
    found = [counts[counts > 0] for counts in map(words_per_line, chunks(block))]
    return np.concatenate(found) if found else np.empty(0, dtype=np.int64)


def words_per_line(piece: bytes) -> IntArray:
    """(n_lines,) how many words each line of a ``piece`` has, 0 for empty ones."""
    data = np.frombuffer(piece, dtype=np.uint8)
    is_start = data > 32
    is_start[1:] &= data[:-1] <= 32
    line = np.concatenate([[0], np.flatnonzero(data == 10) + 1])
    line = line[line < len(data)]
    return np.add.reduceat(is_start, line, dtype=np.int64) if len(line) else np.empty(0, dtype=np.int64)
