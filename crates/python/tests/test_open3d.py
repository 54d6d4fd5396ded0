"""The names of open3d, against open3d where it is there."""

import importlib.util

import numpy as np
import pytest

import meshes
from trisect.open3d import RaycastingScene


def two_meshes():
    vertices, faces = meshes.sphere(3)
    return [(vertices.astype(np.float32), faces.astype(np.uint32)),
            ((0.5 * vertices + [0, 0, 1.5]).astype(np.float32), faces.astype(np.uint32))]


def rays(count=2000):
    return np.concatenate(meshes.random_rays(count), axis=1).astype(np.float32)


@pytest.fixture
def scene():
    scene = RaycastingScene()
    assert [scene.add_triangles(*mesh) for mesh in two_meshes()] == [0, 1]
    return scene


def test_shapes_and_dtypes(scene):
    hits = scene.cast_rays(rays(60).reshape(3, 4, 5, 6))
    assert {name: (array.dtype.name, array.shape) for name, array in hits.items()} == {
        "t_hit": ("float32", (3, 4, 5)), "geometry_ids": ("uint32", (3, 4, 5)), "primitive_ids": ("uint32", (3, 4, 5)),
        "primitive_uvs": ("float32", (3, 4, 5, 2)), "primitive_normals": ("float32", (3, 4, 5, 3)),
    }
    missed = scene.cast_rays(np.array([[9, 9, 9, 0, 0, 1]], np.float32))
    assert missed["geometry_ids"] == missed["primitive_ids"] == RaycastingScene.INVALID_ID
    assert np.isinf(missed["t_hit"].numpy()) and not missed["primitive_normals"].any()
    assert not RaycastingScene().test_occlusions(rays(5)).any()


def test_what_would_be_rounded_is_refused(scene):
    with pytest.raises(ValueError, match="must be float32, not float64"):
        scene.cast_rays(rays(5).astype(np.float64))
    with pytest.raises(ValueError, match=r"rays must have shape \(..., 6\), not \(5, 5\)"):
        scene.cast_rays(rays(5)[:, :5])
    with pytest.raises(ValueError, match="nsamples"):
        scene.compute_occupancy(rays(5)[:, :3], nsamples=2)


def test_occlusions_have_intervals(scene):
    ray = np.array([[0.1, 0.2, -3, 0, 0, 1]], np.float32)
    t = scene.cast_rays(ray)["t_hit"].item()
    assert scene.test_occlusions(ray, tfar=t + 0.01).all() and not scene.test_occlusions(ray, tfar=t - 0.01).any()


def test_all_intersections_are_listed_by_geometry(scene):
    # Through the middles of both spheres.
    listed = scene.list_intersections(np.array([[9, 9, 9, 0, 0, 1], [0.01, 0.02, 5, 0, 0, -1]], np.float32))
    assert {name: (array.dtype.name, array.shape) for name, array in listed.items()} == {
        "ray_splits": ("uint32", (3,)), "ray_ids": ("uint32", (4,)), "t_hit": ("float32", (4,)),
        "geometry_ids": ("uint32", (4,)), "primitive_ids": ("uint32", (4,)), "primitive_uvs": ("float32", (4, 2)),
    }
    assert listed["ray_splits"].tolist() == [0, 0, 4] and listed["ray_ids"].tolist() == [1] * 4
    assert listed["geometry_ids"].tolist() == [1, 1, 0, 0]
    assert (np.diff(listed["t_hit"]) > 0).all()
    assert scene.count_intersections(np.array([[0.01, 0.02, 5, 0, 0, -1]], np.float32)).tolist() == [4]
    points = np.array([[0, 0, 0], [0, 0, 1.75], [0, 0, 2.5]], np.float32)
    inside = scene.compute_occupancy(points, nsamples=3)
    assert inside.dtype == np.float32 and inside.tolist() == [1, 1, 0]


def test_a_camera_sees_what_it_looks_at(scene):
    rays = RaycastingScene.create_rays_pinhole(
        fov_deg=90, center=[0, 0, 0], eye=[0, -4, 0], up=[0, 0, 1], width_px=9, height_px=5
    )
    assert rays.shape == (5, 9, 6) and rays.dtype == np.float32
    assert np.allclose(rays[2, 4], [0, -4, 0, 0, 1, 0], atol=1e-6)
    # Up is down, and the width is the field of view.
    assert (rays[0, 4, 5], rays[4, 4, 5]) == pytest.approx((-4 / 9, 4 / 9))
    assert (rays[2, 0, 3], rays[2, 8, 3]) == pytest.approx((8 / 9, -8 / 9))
    assert scene.cast_rays(rays)["geometry_ids"][2, 4] == 0
    with pytest.raises(ValueError, match="fov_deg"):
        RaycastingScene.create_rays_pinhole(width_px=2, height_px=2)


@pytest.mark.skipif(importlib.util.find_spec("open3d") is None, reason="open3d is not installed")
def test_open3d_agrees_on_random_rays(scene):
    import open3d

    other = open3d.t.geometry.RaycastingScene()
    for mesh in two_meshes():
        other.add_triangles(*map(open3d.core.Tensor, mesh))
    tensor = open3d.core.Tensor(rays())
    ours, theirs = scene.cast_rays(rays()), other.cast_rays(tensor)
    assert list(ours) != [] and set(ours) == set(theirs)
    for name, array in theirs.items():
        assert ours[name].dtype == array.numpy().dtype and ours[name].shape == array.numpy().shape
        # One near an edge may go to either side.
        assert (np.isclose(ours[name], array.numpy(), atol=1e-4)).mean() > 0.99, name
    assert (scene.test_occlusions(rays()) == other.test_occlusions(tensor).numpy()).mean() > 0.999
    assert (scene.count_intersections(rays()) == other.count_intersections(tensor).numpy()).mean() > 0.999
    listed, others = scene.list_intersections(rays()), other.list_intersections(tensor)
    assert set(listed) == set(others)
    for name, array in others.items():
        assert listed[name].dtype == array.numpy().dtype, name
    assert listed["ray_splits"][-1] == len(listed["t_hit"]) and len(listed["ray_splits"]) == len(rays()) + 1
    points = rays()[:, 3:].copy()
    ours, theirs = scene.compute_occupancy(points), other.compute_occupancy(open3d.core.Tensor(points)).numpy()
    assert ours.dtype == theirs.dtype and (ours == theirs).mean() > 0.999
    camera = dict(
        intrinsic_matrix=np.array([[50.0, 0, 32], [0, 50, 24], [0, 0, 1]]), extrinsic_matrix=np.eye(4) + np.eye(4, k=3),
        width_px=64, height_px=48,
    )
    other = dict(fov_deg=60, center=[0, 0.5, 0], eye=[1, 2, 3], up=[0, 1, 0], width_px=32, height_px=24)
    for camera in (camera, other):
        tensors = {name: open3d.core.Tensor(x) if isinstance(x, np.ndarray) else x for name, x in camera.items()}
        theirs = open3d.t.geometry.RaycastingScene.create_rays_pinhole(**tensors).numpy()
        assert np.allclose(RaycastingScene.create_rays_pinhole(**camera), theirs, atol=1e-6)
