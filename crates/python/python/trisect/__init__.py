"""Rays against triangle meshes: the first hit, whether there is any, all of them, how many, and whether points are inside.

>>> import numpy as np, trisect
>>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
>>> scene = trisect.Scene(vertices, [[0, 1, 2]])
>>> scene.first([[0.25, 0.5, 1.0], [2.0, 2.0, 1.0]], [0.0, 0.0, -1.0]).triangle
array([ 0, -1], dtype=int32)

`trisect.trimesh` puts it under trimesh, and `trisect.open3d` has the names of open3d's `RaycastingScene`.
"""

from ._scene import AllHits, Hits, Located, Scene
from ._trisect import __version__

__all__ = ["AllHits", "Hits", "Located", "Scene", "__version__"]
