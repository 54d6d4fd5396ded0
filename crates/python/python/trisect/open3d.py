"""The names of open3d's `RaycastingScene`, over scenes that are never wrong; open3d need not be there.

>>> import numpy as np
>>> from trisect.open3d import RaycastingScene
>>> scene = RaycastingScene()
>>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
>>> scene.add_triangles(vertices, np.array([[0, 1, 2]], np.uint32))
0
>>> hits = scene.cast_rays(np.array([[0.25, 0.5, 1, 0, 0, -1], [2, 2, 1, 0, 0, -1]], np.float32))
>>> hits["t_hit"].numpy(), hits["primitive_ids"].numpy()
(array([ 1., inf], dtype=float32), array([         0, 4294967295], dtype=uint32))
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import joined, located, starts
from ._scene import AllHits, Hits, Scene

__all__ = ["RaycastingScene", "Tensor"]


class Tensor(np.ndarray[Any, np.dtype[Any]]):
    """An array, which also answers to `.numpy()` as a tensor of open3d does."""

    def numpy(self) -> npt.NDArray[Any]:
        """The array itself."""
        return self.view(np.ndarray)


class RaycastingScene:
    """Meshes that rays are cast at, as by `open3d.t.geometry.RaycastingScene`, in float32.

    Rays are arrays of shape (..., 6), float32: origin and direction. What is not float32 is an error, as there, since
    it would be rounded. `nthreads` is 0 for all processors. Closest points and distances are no rays, and are not here.

    Parameters
    ----------
    nthreads : int
        Of the build.
    method : "exact", "fast" or "watertight"
        As of `trisect.Scene`; `compute_occupancy` takes the exact one.
    """

    #: What stands for no geometry and no triangle.
    INVALID_ID = 4294967295

    def __init__(self, nthreads: int = 0, *, method: Any = "exact") -> None:
        self._threads, self._method = nthreads or None, method
        self._meshes: list[tuple[npt.NDArray[Any], npt.NDArray[Any]]] = []
        self._built: Scene | None = None
        self._starts = np.zeros(1, np.int64)
        self._normals = np.zeros((1, 3), np.float32)

    def add_triangles(self, vertex_positions: Any, triangle_indices: Any = None) -> int:
        """Adds a mesh, and returns its geometry id: the first is 0.

        `vertex_positions` is (n, 3) float32 and `triangle_indices` (m, 3) uint32; or a `TriangleMesh` of `open3d.t` is
        all there is. Raises `ValueError` for other shapes, and for coordinates that are not float32.
        """
        if triangle_indices is None:
            mesh = vertex_positions
            vertex_positions, triangle_indices = mesh.vertex["positions"], mesh.triangle["indices"]
        vertices = _float32("vertex_positions", vertex_positions, 3)
        faces = _array(triangle_indices)
        # Its faults are found here, where they are, not among all meshes.
        Scene(vertices, faces, threads=self._threads)
        self._meshes.append((vertices.copy(), faces.copy()))
        self._built = None
        return len(self._meshes) - 1

    def cast_rays(self, rays: Any, nthreads: int = 0) -> dict[str, Tensor]:
        """The first hit of each ray, arrays of the rays' shape: `t_hit` (float32, infinity for none), `geometry_ids` and
        `primitive_ids` (uint32, `INVALID_ID` for none), `primitive_uvs` (..., 2) and `primitive_normals` (..., 3), both
        float32."""
        rays = _float32("rays", rays, 6)
        scene = self._scene()
        hits = scene.first(rays[..., :3], rays[..., 3:], threads=nthreads or None)
        hits = Hits(*(np.asarray(array) for array in hits))
        geometry, primitive = self._ids(hits)
        return {
            "t_hit": _tensor(hits.t),
            "geometry_ids": geometry,
            "primitive_ids": primitive,
            "primitive_uvs": _tensor(np.stack([hits.u, hits.v], axis=-1)),
            "primitive_normals": _tensor(self._normals[hits.triangle]),
        }

    def test_occlusions(self, rays: Any, tnear: float = 0.0, tfar: float = np.inf, nthreads: int = 0) -> Tensor:
        """Whether each ray hits anything between `tnear` and `tfar`, as bool of the rays' shape."""
        rays = _float32("rays", rays, 6)
        threads = nthreads or None
        return _tensor(self._scene().any(rays[..., :3], rays[..., 3:], tmin=tnear, tmax=tfar, threads=threads))

    def count_intersections(self, rays: Any, nthreads: int = 0) -> Tensor:
        """How many triangles each ray hits, as int32 of the rays' shape."""
        rays = _float32("rays", rays, 6)
        return _tensor(self._scene().count(rays[..., :3], rays[..., 3:], threads=nthreads or None))

    def list_intersections(self, rays: Any, nthreads: int = 0) -> dict[str, Tensor]:
        """All hits of each ray, in order of `t`. Those of ray i are `ray_splits[i]` to `ray_splits[i + 1]` (uint32) of
        `ray_ids` (uint32), `t_hit` (float32), `geometry_ids`, `primitive_ids` (uint32), `primitive_uvs` (float32)."""
        rays = _float32("rays", rays, 6)
        hits: AllHits = self._scene().all(rays[..., :3], rays[..., 3:], threads=nthreads or None)
        geometry, primitive = self._ids(hits)
        return {
            "ray_splits": _tensor(hits.offsets.astype(np.uint32)),
            "ray_ids": _tensor(hits.ray.astype(np.uint32)),
            "t_hit": _tensor(hits.t),
            "geometry_ids": geometry,
            "primitive_ids": primitive,
            "primitive_uvs": _tensor(np.stack([hits.u, hits.v], axis=-1)),
        }

    def compute_occupancy(self, query_points: Any, nthreads: int = 0, nsamples: int = 1) -> Tensor:
        """Whether each of `query_points`, (..., 3) float32, is inside of the closed meshes: float32, 1 or 0, and 0 on the
        surface. Decided exactly, so that more than one of `nsamples` would not change it."""
        if nsamples < 1 or nsamples % 2 == 0:
            raise ValueError(f"nsamples must be odd and at least 1, not {nsamples}")
        points = _float32("query_points", query_points, 3)
        return _tensor(self._scene().contains(points, threads=nthreads or None).astype(np.float32))

    @staticmethod
    def create_rays_pinhole(
        *,
        width_px: int,
        height_px: int,
        intrinsic_matrix: Any = None,
        extrinsic_matrix: Any = None,
        fov_deg: float | None = None,
        center: Any = None,
        eye: Any = None,
        up: Any = None,
    ) -> Tensor:
        """Rays of a pinhole camera, (height, width, 6) float32, through the middles of its pixels: directions reach the
        plane at distance 1. The camera is given by its two matrices; or by its horizontal field of view, what it looks at,
        where it is, and where up is, which is down in the picture."""
        if fov_deg is not None:
            focal = 0.5 * width_px / np.tan(np.radians(0.5 * fov_deg))
            intrinsic_matrix = np.array([[focal, 0, 0.5 * width_px], [0, focal, 0.5 * height_px], [0, 0, 1]])
            center, eye, up = (np.asarray(_array(point), np.float64) for point in (center, eye, up))
            ahead = (center - eye) / np.linalg.norm(center - eye)
            aside = np.cross(up, ahead)
            aside /= np.linalg.norm(aside)
            extrinsic_matrix = np.eye(4)
            extrinsic_matrix[:3, :3] = aside, np.cross(ahead, aside), ahead
            extrinsic_matrix[:3, 3] = -extrinsic_matrix[:3, :3] @ eye
        elif intrinsic_matrix is None or extrinsic_matrix is None:
            raise ValueError("give intrinsic_matrix and extrinsic_matrix, or fov_deg, center, eye and up")
        turned = np.asarray(_array(extrinsic_matrix), np.float64)
        inverse = np.linalg.inv(np.asarray(_array(intrinsic_matrix), np.float64))
        x, y = np.meshgrid(np.arange(width_px) + 0.5, np.arange(height_px) + 0.5)
        directions = np.stack([x, y, np.ones_like(x)], axis=-1) @ (turned[:3, :3].T @ inverse).T
        origins = np.broadcast_to(-turned[:3, :3].T @ turned[:3, 3], directions.shape)
        return _tensor(np.concatenate([origins, directions], axis=-1).astype(np.float32))

    def _scene(self) -> Scene:
        """The scene of all meshes, one after another."""
        if self._built is None:
            vertices, faces = joined(self._meshes)
            self._built = Scene(vertices, faces, method=self._method, threads=self._threads)
            # Where the triangles of each mesh begin, and the normal of each; zeros, at the end, for none.
            self._starts = starts(len(faces) for _, faces in self._meshes)
            a, b, c = (vertices.astype(np.float64)[corner] for corner in faces.T)
            normals = np.cross(b - a, c - a)
            lengths = np.linalg.norm(normals, axis=1, keepdims=True)
            normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
            self._normals = np.concatenate([normals, np.zeros((1, 3))]).astype(np.float32)
        return self._built

    def _ids(self, hits: Hits | AllHits) -> tuple[Tensor, Tensor]:
        # −1 becomes INVALID_ID.
        geometry, primitive = located(self._starts, hits.triangle)
        return _tensor(geometry.astype(np.uint32)), _tensor(primitive.astype(np.uint32))


def _array(given: Any) -> npt.NDArray[Any]:
    """An array, of a tensor too."""
    return given.numpy() if hasattr(given, "numpy") else np.asarray(given)


def _tensor(array: npt.NDArray[Any]) -> Tensor:
    return np.asarray(array).view(Tensor)


def _float32(name: str, given: Any, columns: int) -> npt.NDArray[np.float32]:
    array = _array(given)
    if array.dtype != np.float32:
        raise ValueError(f"{name} must be float32, not {array.dtype}: trisect.Scene takes float64 without rounding it")
    if array.ndim < 1 or array.shape[-1] != columns:
        raise ValueError(f"{name} must have shape (..., {columns}), not {array.shape}")
    return array
