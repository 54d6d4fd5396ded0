"""Three jobs that rays do, each with a picture: python tutorial.py [FOLDER]. It takes numpy, matplotlib and trisect."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import trisect

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
folder.mkdir(parents=True, exist_ok=True)


def grid(x, y, z):
    """A mesh of the points of a grid, whose coordinates are arrays of one shape."""
    number = np.arange(z.size).reshape(z.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return np.stack([x, y, z], -1).reshape(-1, 3), faces


# %% 1. A laser scanner on an aircraft over terrain
# Coordinates in UTM are millions of metres. In float32 their steps are half a metre, wider than what is measured here;
# arrays of float64 stay float64.
east, north = 443_000 + np.arange(0, 600, 4.0), 5_411_000 + np.arange(0, 400, 4.0)
east, north = np.meshgrid(east, north, indexing="ij")
height = 310 + 30 * np.sin((east - 443_000) / 70) * np.cos((north - 5_411_000) / 50)
terrain = trisect.Scene(*grid(east, north, height))
print(terrain)

# The aircraft flies east, and its mirror swings to either side.
along, swing = np.meshgrid(np.linspace(443_010, 443_580, 500), np.radians(np.linspace(-35, 35, 300)), indexing="ij")
origins = np.stack([along, np.full_like(along, 5_411_200.0), np.full_like(along, 600.0)], -1)
directions = np.stack([np.zeros_like(swing), np.sin(swing), -np.cos(swing)], -1)
scan = terrain.first(origins, directions)
points = terrain.points(scan)
print(f"{(scan.triangle >= 0).mean():.1%} of {scan.t.size} pulses return; ranges {scan.t.min():.1f} to "
      f"{scan.t[np.isfinite(scan.t)].max():.1f} m")

plt.figure(figsize=(7, 4))
plt.scatter(points[..., 0] - 443_000, points[..., 1] - 5_411_000, c=points[..., 2], s=0.5)
plt.colorbar(label="height, m")
plt.gca().set(aspect="equal", xlabel="m east of 443,000", ylabel="m north of 5,411,000", title="returns of the scan")
plt.savefig(folder / "terrain.png", dpi=100)

# %% 2. How thick are the walls of a part?
# A bent tube: from each of its faces a ray goes inwards to the other side. `tmin` leaves out where the ray starts.
turn, round_ = np.meshgrid(np.linspace(0, 1.5 * np.pi, 200), np.linspace(0, 2 * np.pi, 80), indexing="ij")
outer = 1.0 + 0 * turn
inner = 0.7 + 0.15 * np.sin(3 * turn)


def tube(radius):
    ring = 4 + radius * np.cos(round_)
    return grid(ring * np.cos(turn), ring * np.sin(turn), radius * np.sin(round_))


(outside, faces), (inside, _) = tube(outer), tube(inner)
part = trisect.Scene(np.concatenate([outside, inside]), np.concatenate([faces, faces[:, ::-1] + len(outside)]))
a, b, c = (outside[corner] for corner in faces.T)
middles, normals = (a + b + c) / 3, np.cross(b - a, c - a)
normals /= np.linalg.norm(normals, axis=1, keepdims=True)
inwards = np.where(part.first(middles, normals, tmin=1e-6).t < part.first(middles, -normals, tmin=1e-6).t, 1, -1)
thickness = part.first(middles, normals * inwards[:, None], tmin=1e-6).t
print(f"walls are {thickness.min():.3f} to {thickness[np.isfinite(thickness)].max():.3f} thick")

plt.figure(figsize=(6, 5))
plt.scatter(*middles[middles[:, 2] > 0].T[:2], c=thickness[middles[:, 2] > 0], s=2)
plt.colorbar(label="thickness")
plt.gca().set(aspect="equal", title="walls of a bent tube, from above")
plt.savefig(folder / "thickness.png", dpi=100)

# %% 3. Which points are inside?
# An octahedron within a larger one, whose vertices and edges lie on the lattice that is asked: no ray may count twice.
octahedron = np.concatenate([np.eye(3), -np.eye(3)])
sides = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
hollow = trisect.Scene(np.concatenate([octahedron, 0.5 * octahedron]), np.concatenate([sides, sides + 6]))
line = np.linspace(-1, 1, 33)
lattice = np.stack(np.meshgrid(line, line, line, indexing="ij"), -1)
places = hollow.places(lattice)
for place, name in ((1, "inside"), (0, "on the surface"), (-1, "outside")):
    print(f"{(places == place).sum()} of {places.size} points are {name}")

plt.figure(figsize=(5, 5))
plt.imshow(places[:, :, 16].T, origin="lower", extent=(-1, 1, -1, 1))
plt.gca().set(title="z = 0: outside, on the surface, inside")
plt.savefig(folder / "inside.png", dpi=100)
