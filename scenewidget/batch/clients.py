"""Clients of Dask clusters, whoever's they are."""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

__all__ = ["check_where", "connected", "new_client", "patience_with"]

ANSWER = 10.0  # seconds for a scheduler to say that it is there, or to hear that a worker is not


def check_where(client: Any, n_workers: int | None) -> None:
    """ValueError, TypeError or ImportError if nobody can work there, as far as that shows without trying.

    Examples
    --------
    >>> check_where(None, -1)
    Traceback (most recent call last):
        ...
    ValueError: n_workers must be a whole number, 0 for this process alone, got -1
    """
    if n_workers is not None and (
        isinstance(n_workers, bool) or not isinstance(n_workers, int) or n_workers < 0
    ):
        raise ValueError(f"n_workers must be a whole number, 0 for this process alone, got {n_workers!r}")
    if client is None and n_workers == 0:
        return
    if importlib.util.find_spec("distributed") is None:
        raise ImportError(
            'several scans at a time want Dask: pip install "scenewidget[batch]"; '
            "or stay in this process with n_workers=0"
        )
    if client is not None and n_workers is not None:
        raise ValueError("n_workers is for a cluster of our own; with client= leave it out")
    if client is not None and not isinstance(client, str) and not hasattr(client, "scheduler"):
        raise TypeError(
            "client must be a dask.distributed Client or cluster, or the address of a scheduler, "
            f"got {type(client).__name__}"
        )
    if isinstance(client, str):
        _check_address(client)


def _check_address(address: str) -> None:
    from distributed.comm.addressing import parse_address, parse_host_port
    from distributed.comm.registry import get_backend

    try:
        scheme, place = parse_address(address)
        get_backend(scheme)
        if scheme in ("tcp", "tls"):
            parse_host_port(place)
    except ValueError as error:
        raise ValueError(
            "client must be the address of a scheduler, such as 'tcp://10.0.0.5:8786', "
            f"got {address!r}: {error}"
        ) from error


@contextlib.contextmanager
def connected(client: Any) -> Iterator[Any]:
    """A client of somebody's cluster for the length of a block; one that was given stays open.

    Parameters
    ----------
    client : distributed.Client, cluster or address

    Raises
    ------
    TypeError, ValueError
        Something that is none of them.
    ConnectionError
        No scheduler answers.

    Examples
    --------
    >>> with connected(3):
    ...     pass
    Traceback (most recent call last):
        ...
    TypeError: client must be a dask.distributed Client or cluster, or the address of a scheduler, got int
    """
    check_where(client, None)
    with contextlib.ExitStack() as stack:
        yield _client(client, stack)


def _client(given: Any, stack: contextlib.ExitStack) -> Any:
    from distributed import Client

    if isinstance(given, Client):
        if given.asynchronous:
            raise TypeError("client is asynchronous; give one that isn't, or the address of its scheduler")
        if given.status not in ("running", "connecting"):
            raise ConnectionError(f"client is {given.status}; give one that is open, or an address")
        return given
    address = getattr(given, "scheduler_address", given)
    to = address if getattr(given, "asynchronous", False) else given
    try:
        _ask(address)
        return stack.enter_context(new_client(to, timeout=ANSWER))
    except Exception as error:  # strangers at that port make for errors of any kind
        why = f"{type(error).__name__}: {str(error) or f'nothing in {ANSWER:.0f} s'}"
        raise ConnectionError(
            f"no Dask scheduler answers at {address!r} ({why}); check the address, "
            "or leave it out for workers on this machine"
        ) from error


def _ask(address: str) -> None:
    """Raise if no scheduler answers; a client of Dask would wait for ever for who listens and is silent."""
    if address.startswith("inproc"):  # of this very process
        return
    from distributed.comm.core import connect
    from distributed.security import Security

    make: Any = Security  # no types
    security = make()

    async def ask() -> None:
        reach: Any = connect
        comm = await reach(address, timeout=ANSWER, **security.get_connection_args("client"))
        try:
            await comm.write({"op": "identity", "reply": True, "n_workers": 0})
            await comm.read()
        finally:
            comm.abort()

    with ThreadPoolExecutor(1) as apart:  # from a loop that runs here, as in a notebook
        apart.submit(asyncio.run, asyncio.wait_for(ask(), ANSWER)).result()


def patience_with(cluster: Any) -> float:
    """Seconds for which it makes sense to wait for a first worker.

    Parameters
    ----------
    cluster : cluster or None
        None: nobody knows who brings workers to that scheduler.

    Returns
    -------
    seconds : float
        inf for a cluster that adapts or has asked for workers, since a queue takes as long as it takes.

    Examples
    --------
    >>> patience_with(None)
    30.0
    """
    if cluster is None:
        return 30.0
    asked = getattr(cluster, "worker_spec", True)  # kinds of clusters without it keep that elsewhere
    return math.inf if asked or getattr(cluster, "_adaptive", None) is not None else 5.0


def new_client(to: Any, **options: Any) -> Any:
    """A client that is nobody's default.

    Parameters
    ----------
    to : cluster or address
    **options
        As of ``distributed.Client``.

    Examples
    --------
    >>> new_client("tcp://127.0.0.1:9", timeout=0.1)  # doctest: +SKIP
    """
    import distributed

    make: Any = distributed.Client
    return make(to, set_as_default=False, **options)
