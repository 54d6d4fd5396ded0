"""trisect in the place of trimesh's ray tracer.

One line before meshes are made, and everything in trimesh that casts rays goes through it: `mesh.ray`, `mesh.contains`,
`trimesh.proximity`, thickness and reach, copies and submeshes, and pyvista's `multi_ray_trace`.

>>> import trimesh, trisect.trimesh
>>> trisect.trimesh.install()
>>> mesh = trimesh.creation.box()
>>> mesh.ray.intersects_first([[0, 0, 2]], [[0, 0, -1]]) >= 0
array([ True])
>>> mesh.copy().contains([[0, 0, 0], [2, 0, 0]])
array([ True, False])
>>> trisect.trimesh.uninstall()
"""

from __future__ import annotations

import sys
import types
from typing import Any

import numpy as np
import numpy.typing as npt
import trimesh
import trimesh.ray
from trimesh import caching

from ._scene import Hits, Scene

__all__ = ["RayMeshIntersector", "install", "uninstall"]


class RayMeshIntersector:
    """Casts rays at a mesh of trimesh, as its own classes of this name do, in f64 and without rounding.

    Parameters
    ----------
    geometry : trimesh.Trimesh
        The mesh; the scene follows when it changes.
    scale_to_box : bool
        Without effect: nothing has to be scaled to be right.
    method : "exact", "fast" or "watertight"
        As of `trisect.Scene`.
    """

    def __init__(self, geometry: Any, scale_to_box: bool = True, *, method: Any = "exact") -> None:
        self.mesh = geometry
        self._scale_to_box = scale_to_box
        self._method = method
        self._cache = caching.Cache(id_function=self.mesh.__hash__)

    @caching.cache_decorator
    def scene(self) -> Scene:
        """The scene of the mesh as it is now."""
        mesh = self.mesh
        vertices, faces = (np.asarray(array).view(np.ndarray) for array in (mesh.vertices, mesh.faces))
        return Scene(vertices, faces, precision="f64", method=self._method)

    def intersects_id(
        self,
        ray_origins: npt.ArrayLike,
        ray_directions: npt.ArrayLike,
        multiple_hits: bool = True,
        max_hits: int | None = None,
        return_locations: bool = False,
    ) -> tuple[npt.NDArray[Any], ...]:
        """The triangles that rays hit, (m,), and the rays that hit them, (m,), ray by ray, the nearest first.

        Where a ray goes through an edge or a corner that triangles share, one of them counts. Every hit, unless `max_hits` of each ray are enough, or the first alone without `multiple_hits`. With
        `return_locations` also where, (m, 3) float64. Raises `ValueError` for shapes other than (n, 3).
        """
        origins, directions = _rays(ray_origins, ray_directions)
        if multiple_hits:
            hits, ray = _crossings(self.scene, origins, directions)
            if max_hits is not None:
                kept = np.arange(len(ray)) - np.searchsorted(ray, ray) < max_hits
                hits, ray = _of(hits, kept), ray[kept]
        else:
            first = self.scene.first(origins, directions)
            ray = np.flatnonzero(first.triangle >= 0)
            hits = _of(first, ray)
        triangle = hits.triangle.astype(np.int64)
        return (triangle, ray, self.scene.points(hits)) if return_locations else (triangle, ray)

    def intersects_location(
        self, ray_origins: npt.ArrayLike, ray_directions: npt.ArrayLike, multiple_hits: bool = True, **options: Any
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
        """Where rays hit, (m, 3) float64, and the rays and the triangles, (m,) each: as `intersects_id`."""
        triangle, ray, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits=multiple_hits, return_locations=True, **options
        )
        return locations, ray, triangle

    def intersects_first(self, ray_origins: npt.ArrayLike, ray_directions: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """The first triangle that each ray hits, (n,), −1 where there is none."""
        return self.scene.first(*_rays(ray_origins, ray_directions)).triangle.astype(np.int64)

    def intersects_any(self, ray_origins: npt.ArrayLike, ray_directions: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether each ray hits anything, (n,)."""
        return self.scene.any(*_rays(ray_origins, ray_directions))

    def contains_points(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether each of `points`, (n, 3), is inside of the mesh, decided exactly; those on its surface are not.

        The mesh has to be closed.
        """
        points = np.asarray(points, np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points must have shape (n, 3), not {points.shape}")
        return self.scene.contains(points)

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        state.pop("_cache", None)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._cache = caching.Cache(id_function=self.mesh.__hash__)

    def __copy__(self) -> RayMeshIntersector:
        return type(self)(self.mesh, self._scale_to_box, method=self._method)

    def __deepcopy__(self, memo: dict[int, Any]) -> RayMeshIntersector:
        return self.__copy__()


def _of(hits: Hits, which: npt.NDArray[Any]) -> Hits:
    return Hits(*(array[which] for array in hits))


def _crossings(scene: Scene, *rays: npt.NDArray[Any]) -> tuple[Hits, npt.NDArray[np.int64]]:
    """All hits and their rays, with one triangle where several share the edge or corner that is hit."""
    every = scene.all(*rays)
    hits, ray = Hits(*every[1:]), every.ray
    is_first = np.ones(len(ray), bool)
    is_first[1:] = (ray[1:] != ray[:-1]) | (hits.t[1:] != hits.t[:-1])
    if is_first.all() or scene.method != "exact":
        return hits, ray
    # Of what lies at one point those that own their crossing, or the first where none does: at a border, or where the
    # surface turns back. Hits of coincident triangles are all owned.
    point = np.cumsum(is_first) - 1
    tied = np.unique(ray[~is_first])
    owned = scene.all(*(array[tied] for array in rays), crossings="owned")
    is_owned = np.isin(ray * len(scene) + hits.triangle, tied[owned.ray] * len(scene) + owned.triangle)
    is_owned |= ~np.isin(ray, tied)
    has_owner = np.bincount(point, is_owned)[point] > 0
    kept = is_owned | (is_first & ~has_owner)
    return _of(hits, kept), ray[kept]


def _rays(origins: npt.ArrayLike, directions: npt.ArrayLike) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    o, d = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
    if o.shape != d.shape or o.ndim != 2 or o.shape[1] != 3:
        raise ValueError(f"ray origins and directions must both have shape (n, 3), not {o.shape} and {d.shape}")
    return o, d


_NAME = "trimesh.ray.ray_pyembree"
# What was there before, while this tracer is installed.
_before: list[tuple[Any, bool, Any]] = []


def install() -> None:
    """Puts this tracer in the place of the one that trimesh prefers: of every mesh that is made, copied or cut out of
    another from now on, unless it is made with `use_embree=False`. A mesh that there is already gets it by
    `mesh.ray = trisect.trimesh.RayMeshIntersector(mesh)`, or by being copied. embreex need not be there."""
    if _before:
        return
    # As a module, since trimesh imports it as one.
    module = types.ModuleType(_NAME, "trisect in the place of embreex.")
    module.RayMeshIntersector = RayMeshIntersector  # type: ignore[attr-defined]
    _before.append((trimesh.ray.ray_pyembree, trimesh.ray.has_embree, sys.modules.get(_NAME)))
    trimesh.ray.ray_pyembree, trimesh.ray.has_embree = module, True
    sys.modules[_NAME] = module


def uninstall() -> None:
    """Puts back what was there before `install`, for meshes that are made from now on."""
    if _before:
        trimesh.ray.ray_pyembree, trimesh.ray.has_embree, module = _before.pop()
        if module is None:
            del sys.modules[_NAME]
        else:
            sys.modules[_NAME] = module
