"""Rays shared between the processes of a Ray cluster: python ray_scene.py. It takes numpy, ray and trisect.

The scene is put into the object store once. An actor on each processor unpickles it, which builds its tree, and keeps it.
"""

import numpy as np
import ray

import trisect


@ray.remote(max_restarts=-1, max_task_retries=-1)
class Tracer:
    """A scene in a process of its own; where that dies, Ray starts another, which builds it again."""

    def __init__(self, scene):
        self.scene = scene

    def first(self, origins, directions):
        return self.scene.first(origins, directions, threads=1)


def main(workers=2):
    line = np.linspace(-1, 1, 200)
    x, y = np.meshgrid(line, line, indexing="ij")
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    scene = trisect.Scene(np.stack([x, y, np.sin(5 * x) * np.cos(5 * y)], -1).reshape(-1, 3), faces)

    random = np.random.default_rng(0)
    origins = np.column_stack([random.uniform(-1, 1, (100_000, 2)), np.full(100_000, 3.0)])
    directions = np.column_stack([random.uniform(-0.2, 0.2, (100_000, 2)), np.full(100_000, -1.0)])

    ray.init(num_cpus=workers, include_dashboard=False)
    stored = ray.put(scene)
    tracers = ray.util.ActorPool([Tracer.remote(stored) for _ in range(workers)])
    parts = zip(np.array_split(origins, 8), np.array_split(directions, 8))
    hits = list(tracers.map(lambda tracer, part: tracer.first.remote(*part), parts))
    ray.shutdown()

    triangle, t, u, v = (np.concatenate(column) for column in zip(*hits))
    alone = scene.first(origins, directions)
    assert all(np.array_equal(*pair) for pair in zip((triangle, t, u, v), alone)), "as in one process, bit for bit"
    print(f"{(triangle >= 0).sum()} of {len(t)} rays hit, by {workers} processes as by one")


if __name__ == "__main__":
    main()
