"""Whether a scene is sooner in another process as its mesh, from which the tree is built anew, or as its tree.

    python pickling.py [MESH.ply ...]

What scenes pickle to is the mesh and the settings. Of the tree no more is counted than its bytes: they are sent with the
mesh through the same pipe, and nothing is put together of them, so that no way of pickling trees could be quicker.
The last column is the speed of a connection at which both ways take as long: over slower ones the mesh is sooner there.
"""

import multiprocessing
import os
import pickle
import statistics
import sys
import time
from pathlib import Path

import numpy as np

import trisect

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "tests"))
import meshes

ROUNDS = 7


def arrive(pipe):
    """Unpickles what comes, and says when it is there."""
    while (sent := pipe.recv_bytes()) != b"end":
        pickle.loads(sent)
        pipe.send(time.perf_counter())


def sent(pipe, thing):
    """Seconds until a thing has been pickled, sent and unpickled."""
    start = time.perf_counter()
    pipe.send_bytes(pickle.dumps(thing, protocol=5))
    return pipe.recv() - start


def scenes(files):
    for divisions in (3, 5, 7):
        yield f"sphere, {8 * 4**divisions} triangles", meshes.sphere(divisions)
    for file in files:
        import trimesh

        mesh = trimesh.load(file, process=False)
        yield f"{Path(file).name}, {len(mesh.faces)} triangles", (np.array(mesh.vertices), np.array(mesh.faces))


def main(files):
    context = multiprocessing.get_context("spawn")
    pipe, other = context.Pipe()
    child = context.Process(target=arrive, args=(other,))
    child.start()
    print(f"{len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()} processors")
    print(f"{'':32}{'mesh, MB':>10}{'tree, MB':>10}{'as mesh, ms':>14}{'as tree, ms':>14}{'even at, MB/s':>16}")
    try:
        for name, (vertices, faces) in scenes(files):
            scene = trisect.Scene(np.float32(vertices), faces)
            mesh = scene.vertices, scene.faces
            tree = *mesh, np.random.default_rng(0).bytes(scene.statistics["bytes"])
            # In turn.
            times = [(sent(pipe, scene), sent(pipe, tree), sent(pipe, mesh)) for _ in range(ROUNDS)]
            as_mesh, as_tree, alone = (statistics.median(column) for column in zip(*times))
            sizes = [sum(array.nbytes for array in mesh) / 1e6, scene.statistics["bytes"] / 1e6]
            even = sizes[1] / (as_mesh - alone)
            print(f"{name:32}{sizes[0]:10.2f}{sizes[1]:10.2f}{as_mesh * 1e3:14.1f}{as_tree * 1e3:14.1f}{even:16.0f}")
    finally:
        pipe.send_bytes(b"end")
        child.join()


if __name__ == "__main__":
    main(sys.argv[1:])
