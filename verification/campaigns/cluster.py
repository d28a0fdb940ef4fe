"""Work spread over a Dask cluster (extra ``saoflow[cluster]``). Its workers need saoflow, the same version of it."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from saoflow.diagnosis import refusal
from verification.campaigns.fingerprint import code_digest

T = TypeVar("T")
R = TypeVar("R")

AHEAD = 3
"""Items that wait or run for each thread of the cluster."""
PATIENCE = "15s"
"""Until a scheduler that does not answer is given up."""


class Cluster:
    """A connection to a Dask scheduler. Raises DiagnosisError E605 (no ``distributed``) and E806."""

    def __init__(self, address: str) -> None:
        self.address = address
        self._client = _connected(address)
        self.threads = sum(self._client.ncores().values())
        if not self.threads:
            self.close()
            raise _unusable(address, "it has no workers", "start one: dask worker ADDRESS")
        odd = {where for where, digest in self._client.run(code_digest).items() if digest != code_digest()}
        if odd:
            self.close()
            raise _unusable(
                address,
                f"{len(odd)} of its workers have another saoflow: {', '.join(sorted(odd)[:3])}",
                "install the same version everywhere",
            )

    def close(self) -> None:
        """Leave the cluster; it goes on."""
        self._client.close()

    def spread(self, work: Callable[[T], R], items: Iterable[T], lost: Callable[[T], R]) -> Iterator[tuple[T, R]]:
        """As `pool.spread`: an item whose worker dies goes to another, and is ``lost`` once several have died of it."""
        distributed = _distributed()
        source = iter(items)
        pending: dict[Any, T] = {}
        arrived = distributed.as_completed([], loop=self._client.loop)
        try:
            while True:
                while len(pending) < AHEAD * self.threads:
                    try:
                        item = next(source)
                    except StopIteration:
                        break
                    future = self._client.submit(work, item, pure=False)
                    pending[future.key] = item
                    arrived.add(future)
                if not pending:
                    return
                future = next(arrived)
                item = pending.pop(future.key)
                try:
                    result = future.result()
                except distributed.KilledWorker:
                    result = lost(item)
                future.release()
                yield item, result
        finally:
            arrived.clear()


def _distributed() -> Any:
    try:
        return importlib.import_module("distributed")
    except ImportError:
        raise refusal(
            "E605",
            "`--dask` needs the package distributed",
            cause="distributed is not installed",
            remedy="pip install 'saoflow[cluster]', or leave out --dask",
        ) from None


def _connected(address: str) -> Any:
    client = _distributed().Client
    try:
        return client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        cause = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise _unusable(
            address, cause, "name the address that `dask scheduler` prints, such as tcp://127.0.0.1:8786"
        ) from None


def _unusable(address: str, cause: str, remedy: str) -> Exception:
    return refusal("E806", f"the cluster at {address} cannot be used", cause=cause, remedy=remedy)
