"""No public name or argument vanishes unnoticed: whoever takes one away has to touch the list as well."""

import public_api
import pytest


def split(line):
    name, _, rest = line.partition("(")
    return name, [word for word in rest.rstrip(")").split(", ") if word]


def missing(before, now):
    """What the lines of before promise and those of now don't keep."""
    known = dict(map(split, now))
    for name, wanted in map(split, before):
        if name not in known:
            yield name
            continue
        plain, _, _ = " ".join(wanted).partition("*")
        if known[name][: len(plain.split())] != plain.split():
            yield f"{name}: first arguments {plain}"
        yield from (f"{name}({word}=…)" for word in wanted if word not in known[name] and word != "*")


def test_every_name_and_argument_of_before_is_there():
    before = public_api.GOLDEN.read_text(encoding="utf-8").splitlines()
    assert len(before) > 200
    assert list(missing(before, public_api.public_api())) == []


@pytest.mark.parametrize(
    ("now", "said"),
    [
        (["f(a, *, b)"], []),
        (["f(a, c, *, b, d)"], []),
        (["g(a, *, b)"], ["f"]),
        (["f(a)"], ["f(b=…)"]),
        (["f(c, a, *, b)"], ["f: first arguments a "]),
    ],
)
def test_what_vanishes_is_named(now, said):
    assert list(missing(["f(a, *, b)"], now)) == said
