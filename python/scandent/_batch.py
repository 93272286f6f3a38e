"""Items planned and simulated by the thousand: on threads, processes, or Ray."""

from __future__ import annotations

import json
import os
import uuid
from collections import deque
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, Callable, Deque, Dict, Iterable, Iterator, List, Mapping, Optional, Set, Tuple, Union

from . import _scandent
from ._arguments import PathLike, as_json, each, mapping, of, path
from ._errors import InputError
from ._plan import _callable
from ._simulation import load_mujoco

Row = Dict[str, Any]
#: A line, its number, the folder, and what to write beside the results.
_Job = Tuple[str, int, str, bool, bool]

#: The worker of this process and the run that it is of: it keeps the robots that it read.
_worker: Tuple[str, Optional[_scandent.Worker]] = ("", None)


def batch(
    items: Iterable[Mapping[str, Any]],
    folder: PathLike,
    *,
    executor: Union[None, str, Executor] = None,
    npz: bool = False,
    view: bool = False,
    progress: Optional[Callable[[Row], object]] = None,
) -> List[Row]:
    """Plans every item that is not done yet, each on one thread, as ``scandent batch`` does; returns their rows.

    ``items`` are mappings as the lines of its manifest (docs/python.md), each with a name of its own, ``item``.
    ``folder`` gets the manifest, ``items/NAME/`` and ``index.csv``. ``executor`` is one of
    ``concurrent.futures``; ``None`` for threads, one a processor; ``"ray"``, which starts Ray here, or the address
    of its cluster, ``"ray://HOST:PORT"`` (there ``folder`` is one that all nodes see): an actor a processor, which
    is started again where it dies. Every process reads a robot once. ``npz`` also writes every verified motion as
    arrays, ``view`` every page. ``progress`` is told each row as it comes.

    An item that fails is a row, ``"ended": "error"``; an item does not depend on where or in what order it
    ran. Raises ``InputError``.
    """
    place = Path(path(folder, "folder"))
    lines = _lines(items)
    _callable(progress)
    manifest = place / "manifest.jsonl"
    unfinished = manifest.with_name(f".manifest-{os.getpid()}")
    try:
        place.mkdir(parents=True, exist_ok=True)
        unfinished.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        os.replace(unfinished, manifest)
    except OSError as error:
        raise InputError(f"folder cannot be written: {error}", "folder") from None
    jobs: List[_Job] = [(line, n + 1, str(place.absolute()), npz, view) for n, line in enumerate(lines)]
    rows: Dict[int, Row] = {}
    for number, row in _run(jobs, executor):
        rows[number] = row
        if progress is not None:
            progress(row)
    _scandent.batch_index(str(manifest), str(place))
    return [rows[number] for number in sorted(rows)]


def _lines(items: Iterable[Mapping[str, Any]]) -> List[str]:
    lines: List[str] = []
    names: Set[str] = set()
    for number, item in enumerate(each(items, "items")):
        argument = f"items[{number}]"
        name = mapping(item, argument).get("item")
        if not isinstance(name, str) or name in names:
            raise InputError(f"{argument} has no name of its own: item = {name!r}", "items")
        names.add(name)
        lines.append(as_json(item, argument))
    return lines


def _work(run: str, job: _Job) -> Tuple[int, Row]:
    global _worker
    if _worker[0] != run:
        _worker = (run, _scandent.Worker())
    worker = _worker[1]
    assert worker is not None
    if "plan" in json.loads(job[0]):
        load_mujoco()
    row: Row = json.loads(worker.item(*job))
    return job[1], row


def _run(jobs: List[_Job], executor: Union[None, str, Executor]) -> Iterator[Tuple[int, Row]]:
    if isinstance(executor, str):
        if executor != "ray" and not executor.startswith("ray://"):
            raise InputError(f"executor = {executor!r}: neither \"ray\" nor \"ray://…\"", "executor")
        yield from _on_ray(jobs, None if executor == "ray" else executor)
    elif executor is None:
        # The native half lets go of the interpreter: threads do.
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            yield from _on_executor(jobs, threads)
    else:
        yield from _on_executor(jobs, of(executor, Executor, "executor"))


def _on_executor(jobs: List[_Job], executor: Executor) -> Iterator[Tuple[int, Row]]:
    waiting, run = iter(jobs), uuid.uuid4().hex
    # Few at a time are handed over: memory stays flat, and Ctrl-C does not wait for all.
    running: Set[Future[Tuple[int, Row]]] = set()
    ahead = 2 * (os.cpu_count() or 1)
    try:
        while True:
            while len(running) < ahead and (job := next(waiting, None)) is not None:
                running.add(executor.submit(_work, run, job))
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        for future in running:
            future.cancel()


def _on_ray(jobs: List[_Job], address: Optional[str]) -> Iterator[Tuple[int, Row]]:
    try:
        import ray
    except ImportError:
        raise InputError("executor: Ray is not installed: pip install 'scandent[ray]'", "executor") from None
    if not ray.is_initialized():
        try:
            ray.init(address=address, log_to_driver=False)
        except (ConnectionError, ValueError) as error:
            raise InputError(f"executor = {address!r}: {error}", "executor") from error
    count = min(len(jobs), int(ray.cluster_resources().get("CPU", 1)))
    # What an actor had in hand when it died is done again by the one that takes its place.
    actor = ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=-1)(_Actor)
    idle: Deque[Any] = deque(actor.remote() for _ in range(count))
    waiting = iter(jobs)
    running: Dict[Any, Any] = {}
    while True:
        while idle and (job := next(waiting, None)) is not None:
            free = idle.popleft()
            running[free.work.remote(job)] = free
        if not running:
            return
        (done, *_), _ = ray.wait(list(running), num_returns=1)
        idle.append(running.pop(done))
        yield ray.get(done)


class _Actor:
    """A process of Ray's that does items one after the other."""

    def __init__(self) -> None:
        self.run = uuid.uuid4().hex

    def work(self, job: _Job) -> Tuple[int, Row]:
        """What came of an item."""
        return _work(self.run, job)
