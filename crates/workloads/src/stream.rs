//! Random numbers that are the same bits on every machine: a seeded PCG stream per name, and
//! samplers that use nothing but `+ − × ÷ √`, which every machine rounds alike.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;
use trisect_core::Vec3;

/// PCG XSL RR 128/64 (O'Neill 2014). The name selects the stream (its increment), the seed the
/// place in it, so that a new workload never changes the numbers of another.
pub struct Stream(Pcg64);

impl Stream {
    /// The numbers of a name and a seed.
    pub fn new(name: &str, seed: u64) -> Self {
        let low = split_mix(seed);
        let high = split_mix(low);
        Self(Pcg64::new((u128::from(high) << 64) | u128::from(low), u128::from(fnv(name))))
    }

    /// Uniform over the 2²⁴ multiples of 2⁻²⁴ in `[0, 1)`.
    #[allow(clippy::cast_possible_truncation, reason = "24 bits are exact in an f32")]
    pub(crate) fn unit(&mut self) -> f32 {
        const ULP: f32 = 1.0 / (1 << 24) as f32;
        (self.0.next_u64() >> 40) as f32 * ULP
    }

    /// Uniform over the 2⁵³ multiples of 2⁻⁵³ in `[0, 1)`.
    pub fn unit_f64(&mut self) -> f64 {
        const ULP: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * ULP
    }

    /// Uniform in `[low, high)`, up to the rounding of the scaling.
    pub fn range_f64(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit_f64()
    }

    /// Uniform in `[−1, 1)³`.
    pub fn cube(&mut self) -> Vec3<f64> {
        let mut side = || self.range_f64(-1.0, 1.0);
        Vec3::new(side(), side(), side())
    }

    /// Uniform on the unit sphere, by rejection from the cube.
    pub(crate) fn sphere_f64(&mut self) -> Vec3<f64> {
        loop {
            let p = self.cube();
            let squared = p.dot(p);
            if squared <= 1.0 && squared > f64::from(SHORTEST * SHORTEST) {
                return p.scale(1.0 / squared.sqrt());
            }
        }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in `[low, high)`, up to the rounding of the scaling.
    pub(crate) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the closed unit ball, by rejection from the cube.
    pub(crate) fn ball(&mut self) -> Vec3<f32> {
        loop {
            let p = Vec3::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            if p.dot(p) <= 1.0 {
                return p;
            }
        }
    }

    /// Uniform in the closed unit disc, by rejection from the square.
    pub(crate) fn disc(&mut self) -> (f32, f32) {
        loop {
            let (x, y) = (self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            if x * x + y * y <= 1.0 {
                return (x, y);
            }
        }
    }

    /// Uniform on the unit circle. Points near the centre are rejected: their directions are
    /// coarse.
    pub(crate) fn circle(&mut self) -> (f32, f32) {
        loop {
            let (x, y) = self.disc();
            let length = (x * x + y * y).sqrt();
            if length > SHORTEST {
                return (x / length, y / length);
            }
        }
    }

    /// Uniform on the unit sphere, in the same way.
    pub(crate) fn sphere(&mut self) -> Vec3<f32> {
        loop {
            let p = self.ball();
            let length = p.dot(p).sqrt();
            if length > SHORTEST {
                return p.map(|x| x / length);
            }
        }
    }

    /// Cosine-weighted about the unit vector `normal`, not of unit length: the normal plus a
    /// point on the unit sphere.
    pub(crate) fn cosine(&mut self, normal: Vec3<f32>) -> Vec3<f32> {
        loop {
            let d = normal + self.sphere();
            // The antipode of the normal gives no direction.
            if d.dot(d) > SHORTEST * SHORTEST {
                return d;
            }
        }
    }

    /// Puts the items in random order (Fisher–Yates).
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Uniform below `bound`, without bias: draws beyond the last whole multiple are rejected.
    ///
    /// # Panics
    /// When `bound` is zero.
    pub fn below(&mut self, bound: usize) -> usize {
        let bound = bound as u64;
        let limit = u64::MAX - u64::MAX % bound;
        loop {
            let draw = self.0.next_u64();
            if draw < limit {
                #[allow(clippy::cast_possible_truncation, reason = "below a usize")]
                return (draw % bound) as usize;
            }
        }
    }
}

/// Shorter vectors than this are not normalised.
const SHORTEST: f32 = 1.0 / 64.0;

/// One step of `SplitMix64` (Steele, Lea and Flood 2014): spreads small seeds over all bits.
fn split_mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// FNV-1a, 64 bits.
fn fnv(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
