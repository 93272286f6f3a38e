"""Items planned by the thousand: on threads, processes, or Ray."""

from __future__ import annotations

import json
import os
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Set, Tuple, Union

from . import _scandent
from ._arguments import PathLike, path
from ._errors import InputError

Row = Dict[str, Any]
#: A line, its number, the folder, and what to write beside the results.
_Job = Tuple[str, int, str, bool, bool]


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
    ``concurrent.futures``; ``None`` for threads, one a processor; ``"ray"``, which starts Ray where it is, or
    the address of its cluster, ``"ray://…"`` (there ``folder`` is one that all nodes see). ``npz`` also writes
    every verified motion as arrays, ``view`` every page. ``progress`` is told each row as it comes.

    An item that fails is a row, ``"ended": "error"``; an item does not depend on where or in what order it
    ran. Raises ``InputError``.
    """
    place = Path(path(folder, "folder"))
    lines = _lines(items)
    place.mkdir(parents=True, exist_ok=True)
    manifest = place / "manifest.jsonl"
    unfinished = manifest.with_name(f".manifest-{os.getpid()}")
    unfinished.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    os.replace(unfinished, manifest)
    jobs: List[_Job] = [(line, n + 1, str(place), npz, view) for n, line in enumerate(lines)]
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
    for number, item in enumerate(items):
        argument = f"items[{number}]"
        if not isinstance(item, Mapping):
            raise InputError(f"{argument} is no mapping but a {type(item).__name__}", "items")
        name = item.get("item")
        if not isinstance(name, str) or name in names:
            raise InputError(f"{argument} has no name of its own: item = {name!r}", "items")
        names.add(name)
        try:
            lines.append(json.dumps(item, allow_nan=False))
        except (TypeError, ValueError) as error:
            raise InputError(f"{argument} cannot be written as JSON: {error}", "items") from None
    return lines


def _work(job: _Job) -> Tuple[int, Row]:
    row: Row = json.loads(_scandent.batch_item(*job))
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
        yield from _on_executor(jobs, executor)


def _on_executor(jobs: List[_Job], executor: Executor) -> Iterator[Tuple[int, Row]]:
    waiting = iter(jobs)
    # Few at a time are handed over: memory stays flat, and Ctrl-C does not wait for all.
    running: Set[Future[Tuple[int, Row]]] = set()
    ahead = 2 * (os.cpu_count() or 1)
    try:
        while True:
            while len(running) < ahead and (job := next(waiting, None)) is not None:
                running.add(executor.submit(_work, job))
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
        ray.init(address=address, log_to_driver=False)
    task = ray.remote(num_cpus=1)(_work)
    waiting = iter(jobs)
    ahead = 2 * int(ray.cluster_resources().get("CPU", 1))
    running: List[Any] = []
    while True:
        while len(running) < ahead and (job := next(waiting, None)) is not None:
            running.append(task.remote(job))
        if not running:
            return
        done, running = ray.wait(running, num_returns=1)
        yield from ray.get(done)
