# SPDX-License-Identifier: GPL-3.0-or-later
"""Where runs are made: processes of this machine, a cluster that runs already, or jobs of Slurm. dask is imported here, on first use.

A worker is one process with one thread, and libraries in it use one thread each: a run gains more from a core of its own than from a share
of several.
"""

from __future__ import annotations

import logging
import math
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import Field

from masonry_cd.app.scene_text import parse_toml, read_text
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.fields import Count, Table
from masonry_cd.mechanics.solvers import cores

if TYPE_CHECKING:
    from distributed import Client

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
DEATHS = 10  # of workers that a run may cost before it counts as failed; a run that kills its worker does so each time
ANSWER = 10.0  # that a scheduler has to answer in [s]
SILENT = 300.0  # after which dask takes a worker for lost [s]
GIGABYTE = 1e9
SETTINGS = {
    "distributed.scheduler.allowed-failures": DEATHS,
    "distributed.comm.timeouts.connect": f"{ANSWER:g}s",
    "distributed.deploy.lost-worker-timeout": "1000h",  # a worker that starts again is not there for a while; it is not to be given up
    "distributed.admin.large-graph-warning-threshold": "1GB",
}


class SlurmTable(Table):
    """The file that ``--slurm`` names: what each job of Slurm asks for."""

    jobs: Count = Field(ge=1, le=100_000)
    """Number of jobs."""
    cores: Count = Field(ge=1, le=4096)
    """Cores of each job; each has a worker."""
    memory: str
    """Memory of each job: "32 GB"."""
    walltime: str = "24:00:00"
    """Walltime of each job."""
    queue: str | None = None
    """Partition."""
    account: str | None = None
    """Account that the time is charged to."""
    interface: str | None = None
    """Network interface by which workers reach the scheduler, "ib0"."""
    local_directory: str | None = None
    """Fast folder of a node, for files that come and go."""
    directives: list[str] = Field(default_factory=list)
    """Further lines of #SBATCH: "--constraint=avx2"."""
    prologue: list[str] = Field(default_factory=list)
    """Commands before the workers start: "source /home/me/venv/bin/activate"."""
    python: str | None = None
    """Interpreter of the nodes; this one's when not given."""


@dataclass(frozen=True)
class RunPlace:
    """Where the runs of a study are made; the first that is given counts, this machine when none is."""

    scheduler: str | None = None  # address
    slurm: Path | None = None  # file of a SlurmTable
    workers: int | None = None  # of this machine
    memory: float | None = None  # of each of them [GB]
    longest: float = 0.0  # that a run may keep its worker from answering [s]; then it is ended by the watchdog

    @property
    def patience(self) -> float:
        """How long to wait where there are no workers [s]: those of others may come at any time, ours start again within seconds."""
        return SILENT if self.scheduler is None and self.slurm is None else math.inf


@contextmanager
def connected(where: RunPlace) -> Iterator[tuple[Client, str]]:
    """A client of the cluster, and a line on it.

    Raises:
        InputError: a scheduler that does not answer, a bad file for Slurm.
    """
    import dask
    from distributed import Client

    for name in list(logging.root.manager.loggerDict):
        if name.startswith("distributed"):  # what it reports of lost workers and schedulers, the engine tells in a line
            logging.getLogger(name).setLevel(logging.CRITICAL)
    silent = {"distributed.scheduler.worker-ttl": f"{max(SILENT, where.longest + ANSWER):g}s"}
    with dask.config.set(SETTINGS | silent):
        if where.scheduler is not None:
            with _answering(where.scheduler) as client:
                yield client, f"workers of {where.scheduler}"
            return
        with _slurm(where.slurm) if where.slurm is not None else _local(where) as (cluster, words), Client(cluster) as client:
            yield client, words


