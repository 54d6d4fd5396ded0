"""What trimesh's tests take from their module `generic`, which its source distribution leaves out, as it leaves out the
models: simple solids and a mesh of this project take the place of some, and tests of others are skipped."""

import logging
import os
import time
import unittest
from collections import deque
from pathlib import Path

import numpy as np
import pytest
import trimesh
import trimesh.grouping
import trimesh.transformations as tf
from shapely.geometry import Point, Polygon
from trimesh import Trimesh
from trimesh.constants import tol, tol_path

__all__ = ["Point", "Polygon", "Trimesh", "deque", "log", "np", "pytest", "random", "tf", "time", "tol", "tol_path"]
__all__ += ["trimesh", "unittest"]

log = logging.getLogger("trimesh")
has_binvox = False
random = np.random.default_rng(0).random
teapot = Path(os.environ["TRISECT_MESHES"]) / "teapot.ply"

MODELS = {
    "unit_cube.STL": lambda **how: trimesh.creation.box(**how),
    "unit_sphere.STL": lambda **how: trimesh.creation.icosphere(**how),
    "featuretype.STL": lambda **how: trimesh.creation.annulus(1.0, 2.0, 0.5, **how),
    "20mm-xyz-cube.stl": lambda **how: trimesh.creation.box([20, 20, 20], **how),
    "1002_tray_bottom.STL": lambda **how: trimesh.creation.box([10, 7, 0.5], **how),
    "teapot.stl": lambda **how: trimesh.load(teapot, **how),
}


def get_mesh(name, use_embree=True, **_):
    if name not in MODELS:
        pytest.skip(f"the source distribution leaves out {name}")
    return MODELS[name](use_embree=use_embree)


def get_meshes(count=2):
    return [get_mesh(name) for name in list(MODELS)[:count]]


def random_transforms(count, translate=1000):
    for _ in range(count):
        matrix = tf.random_rotation_matrix()
        matrix[:3, 3] = (random(3) - 0.5) * translate
        yield matrix


transforms = list(random_transforms(20))


class RandomSeed:
    def __enter__(self):
        return np.random.default_rng(0)

    def __exit__(self, *_):
        pass


class Data:
    def __getitem__(self, name):
        pytest.skip(f"the source distribution leaves out the data {name}")


data = Data()
