# A second opinion, by Gappa: the errors of the exact kernel's volumes in f32, plain. Coordinates of D, of S = A - O and of
# the edges E and G are within 1; so d = 3 and h = S = 1, and Coq's norm forms are, in units of u = 2^-24,
# 7*2*d*h^2 = 42 for det, U and V, 8*6*S*h^2 = 48 for T, and 9*(2*d*h^2 + 4*d*S*h) = 162 for W. On this box half is enough.
@rnd = float<ieee_32, ne>;

dx = rnd(Dx); dy = rnd(Dy); dz = rnd(Dz);
sx = rnd(Sx); sy = rnd(Sy); sz = rnd(Sz);
ex = rnd(Ex); ey = rnd(Ey); ez = rnd(Ez);
gx = rnd(Gx); gy = rnd(Gy); gz = rnd(Gz);

nx rnd= gy * ez - gz * ey; ny rnd= gz * ex - gx * ez; nz rnd= gx * ey - gy * ex;
rx rnd= dy * sz - dz * sy; ry rnd= dz * sx - dx * sz; rz rnd= dx * sy - dy * sx;
det rnd= dx * nx + (dy * ny + dz * nz);
t rnd= sx * nx + (sy * ny + sz * nz);
u rnd= gx * rx + (gy * ry + gz * rz);
v rnd= ex * rx + (ey * ry + ez * rz);
w rnd= (det - u) + v;

Nx = Gy * Ez - Gz * Ey; Ny = Gz * Ex - Gx * Ez; Nz = Gx * Ey - Gy * Ex;
Rx = dy * Sz - dz * Sy; Ry = dz * Sx - dx * Sz; Rz = dx * Sy - dy * Sx;
Det = dx * Nx + (dy * Ny + dz * Nz);
T = Sx * Nx + (Sy * Ny + Sz * Nz);
U = Gx * Rx + (Gy * Ry + Gz * Rz);
V = Ex * Rx + (Ey * Ry + Ez * Rz);
W = (Det - U) + V;

{ Dx in [-1, 1] /\ Dy in [-1, 1] /\ Dz in [-1, 1] /\ Sx in [-1, 1] /\ Sy in [-1, 1] /\ Sz in [-1, 1]
  /\ Ex in [-1, 1] /\ Ey in [-1, 1] /\ Ez in [-1, 1] /\ Gx in [-1, 1] /\ Gy in [-1, 1] /\ Gz in [-1, 1]
  -> det - Det in [-21b-24, 21b-24] /\ u - U in [-21b-24, 21b-24] /\ v - V in [-21b-24, 21b-24]
  /\ t - T in [-24b-24, 24b-24] /\ w - W in [-87b-24, 87b-24] }
