"""What an answer says: the number, the list, the word or the arrays in it, whatever form it came in.

``UnreadableError`` carries the sentence that the student gets.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np
from scipy import sparse

__all__ = [
    "UnansweredError",
    "UnreadableError",
    "arrays",
    "number",
    "numbers",
    "refuse_nothing",
    "rows",
    "word",
]

LONGEST = 10_000  # entries of a list, far more than any question asks for
MOST, DEEPEST = 200_000, 8  # entries of a list of lists, and lists in lists
LONGEST_TEXT = 300

_SIGNS = str.maketrans({"^": "**", "·": "*", "×": "*", "−": "-", "–": "-", "÷": "/", ":": "/"})
_WORDS = {
    "½": "(1/2)",
    "¼": "(1/4)",
    "¾": "(3/4)",
    "⅓": "(1/3)",
    "⅔": "(2/3)",
    "²": "**2",
    "√": "sqrt ",
    "π": "pi ",
}
_OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_FUNCTIONS = {"sqrt": math.sqrt, "log": math.log, "ln": math.log, "exp": math.exp}
_FRAME = "'\"`*$≈~“”„‘’«»"  # what people put around an answer
_NAMED = r"\b[^\W\d]\w*\s*[=≈]"  # "x ="
_AND = ("and", "&")
_CONSTANTS = {"pi": math.pi, "e": math.e}


class UnreadableError(Exception):
    """The answer has not the form that was asked for."""


class UnansweredError(Exception):
    """There is no answer yet."""


def number(answer: Any) -> float:
    """A finite number from a number, a fraction, a text or something with one entry.

    Examples
    --------
    >>> from fractions import Fraction
    >>> [number(answer) for answer in (0.25, "1/4", "25 %", [Fraction(1, 4)], np.array([[0.25]]), "¼ m")]
    [0.25, 0.25, 0.25, 0.25, 0.25, 0.25]
    >>> number("x ≈ 45°"), number(sparse.eye_array(1))
    (45.0, 1.0)
    """
    answer = _plain(answer)
    refuse_nothing(answer)
    if isinstance(answer, (bool, np.bool_)):
        raise UnreadableError("a number is asked for, not True or False")
    if isinstance(answer, (str, bytes)):
        return _finite(_calculated(_text(answer)))
    if isinstance(answer, type) or (callable(answer) and not hasattr(answer, "__float__")):
        raise UnreadableError("a number is asked for, not a function: call it, and give what it returns")
    if isinstance(answer, (int, float)):
        return _finite(answer)
    if isinstance(answer, np.ndarray) or hasattr(answer, "__iter__"):
        entries = list(islice(_entries(answer), 2))
        if len(entries) != 1:
            raise UnreadableError("one number is asked for, not several")
        return number(entries[0])
    if isinstance(answer, (complex, np.complexfloating)):
        if answer.imag != 0:
            raise UnreadableError("a real number is asked for, that one has an imaginary part")
        return _finite(answer.real)
    return _finite(answer)


def numbers(answer: Any) -> list[float]:
    """Finite numbers from any list, array, set, mapping's values or text; a single one is a list of one.

    Examples
    --------
    >>> numbers("1, 1/2; 3"), numbers({"a": 1, "b": (2,)}), numbers(np.arange(2))
    ([1.0, 0.5, 3.0], [1.0, 2.0], [0.0, 1.0])
    >>> numbers("a = 2 and b = 3")
    [2.0, 3.0]
    """
    answer = _plain(answer)
    refuse_nothing(answer)
    if isinstance(answer, (str, bytes)):
        text = re.sub(_NAMED, " ", _text(answer)).strip(f"[](){{}} {_FRAME}")
        return [number(part) for part in re.split(r"[,;\s]+", text) if part and part.casefold() not in _AND]
    if not hasattr(answer, "__iter__") or (isinstance(answer, np.ndarray) and answer.ndim == 0):
        return [number(answer)]
    found = list(islice(_entries(answer), LONGEST + 1))
    if len(found) > LONGEST:
        raise UnreadableError("that is a very long list: far fewer numbers are asked for")
    return [number(entry) for entry in (sorted(found) if isinstance(answer, (set, frozenset)) else found)]


def word(answer: Any) -> str:
    """A text in small letters, without quotes and spaces around.

    Examples
    --------
    >>> word(" 'Right  Tip' "), word(["More."]), word({"answer": "“yes”"})
    ('right tip', 'more', 'yes')
    """
    answer = _plain(answer)
    refuse_nothing(answer)
    if isinstance(answer, (str, bytes)):
        return " ".join(_text(answer).casefold().strip(f" \t\n.,;!{_FRAME}").split())
    is_list = isinstance(answer, np.ndarray) or (hasattr(answer, "__iter__") and not isinstance(answer, type))
    entries = list(islice(_entries(answer), 2)) if is_list else []
    if len(entries) != 1:
        raise UnreadableError('a word is asked for, in quotes, such as "this"')
    return word(entries[0])


def arrays(result: Any, shapes: tuple[tuple[int, ...], ...]) -> tuple[np.ndarray[Any, Any], ...]:
    """Dense float arrays of these shapes; a diagonal matrix will do for its diagonal, and a column for a row.

    Examples
    --------
    >>> arrays((sparse.eye_array(2), np.diag([1, 2])), ((2, 2), (2,)))[1].tolist()
    [1.0, 2.0]
    """
    if len(shapes) == 1:
        return (_array(result, shapes[0]),)
    if not isinstance(result, (tuple, list)) or len(result) != len(shapes):
        raise UnreadableError(f"{len(shapes)} things are asked for: return a tuple of {len(shapes)}")
    return tuple(_array(part, shape) for part, shape in zip(result, shapes, strict=True))


def rows(result: Any) -> np.ndarray[Any, Any]:
    """A float array with two columns from pairs in any list, set or array.

    Examples
    --------
    >>> rows({(0, 1)}).tolist(), rows((i, i + 1) for i in range(2)).tolist()
    ([[0.0, 1.0]], [[0.0, 1.0], [1.0, 2.0]])
    """
    result = _plain(result)
    if not isinstance(result, np.ndarray):
        if not hasattr(result, "__iter__") or isinstance(result, (str, bytes, Mapping)):
            raise UnreadableError("pairs are asked for, in a list or an array with two columns")
        listed = list(islice(iter(result), LONGEST + 1))
        if len(listed) > LONGEST:
            raise UnreadableError("that is a very long list: far fewer pairs are asked for")
        result = np.asarray([list(islice(iter(pair), 3)) for pair in listed], dtype=np.float64)
    if result.size and (result.ndim != 2 or result.shape[1] != 2):
        raise UnreadableError("pairs are asked for, in a list or an array with two columns")
    if result.size > 2 * LONGEST:
        raise UnreadableError("that is a very long list: far fewer pairs are asked for")
    return _real(result)


def _array(result: Any, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
    if isinstance(result, Iterator):
        result = list(islice(result, LONGEST))
    _n_entries(result)
    if getattr(result, "shape", None) is None:
        result = np.asarray(result)
    wanted, got = " × ".join(map(str, shape)) or "one number", " × ".join(map(str, result.shape))
    is_diagonal = len(shape) == 1 and result.shape == shape * 2
    if math.prod(result.shape) != math.prod(shape) and not is_diagonal:
        raise UnreadableError(f"of shape {wanted} is asked for, yours is {got or 'a single number'}")
    dense = result.toarray() if sparse.issparse(result) else np.asarray(result)
    if dense.dtype == object or dense.dtype.kind not in "biufc":
        dense = dense.astype(np.float64)  # fractions, whole numbers of any size; texts that are numbers
    if is_diagonal:
        if np.count_nonzero(dense - np.diag(np.diagonal(dense))):
            raise UnreadableError("a diagonal is asked for, yours has entries beside it")
        dense = np.diagonal(dense)
    return _real(dense).reshape(shape)


def _real(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """As floats; what has an imaginary part is told."""
    if array.dtype.kind == "c":
        if np.any(array.imag):
            raise UnreadableError("real numbers are asked for, yours have an imaginary part")
        array = array.real
    found: np.ndarray[Any, Any] = array.astype(np.float64)
    return found


def _plain(answer: Any) -> Any:
    """An array for what is as good as one, sparse matrices and tables among it, unless it is huge."""
    is_sparse = sparse.issparse(answer)
    if type(answer) is np.ndarray or not (is_sparse or hasattr(answer, "__array__")):
        return answer
    if isinstance(answer, (type, np.generic)):
        return answer
    if np.ma.is_masked(answer):
        raise UnreadableError("nothing may be masked in it")
    if math.prod(getattr(answer, "shape", ())) > MOST:
        raise UnreadableError("that is a very long list: far fewer entries are asked for")
    return answer.toarray() if is_sparse else np.asarray(answer)


def _n_entries(result: Any, depth: int = 0) -> int:
    """Entries of a list and of the lists in it, before NumPy is asked to write them all out."""
    if hasattr(result, "shape") or isinstance(result, (str, bytes)) or not hasattr(result, "__len__"):
        return 1
    if len(result) <= LONGEST and depth < DEEPEST:
        n = 1
        for part in result:
            n += _n_entries(part, depth + 1)
            if n > MOST:
                break
        else:
            return n
    raise UnreadableError("that is a very long list: far fewer entries are asked for")


def refuse_nothing(answer: Any) -> None:
    """Raise `UnansweredError` for what is no answer yet: ..., None, an empty text, list or array.

    Examples
    --------
    >>> refuse_nothing(0)
    >>> refuse_nothing([])
    Traceback (most recent call last):
    scenewidget.exercises.reading.UnansweredError
    """
    if answer is None or answer is ...:
        raise UnansweredError
    if isinstance(answer, (str, bytes)):
        if not answer.strip():
            raise UnansweredError
    elif isinstance(answer, np.ndarray):
        if answer.size == 0:
            raise UnansweredError
    elif hasattr(answer, "__len__") and len(answer) == 0:
        raise UnansweredError


def _entries(answer: Any) -> Iterator[Any]:
    if isinstance(answer, np.ndarray):
        return iter(answer.reshape(-1)[: LONGEST + 1])
    if isinstance(answer, Mapping):
        return iter(answer.values())
    several: Iterable[Any] = answer
    return iter(several)


def _text(answer: str | bytes) -> str:
    if len(answer) > LONGEST_TEXT:
        raise UnreadableError("that is a very long text: a short one is asked for")
    return answer.decode("utf-8", "replace") if isinstance(answer, bytes) else answer


def _finite(value: Any) -> float:
    try:
        found = float(value)
    except OverflowError:
        raise UnreadableError("that number is too large to be meant") from None
    except Exception:
        raise UnreadableError("that can't be read as a number") from None
    if not math.isfinite(found):
        raise UnreadableError(
            "a finite number is asked for: something was divided by 0, or is not a number (NaN)"
        )
    return found


def _calculated(text: str) -> float:
    """A formula in numbers; a unit after it is taken off."""
    for sign, meaning in _WORDS.items():
        text = text.replace(sign, meaning)
    text = re.sub(_NAMED, "", text.translate(_SIGNS)).strip(f" {_FRAME}").rstrip("° ")
    share = 0.01 if text.endswith("%") else 1.0
    text = re.sub(r"(?<=\d),(?=\d)", ".", text.rstrip("% "))
    text = re.sub(r"sqrt\s+(\d+(?:\.\d+)?|pi)", r"sqrt(\1)", text)
    text = re.sub(r"(?<=[\d)])\s*(?=(?:pi|sqrt)\b)", "*", text)
    without_unit = re.sub(r"\s*(?:1?/)?[^\W\d]+(?:\*\*\d)?$", "", text)
    for attempt in (text, without_unit):
        try:
            return share * float(_value(ast.parse(attempt.strip(), mode="eval").body))
        except Exception:
            continue
    raise UnreadableError("that text can't be read as a number")


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return float(node.value)
    if isinstance(node, ast.Name):
        return _CONSTANTS[node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.UAdd, ast.USub)):
        return _value(node.operand) * (-1 if isinstance(node.op, ast.USub) else 1)
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_value(node.left), _value(node.right))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1:
        return _FUNCTIONS[node.func.id](_value(node.args[0]))
    raise ValueError("no number")