@contextmanager
def _answering(address: str) -> Iterator[Client]:
    """A client of a scheduler that runs already."""
    from distributed import Client

    try:
        client = Client(address, timeout=ANSWER, set_as_default=True)
    except (OSError, ValueError) as failure:
        why = f"no scheduler answers there within {ANSWER:g} s" if isinstance(failure, OSError) else str(failure)
        raise InputError(f"--scheduler {address}", f"{why}; start one with: dask scheduler") from None
    try:
        yield client
    finally:
        client.close()


@contextmanager
def _local(where: RunPlace) -> Iterator[tuple[Any, str]]:
    """Workers on this machine."""
    from distributed import LocalCluster
    from distributed.system import MEMORY_LIMIT

    count = where.workers or cores()
    memory = MEMORY_LIMIT / max(count, cores()) if where.memory is None else where.memory * GIGABYTE
    cluster = LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        processes=True,
        memory_limit=int(memory),
        host="127.0.0.1",
        dashboard_address=":0",  # any port that is free
        silence_logs=logging.CRITICAL,
        env=ONE_THREAD,
        preload=["masonry_cd.studies.study.worker_setup"],
    )
    workers = f"{count} worker{'s' if count > 1 else ''} of this machine"
    try:
        yield cluster, f"{workers}, one thread and at most {memory / GIGABYTE:.1f} GB each"
    finally:
        cluster.close(timeout=10)


@contextmanager
def _slurm(file: Path) -> Iterator[tuple[Any, str]]:
    """Workers that are jobs of Slurm."""
    table = read_slurm(file)
    cluster = slurm_cluster(table)
    try:
        cluster.scale(jobs=table.jobs)
    except (OSError, RuntimeError) as failure:
        cluster.close()
        raise InputError(f"--slurm {file}", f"sbatch does not take the job: {failure}") from None
    try:
        yield cluster, f"{table.jobs} jobs of Slurm with {table.cores} workers each; they start as the queue lets them"
    finally:
        cluster.close()


def read_slurm(file: Path) -> SlurmTable:
    """The table of a file for Slurm.

    Raises:
        InputError: no such file, or a bad key, with its file.
    """
    if not file.exists():
        raise InputError(file, "no such file for --slurm")
    tables = parse_toml(read_text(file), file)
    try:
        return parse_table(SlurmTable, tables, "")
    except InputError as error:
        raise error.each(lambda fault: fault._replace(source=str(file))) from None


def require_slurm(file: Path) -> None:
    """Check, before anything runs, that jobs can be submitted as a file says.

    Raises:
        InputError: a bad file, dask-jobqueue is not installed, or this machine has no sbatch.
    """
    read_slurm(file)
    require("--slurm", "dask_jobqueue")
    if shutil.which("sbatch") is None:
        raise InputError("--slurm", "there is no sbatch on the PATH, so none is submitted here; --print-job shows the job")


def job_script(file: Path) -> str:
    """Return the script that a file for Slurm passes to sbatch; its last line has the address of a scheduler that ends with this call.

    Raises:
        InputError: a bad file, or dask-jobqueue is not installed.
    """
    with slurm_cluster(read_slurm(file)) as cluster:
        return str(cluster.job_script())


def slurm_cluster(table: SlurmTable) -> Any:
    """A scheduler in this process whose workers will be jobs of Slurm.

    Raises:
        InputError: dask-jobqueue is not installed.
    """
    require("--slurm", "dask_jobqueue")
    from dask_jobqueue import SLURMCluster

    given: dict[str, Any] = {"python": table.python} if table.python else {}
    return SLURMCluster(
        cores=table.cores,
        processes=table.cores,
        memory=table.memory,
        walltime=table.walltime,
        queue=table.queue,
        account=table.account,
        interface=table.interface,
        local_directory=table.local_directory,
        job_extra_directives=table.directives,
        job_script_prologue=[*table.prologue, *(f"export {name}={value}" for name, value in ONE_THREAD.items())],
        scheduler_options={"dashboard_address": ":0"},
        **given,
    )
