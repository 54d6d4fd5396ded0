//! Facts about a method, for lists, pages and records.

use crate::form::Form;
use trisect_core::named;

/// Facts about a method, for lists, pages and records.
///
/// A method writes what differs from [`MethodInfo::USUAL`].
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    /// Name as typed on the command line: lower case, digits, hyphens.
    pub name: &'static str,
    /// Name in prose.
    pub title: &'static str,
    /// Year of publication.
    pub year: u16,
    /// Authors, title, place, section.
    pub source: &'static str,
    /// What a triangle is given as.
    pub input: Input,
    /// What a hit can be asked for.
    pub outputs: &'static [Output],
    /// Which of the two forms of the division the method has.
    pub forms: Forms,
    /// Whether it cannot decide without a division, having no numerators to decide by.
    pub always_divides: bool,
    /// What it promises.
    pub claims: Claims,
    /// The claim behind its error bound in well-conditioned cases, as a multiple of
    /// `κ · unit roundoff`: the conformance tests hold the method to it.
    pub error_factor: f64,
}

impl MethodInfo {
    /// Prepared data, both forms, everything but a normal, no promise, and the error factor that
    /// the tests hold methods to for which nobody derived one.
    pub const USUAL: Self = Self {
        name: "",
        title: "",
        year: 0,
        source: "",
        input: Input::Prepared,
        outputs: Output::ALL_BUT_NORMAL,
        forms: Forms::Both,
        always_divides: false,
        claims: Claims { watertight: false, culls: true, unit_direction: false, exact: false },
        error_factor: 64.0,
    };

    /// Whether a hit can be asked for `output`.
    pub const fn gives(&self, output: Output) -> bool {
        let mut i = 0;
        while i < self.outputs.len() {
            if self.outputs[i] as u8 == output as u8 {
                return true;
            }
            i += 1;
        }
        false
    }
}

named! {
    /// What a triangle is given as.
    pub enum Input {
        /// Its three points; nothing is prepared.
        Points = "points",
        /// Its three points and their normal.
        PointsAndNormal = "points-and-normal",
        /// Data prepared for the method.
        Prepared = "prepared",
    }
}

named! {
    /// What a hit can be asked for.
    pub enum Output {
        /// Whether there is one.
        Occlusion = "occlusion",
        /// `t`
        T = "t",
        /// `t`, `beta` and `gamma`.
        Barycentrics = "barycentrics",
        /// The point, in the coordinates of ray and triangle.
        Point = "point",
        /// The triangle's normal `(B − A) × (C − A)`, with its length.
        Normal = "normal",
    }
}

impl Output {
    /// Of a method that does not keep the normal.
    pub const ALL_BUT_NORMAL: &'static [Self] =
        &[Self::Occlusion, Self::T, Self::Barycentrics, Self::Point];
    /// Of a method that decides without weights.
    pub const FLAG_AND_T: &'static [Self] = &[Self::Occlusion, Self::T, Self::Point];
    /// Of a method that decides without weights and keeps the normal.
    pub const FLAG_T_AND_NORMAL: &'static [Self] =
        &[Self::Occlusion, Self::T, Self::Point, Self::Normal];
}

/// Which forms of the division a method has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Forms {
    /// Early and deferred.
    Both,
    /// Early alone.
    Early,
    /// Deferred alone.
    Deferred,
}

impl MethodInfo {
    /// The most that any caller may ask of a hit: barycentrics where the method gives them, else `t`.
    pub const fn fullest(&self) -> Output {
        if self.gives(Output::Barycentrics) { Output::Barycentrics } else { Output::T }
    }

    /// Whether a caller that asks for no values is answered by numerators that no listed form computes.
    pub const fn decides_apart(&self) -> bool {
        !self.forms.deferred() && !self.always_divides
    }
}

impl Forms {
    /// Whether the early form is there.
    pub const fn early(self) -> bool {
        !matches!(self, Self::Deferred)
    }
    /// Whether the deferred form is there.
    pub const fn deferred(self) -> bool {
        !matches!(self, Self::Early)
    }
    /// The form that decides without quotients where it is there, else the other.
    pub const fn preferred(self) -> Form {
        if self.deferred() { Form::Deferred } else { Form::Early }
    }
    /// The forms that are there, the preferred one first.
    pub const fn list(self) -> &'static [Form] {
        match self {
            Self::Both => &[Form::Deferred, Form::Early],
            Self::Early => &[Form::Early],
            Self::Deferred => &[Form::Deferred],
        }
    }
}

/// What a method promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each promise is kept or not, whatever the others"
)]
pub struct Claims {
    /// No ray passes between triangles that share an edge or a corner, in plain arithmetic and the
    /// deferred form, while nothing under- or overflows.
    pub watertight: bool,
    /// Either face can be left out.
    pub culls: bool,
    /// The direction must have unit length.
    pub unit_direction: bool,
    /// Every decision, and the order of hits along a ray, is that of exact arithmetic, whatever the numbers;
    /// values are the exact ones, rounded once.
    pub exact: bool,
}
