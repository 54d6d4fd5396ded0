//! Random numbers that depend on where they are used alone, so that no order of work changes them.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

/// The numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Random {
    /// Of all choices.
    pub seed: u32,
    /// Which pixel, or whatever else a program is run for.
    pub pixel: u32,
    /// Which of its samples.
    pub sample: u32,
}

impl Random {
    /// Four numbers below 1, of a place in the sample's life that nothing else uses.
    ///
    /// Jarzynski, Olano: Hash Functions for GPU Rendering. Journal of Computer Graphics Techniques 9(3),
    /// 2020: pcg4d.
    #[inline]
    pub fn four(self, place: u32) -> [f32; 4] {
        let step = |x: u32| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let Self { seed, pixel, sample } = self;
        let [mut x, mut y, mut z, mut w] = [pixel, sample, place, seed].map(step);
        for round in 0..2 {
            x = x.wrapping_add(y.wrapping_mul(w));
            y = y.wrapping_add(z.wrapping_mul(x));
            z = z.wrapping_add(x.wrapping_mul(y));
            w = w.wrapping_add(y.wrapping_mul(z));
            if round == 0 {
                [x, y, z, w] = [x, y, z, w].map(|x| x ^ (x >> 16));
            }
        }
        // The upper 24 bits, which a float holds exactly.
        [x, y, z, w].map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0))
    }
}

/// A point of the unit disc, evenly spread (Shirley, Chiu 1997).
pub fn on_disc(u: f32, v: f32) -> Vec2 {
    let (x, y) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let (radius, turn) = if x.abs() > y.abs() {
        (x, 0.125 * (y / x))
    } else if y != 0.0 {
        (y, 0.25 - 0.125 * (x / y))
    } else {
        return Vec2::ZERO;
    };
    let (sin, cos) = (turn * TAU).sin_cos();
    Vec2::new(cos, sin) * radius
}

/// A direction about a normal, as likely as its cosine (Malley's method).
pub fn cosine_about(normal: Vec3, u: f32, v: f32) -> Vec3 {
    let at = on_disc(u, v);
    let (x, y) = normal.any_orthonormal_pair();
    let up = (1.0 - at.length_squared()).max(0.0).sqrt();
    x * at.x + y * at.y + normal * up
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_spread_evenly_over_every_argument() {
        let arguments: [fn(u32) -> (Random, u32); 4] = [
            |i| (Random { seed: i, pixel: 3, sample: 0 }, 0),
            |i| (Random { seed: 1, pixel: i, sample: 0 }, 0),
            |i| (Random { seed: 1, pixel: 3, sample: i }, 0),
            |i| (Random { seed: 1, pixel: 3, sample: 0 }, i),
        ];
        for of in arguments {
            let mut sums = [[0.0_f64; 4]; 2];
            let count = 10_000;
            for i in 0..count {
                let (random, place) = of(i);
                for (lane, x) in random.four(place).into_iter().enumerate() {
                    assert!((0.0..1.0).contains(&x));
                    sums[0][lane] += f64::from(x);
                    sums[1][lane] += f64::from(x * x);
                }
            }
            // Four standard errors of the mean and of the mean square.
            let n = f64::from(count);
            for (mean, square) in sums[0].iter().zip(sums[1]) {
                assert!((mean / n - 0.5).abs() < 4.0 * (1.0 / 12.0 / n).sqrt());
                assert!((square / n - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / n).sqrt());
            }
        }
    }

    #[test]
    fn directions_are_as_likely_as_their_cosine() {
        let normal = Vec3::new(0.6, 0.0, -0.8);
        let random = Random { seed: 1, pixel: 0, sample: 0 };
        let count = 40_000_u32;
        let mean = (0..count).fold(Vec3::ZERO, |sum, i| {
            let [u, v, ..] = random.four(i);
            let direction = cosine_about(normal, u, v);
            assert!((direction.length() - 1.0).abs() < 1e-5 && direction.dot(normal) >= 0.0);
            sum + direction
        }) / count as f32;
        // The mean cosine is 2/3.
        assert!((mean - normal * (2.0 / 3.0)).length() < 0.01, "{mean}");
    }
}
