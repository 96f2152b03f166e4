"""A campaign carried out: what is missing, in chunks, on threads or on a cluster."""

import json
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from pathlib import Path
from threading import Event

from parkproof import __version__
from parkproof.campaign.definition import Campaign, plain_of
from parkproof.campaign.directory import open_directory
from parkproof.campaign.prepare import prepare
from parkproof.campaign.rows import parquet_of
from parkproof.campaign.table import Range

Done = Callable[[int, int], None]
"""Called with the number of trials that have rows, and of those asked for."""

Results = Generator[tuple[Range, bytes]]
"""Ranges of trials and their rows, as they come."""

WORK = 2**27
"""Control periods of a chunk, about: a second or a few on one core."""

LARGEST, SMALLEST, PARTS = 16_384, 64, 16
"""Trials of a chunk at most and at least; chunks that even a short campaign falls into."""


def run_campaign(
    campaign: Campaign,
    directory: Path,
    *,
    where: str = "campaign",
    threads: int = 1,
    scheduler: str | None = None,
    progress: Done = lambda done, asked: None,  # noqa: ARG005
) -> None:
    """Carry out what a directory lacks of a campaign.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    directory : Path
        Where its rows are, or shall be; one row a trial in ``trials/*.parquet``.
    where : str
        What a message calls the campaign: its file's name.
    threads : int
        How many trials' chunks are worked on side by side; rows do not depend on it.
    scheduler : str, optional
        Address of a scheduler of `dask.distributed`, whose workers then do the work.
    progress : callable
        Called after each chunk with the number of trials done and asked for.

    Raises
    ------
    InputError
        If the campaign draws what is no scenario, the directory is not its own or cannot be written
        to, or the scheduler cannot be used. What has been written stays; the same call goes on.

    Examples
    --------
    >>> from parkproof.campaign.definition import campaign_from_dict
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10,
    ...      "run": {"duration": 1.0, "control_period": 0.01},
    ...      "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}},
    ...     where="example")
    >>> run_campaign(campaign, directory / "out")
    >>> [path.name for path in (directory / "out" / "trials").iterdir()]
    ['000000000000-000000000009.parquet']
    """
    prepare(campaign, where=where)
    if scheduler is None:
        _carry_out(
            campaign, directory, lambda text, chunks: on_threads(text, chunks, threads), progress
        )
        return
    from parkproof.campaign.cluster import connected, on_cluster

    with connected(scheduler) as client:
        _carry_out(
            campaign,
            directory,
            lambda text, chunks: on_cluster(text, chunks, client, scheduler),
            progress,
        )


def _carry_out(
    campaign: Campaign,
    directory: Path,
    engine: Callable[[str, Sequence[Range]], Results],
    progress: Done,
) -> None:
    """Have an engine carry out what is missing, and write what comes."""
    plain = plain_of(campaign)
    with open_directory(directory, plain) as opened:
        chunks = chunks_of(opened.missing(), chunk_size(campaign))
        done = campaign.trials - sum(end - begin for begin, end in chunks)
        progress(done, campaign.trials)
        with closing(engine(json.dumps(plain), chunks)) as results:
            for trials, content in results:
                opened.add(trials, content)
                done += trials[1] - trials[0]
                progress(done, campaign.trials)
        opened.note(finished=True)


def chunk_size(campaign: Campaign) -> int:
    """Trials of a chunk: enough work to be worth a task, few enough to be done soon.

    Parameters
    ----------
    campaign : Campaign
        The campaign; how it is carried out does not matter.

    Returns
    -------
    int
        A power of 2.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Scenario, Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.0, 0.0)),
    ...                     run=RunSettings(duration=15.0))
    >>> chunk_size(Campaign(scenario=scenario, quantities=(), trials=10**6, seed=0, draws="sobol"))
    8192
    """
    by_work = min(WORK // campaign.scenario.run.samples, LARGEST, campaign.trials // PARTS)
    return int(2 ** (max(by_work, SMALLEST).bit_length() - 1))


def chunks_of(missing: Sequence[Range], size: int) -> list[Range]:
    """Cut ranges of trials at the multiples of a size.

    Parameters
    ----------
    missing : sequence of (int, int)
        The ranges.
    size : int
        The size.

    Returns
    -------
    list of (int, int)
        In order.

    Examples
    --------
    >>> chunks_of([(3, 10), (12, 13)], 4)
    [(3, 4), (4, 8), (8, 10), (12, 13)]
    """
    chunks = []
    for first, last in missing:
        begin = first
        while begin < last:
            end = min(last, (begin // size + 1) * size)
            chunks.append((begin, end))
            begin = end
    return chunks


def on_threads(text: str, chunks: Sequence[Range], threads: int) -> Results:
    """Carry out chunks on threads of this process.

    Parameters
    ----------
    text : str
        The campaign, as `parkproof.campaign.prepare.prepared_from` takes it.
    chunks : sequence of (int, int)
        Ranges of trials.
    threads : int
        How many at once.

    Yields
    ------
    ((int, int), bytes)
        A range and its rows as a Parquet file, as they come. Not many wait to be taken. When the
        iterator is closed, work that was begun stops soon.

    Examples
    --------
    >>> list(on_threads("", [], 2))
    []
    """
    stop, waiting = Event(), iter(chunks)
    with ThreadPoolExecutor(threads) as pool:

        def submit() -> dict[Future[bytes], Range]:
            chunk = next(waiting, None)
            if chunk is None:
                return {}
            job = pool.submit(parquet_of, text, *chunk, version=__version__, stopped=stop.is_set)
            return {job: chunk}

        running: dict[Future[bytes], Range] = {}
        try:
            for _ in range(2 * threads):
                running |= submit()
            while running:
                finished, _ = wait(running, return_when=FIRST_COMPLETED)
                for job in finished:
                    chunk, content = running.pop(job), job.result()
                    running |= submit()
                    yield chunk, content
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)
