"""Scenes in other processes: Dask's, joblib's way of pickling, and a worker that dies."""

import multiprocessing
import os
import signal
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import meshes
import trisect

VERTICES, FACES = meshes.sphere(4)
RAYS = np.concatenate(meshes.random_rays(60_000), axis=1)


def first(rays, scene):
    """Rays of shape (n, 6) to rows of triangle, t, u, v."""
    return np.stack(scene.first(rays[:, :3], rays[:, 3:], threads=1), axis=1)


def test_a_pool_of_processes_answers_bit_for_bit():
    scene = trisect.Scene(VERTICES, FACES)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        parts = list(pool.map(first, np.array_split(RAYS, 4), [scene] * 4))
    assert np.concatenate(parts).tobytes() == first(RAYS, scene).tobytes()


def first_or_die(rays, scene, marker):
    """As `first`; but the first worker that comes here is killed in the middle."""
    try:
        os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return first(rays, scene)
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.fixture(scope="module")
def client():
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        yield client


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_dask_arrays_of_rays_answer_bit_for_bit(client, precision):
    dask_array = pytest.importorskip("dask.array")
    scene = trisect.Scene(VERTICES, FACES, precision=precision)
    rays = dask_array.from_array(RAYS, chunks=(7_000, 6))
    # One scene for each worker, not one for each block.
    scattered = client.scatter(scene, broadcast=True)
    hits = rays.map_blocks(first, scattered, dtype=np.float64, chunks=(rays.chunks[0], (4,)))
    assert hits.compute().tobytes() == first(RAYS, scene).tobytes()


def test_a_killed_worker_loses_nothing(client, tmp_path):
    scene = trisect.Scene(VERTICES, FACES)
    parts = np.array_split(RAYS, 8)
    futures = [client.submit(first_or_die, part, scene, str(tmp_path / "died"), pure=False) for part in parts]
    assert np.concatenate(client.gather(futures)).tobytes() == first(RAYS, scene).tobytes()
    assert (tmp_path / "died").exists()
