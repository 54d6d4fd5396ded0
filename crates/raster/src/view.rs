//! A camera's rays as affine functions of the pixel, and how far the caster's own rays are off them.

use glam::{DMat3, DVec3, Vec3};
use trisect_core::{Ray, Vec3 as Coordinates};
use trisect_scene::{Lens, PixelRays};
use trisect_tracer::Transform;

/// The unit roundoff of f32.
pub(crate) const U: f64 = 1.0 / (1_u64 << 24) as f64;

/// Views whose numbers are beyond this, or below its inverse, bound nothing.
const MOST: f64 = (1_u64 << 20) as f64;

/// What the rays of a picture are in the space of a mesh: through the pixel at `(x, y)` from the middle of the
/// picture, in pixels, a pinhole's ray has the direction `g[0] + x·g[1] + y·g[2]`, and the ray of an orthographic
/// camera, whose direction is `g[0]`, starts at `origin − x·g[1] − y·g[2]`; but for the bounds here, which
/// `docs/derivations/raster.md` derives.
#[derive(Clone, Debug)]
pub struct View {
    pub(crate) is_parallel: bool,
    pub(crate) origin: Coordinates<f32>,
    pub(crate) g: [Coordinates<f32>; 3],
    /// What takes a point from the origin to its depth, and to its pixel times its depth.
    pub(crate) dual: [Coordinates<f32>; 3],
    /// The sum of the magnitudes of what is added up to a direction, or to the way of an origin.
    pub(crate) reach: f32,
    /// How far the caster's rays are off, summed over the coordinates.
    pub(crate) error: f32,
    /// How far the pixels of corners may be off: always, and by what their distances are in depths.
    pub(crate) margin: [f32; 2],
    /// What the depth may be off, by the distance.
    pub(crate) depth_error: f32,
    /// Half the picture, in pixels.
    pub(crate) half: [f32; 2],
    /// Whether the bounds hold; else every pixel is judged.
    pub(crate) is_bounded: bool,
    /// Whether corners can be taken to pixels; else every triangle may be anywhere.
    pub(crate) is_invertible: bool,
}

fn sum(v: DVec3) -> f64 {
    v.abs().element_sum()
}

#[allow(clippy::cast_possible_truncation, reason = "rounds once")]
fn rounded(v: DVec3) -> Coordinates<f32> {
    v.as_vec3().into()
}

fn widened(v: Vec3) -> DVec3 {
    v.as_dvec3()
}

impl View {
    /// The rays of a camera, as they are carried to a mesh; `None` where the camera has a lens, through all of
    /// which rays go.
    pub fn new(rays: &PixelRays, transform: Option<&Transform>) -> Option<Self> {
        let camera = rays.camera();
        let is_parallel = match camera.lens {
            Lens::Pinhole { .. } => false,
            Lens::Orthographic { .. } => true,
            Lens::Thin { .. } => return None,
        };
        let [width, height] = rays.size();
        let half = [f64::from(width) / 2.0, f64::from(height) / 2.0];
        let (corner, step, tall) = (rays.corner(), rays.step(), rays.half_height());
        let (step, tall) = (f64::from(step), f64::from(tall));
        let [right, up] = [camera.right, camera.up].map(|v| widened(v) * tall);
        let base = widened(if is_parallel { camera.eye } else { camera.forward });
        let wide = f64::from(corner.x).abs();
        let middle = base
            + right * (f64::from(corner.x) + half[0] * step)
            + up * (f64::from(corner.y) - half[1] * step);
        let (mut g0, mut gx, mut gy) = (middle, right * step, up * -step);
        let across = right.abs() * wide + up.abs();
        let most = base.abs() + across;
        let mut error = 1.001 * U * (6.0 * across + 2.0 * most);
        let own = rays.ray([0, 0]);
        let own = Ray { o: own.0.into(), d: own.1.into(), tmin: 0.0, tmax: f32::INFINITY };
        let mut carried = own;
        if let Some(transform) = transform {
            carried = transform.carry(&own);
            let to_object = transform.to_object().as_daffine3();
            let matrix = to_object.matrix3;
            let sizes = matrix.abs();
            let offset = if is_parallel { to_object.translation } else { DVec3::ZERO };
            error = sizes * error + 5.01 * U * (sizes * most + offset.abs());
            (g0, gx, gy) = (matrix * g0 + offset, matrix * gx, matrix * gy);
        }
        let error = sum(error);
        let direction = widened(carried.d.into());
        let columns = [if is_parallel { direction } else { g0 }, gx, gy];
        let basis = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let rows = basis.inverse().transpose();
        let [mut depth, to_x, to_y] = [rows.x_axis, rows.y_axis, rows.z_axis];
        // How much the inverse may lose, with pixels counted in halves of the picture.
        let condition = (0..3)
            .map(|column| {
                let size = [1.0, half[0], half[1]][column];
                let other = [depth, to_x / half[0], to_y / half[1]][column];
                sum(columns[column] * size) * sum(other)
            })
            .fold(0.0, f64::max);
        if is_parallel {
            depth = DVec3::ZERO;
        }
        let is_invertible =
            rows.is_finite() && condition <= MOST && sum(depth) * error <= 1.0 / 128.0;
        let [x, y] = half;
        let per_length = (sum(to_x) + x * sum(depth)).max(sum(to_y) + y * sum(depth));
        let (origin, reach) = if is_parallel {
            (rounded(g0), x * sum(gx) + y * sum(gy))
        } else {
            (carried.o, sum(g0) + x * sum(gx) + y * sum(gy))
        };
        let g = if is_parallel {
            [carried.d, rounded(-gx), rounded(-gy)]
        } else {
            columns.map(rounded)
        };
        let size = if is_parallel { direction.abs().max_element() } else { reach };
        let is_in_range = |x: f64| (1.0 / MOST..=MOST).contains(&x);
        #[allow(
            clippy::cast_possible_truncation,
            reason = "rounds once, which the factors pay for"
        )]
        let narrow = |x: f64| x as f32;
        Some(Self {
            is_parallel,
            origin,
            g,
            dual: [depth, to_x, to_y].map(rounded),
            reach: narrow(reach * 1.0001),
            error: narrow(error * 1.0001),
            margin: [
                narrow(1.02 * per_length * error + 12.1 * U * (x.max(y) + 1.0)),
                narrow(5.05 * U * per_length * (1.0 + 0.5 / x.min(y))),
            ],
            // Nothing is behind the eye for certain where depths are not known.
            depth_error: if is_invertible { narrow(5.05 * U * sum(depth)) } else { f32::INFINITY },
            half: half.map(narrow),
            is_bounded: is_in_range(size) && reach <= MOST && error <= 1.0,
            is_invertible,
        })
    }
}
