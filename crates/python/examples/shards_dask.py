"""A survey of trisect, shared between the workers of a Dask cluster:

    python shards_dask.py RECORD.jsonl SHARDS stress --quick
    python shards_dask.py RECORD.jsonl SHARDS measure --mesh part.ply

Each shard is a task; where a worker dies, another takes its shards anew. TRISECT is the program on the workers, trisect
by default, and DASK_SCHEDULER the address of a cluster; without one, a cluster of processes on this machine is made.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from dask.distributed import Client

TRISECT = os.environ.get("TRISECT", "trisect")


def shard(index, count, command):
    """The record of one shard."""
    with tempfile.TemporaryDirectory() as folder:
        # `stress` takes a folder, and `measure` a file.
        output = folder if command[0] == "stress" else str(Path(folder, "record.jsonl"))
        subprocess.run([TRISECT, *command, "--shard", f"{index}/{count}", "--output", output], check=True)
        [record] = Path(folder).glob("*.jsonl")
        return record.read_bytes()


def main(output, count, *command):
    address = os.environ.get("DASK_SCHEDULER")
    with Client(address) if address else Client(threads_per_worker=1, dashboard_address=None) as client:
        tasks = [client.submit(shard, index, int(count), command) for index in range(1, int(count) + 1)]
        records = client.gather(tasks)
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder, f"{index}.jsonl") for index in range(len(records))]
        for file, record in zip(files, records):
            file.write_bytes(record)
        subprocess.run([TRISECT, "merge", *files, "--output", output], check=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
