//! What becomes of a pixel and a triangle that the bounds leave open: the exact method decides, on the caster's own
//! ray.

use std::cmp::Ordering;

use trisect_core::{Hit, Ray, Triangle};
use trisect_exact::{Exact, order};
use trisect_method::{
    Culling, DecisionOnly, Deferred, ExactMethod as _, Interval, Method as _, TrueDivision,
};
use trisect_scene::PixelRays;

use crate::blocks::Object;
use crate::tile::{Drawn, NOTHING, STRIDE, Tile};

/// What is needed to judge.
pub(crate) struct Judge<'a> {
    pub(crate) objects: &'a [Object],
    /// The number of the first triangle of each object.
    pub(crate) firsts: &'a [u32],
    pub(crate) rays: &'a PixelRays,
    pub(crate) culling: Culling,
    /// Half the picture, in pixels.
    pub(crate) half: [f32; 2],
    /// The nearness of what is at the camera itself.
    pub(crate) limit: f32,
}

impl Judge<'_> {
    /// The object that a triangle belongs to, and its place there.
    #[inline]
    pub(crate) fn locate(&self, number: u32) -> (usize, usize) {
        locate(self.firsts, number)
    }

    /// The caster's ray through a pixel of a tile.
    fn ray(&self, tile: &Tile, place: usize) -> Ray<f32> {
        #[allow(clippy::cast_possible_truncation, reason = "pixels are counted in u32")]
        let pixel =
            [tile.corner[0] + place % STRIDE, tile.corner[1] + place / STRIDE].map(|x| x as u32);
        let (o, d) = self.rays.ray(pixel);
        Ray { o: o.into(), d: d.into(), tmin: 0.0, tmax: f32::INFINITY }
    }

    /// Decides of some pixels of a row, in bits, whether a triangle is seen there: `rows` has between which numbers
    /// its nearness lies, if it is.
    #[cold]
    #[inline(never)]
    pub(crate) fn settle(
        &self,
        tile: &mut Tile,
        place: usize,
        mut open: u64,
        rows: &[[f32; 16]; 2],
        drawn: Drawn,
    ) {
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            let pixel = place + lane;
            tile.judged += 1;
            let ray = self.ray(tile, pixel);
            let object = &self.objects[drawn.object];
            let (carried, new) = (object.carry(&ray), object.triangles().triangle(drawn.place));
            if !is_hit(&carried, &new, self.culling) {
                continue;
            }
            let old = tile.seen[pixel].to_bits();
            if old == NOTHING || self.is_first(&ray, (&carried, &new, drawn), old) {
                tile.seen[pixel] = f32::from_bits(drawn.number);
                tile.low[pixel] = rows[0][lane];
                tile.high[pixel] = rows[1][lane];
            }
        }
    }

    /// Whether a triangle that a ray hits comes before another that it hits: as exact arithmetic has it in one
    /// object, by rounded `t` between objects, and of equals that of the lower number.
    fn is_first(
        &self,
        ray: &Ray<f32>,
        (carried, new, drawn): (&Ray<f32>, &Triangle<f32>, Drawn),
        old: u32,
    ) -> bool {
        let (object, place) = self.locate(old);
        let other = self.objects[object].triangles().triangle(place);
        let along = if object == drawn.object {
            order(carried, new, &other)
        } else {
            let t = values(carried, new).t;
            let others = values(&self.objects[object].carry(ray), &other).t;
            t.partial_cmp(&others).unwrap_or(Ordering::Equal)
        };
        along.then(drawn.number.cmp(&old)) == Ordering::Less
    }
}

/// The object that a triangle belongs to, and its place there.
#[inline]
pub(crate) fn locate(firsts: &[u32], number: u32) -> (usize, usize) {
    // Those without triangles begin where the next one does, and own nothing.
    let object = firsts.partition_point(|&first| first <= number) - 1;
    (object, (number - firsts[object]) as usize)
}

/// Whether a ray hits a triangle.
fn is_hit(ray: &Ray<f32>, triangle: &Triangle<f32>, culling: Culling) -> bool {
    let prepared = <Exact>::prepare(triangle, 0);
    let interval = Interval::of(ray);
    let mut is_hit = false;
    <Exact>::test::<f32, DecisionOnly<Deferred<TrueDivision, true>>>(
        &<Exact>::prepare_ray::<f32>(ray, 0),
        &prepared,
        interval,
        culling,
        |met, _| is_hit = met,
    );
    is_hit
}

/// The values of a hit, rounded once.
pub(crate) fn values(ray: &Ray<f32>, triangle: &Triangle<f32>) -> Hit<f32> {
    let rays = ray.map(|&x| [x]);
    let Ray { o, d, tmin, tmax } = &rays;
    let rays = Ray { o: o.each_ref(), d: d.each_ref(), tmin, tmax };
    let Hit { t: [t], beta: [beta], gamma: [gamma] } =
        <Exact>::values::<f32, f32, 1>(&rays, &triangle.map(|&x| [x]), 1);
    Hit { t, beta, gamma }
}
