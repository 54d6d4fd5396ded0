//! Records of numbers: what a method stores per triangle, as a scalar when it is prepared, as
//! `[E; 16]` in a block, as lanes in a kernel.

/// What a record holds: data that can be copied and shared.
pub trait Value: Copy + Send + Sync {}

impl<X: Copy + Send + Sync> Value for X {}

/// The shape of what is stored per triangle, whatever the numbers are. Implemented by
/// [`record!`](crate::record) for the record of `()`: `EdgeTriangle<()>` is the shape,
/// [`Of<EdgeTriangle<()>, f32>`](Of) is `EdgeTriangle<f32>`.
pub trait Record: 'static {
    /// The record with numbers of type `X`.
    type Of<X: Value>: Value;
    /// How many numbers.
    const NUMBERS: usize;
    /// The names of the numbers, in order of declaration: of a vector `a` they are `a_x`, `a_y` and `a_z`.
    fn names() -> Vec<String>;
    /// Applies `f` to each number, in order of declaration. `Copy`, since what is not is dropped when a call panics, and
    /// every kernel would be compiled for that.
    fn map<X: Value, Y: Value>(from: &Self::Of<X>, f: impl Fn(&X) -> Y + Copy) -> Self::Of<Y>;
    /// Applies `f` to each pair of numbers at the same place, in order of declaration.
    fn zip<X: Value, Y: Value>(
        to: &mut Self::Of<X>,
        from: &Self::Of<Y>,
        f: impl Fn(&mut X, &Y) + Copy,
    );
    /// The record with axis `w` of each vector renamed to the last, see
    /// [`Vec3::with_axis_last`](trisect_core::Vec3::with_axis_last).
    fn with_axis_last<X: Value>(from: &Self::Of<X>, w: usize) -> Self::Of<X>;
}

/// The records of `N` lanes, number by number: each number of the lanes side by side.
#[inline(always)]
pub fn rows<R: Record, X: Value, const N: usize>(
    of_lane: impl Fn(usize) -> R::Of<X>,
) -> R::Of<[X; N]> {
    let mut rows = R::map(&of_lane(0), |&x| [x; N]);
    for lane in 1..N {
        R::zip(&mut rows, &of_lane(lane), |row, &x| row[lane] = x);
    }
    rows
}

/// Nothing stored.
impl Record for () {
    type Of<X: Value> = ();
    const NUMBERS: usize = 0;
    fn names() -> Vec<String> {
        Vec::new()
    }
    #[inline(always)]
    fn map<X: Value, Y: Value>(_from: &(), _f: impl Fn(&X) -> Y + Copy) {}
    #[inline(always)]
    fn zip<X: Value, Y: Value>(_to: &mut (), _from: &(), _f: impl Fn(&mut X, &Y) + Copy) {}
    #[inline(always)]
    fn with_axis_last<X: Value>(_from: &(), _w: usize) {}
}

/// Two records side by side.
impl<A: Record, B: Record> Record for (A, B) {
    type Of<X: Value> = (A::Of<X>, B::Of<X>);
    const NUMBERS: usize = A::NUMBERS + B::NUMBERS;
    fn names() -> Vec<String> {
        let mut names = A::names();
        names.extend(B::names());
        names
    }
    #[inline(always)]
    fn map<X: Value, Y: Value>(from: &Self::Of<X>, f: impl Fn(&X) -> Y + Copy) -> Self::Of<Y> {
        (A::map(&from.0, f), B::map(&from.1, f))
    }
    #[inline(always)]
    fn zip<X: Value, Y: Value>(
        to: &mut Self::Of<X>,
        from: &Self::Of<Y>,
        f: impl Fn(&mut X, &Y) + Copy,
    ) {
        A::zip(&mut to.0, &from.0, f);
        B::zip(&mut to.1, &from.1, f);
    }
    #[inline(always)]
    fn with_axis_last<X: Value>(from: &Self::Of<X>, w: usize) -> Self::Of<X> {
        (A::with_axis_last(&from.0, w), B::with_axis_last(&from.1, w))
    }
}

/// The record of shape `R` with numbers of type `X`.
pub type Of<R, X> = <R as Record>::Of<X>;

/// The kinds of fields that [`record!`](crate::record) knows.
#[allow(non_camel_case_types, reason = "named as the macro's fields are written")]
pub mod field {
    /// Three numbers.
    pub type vec3<X> = trisect_core::Vec3<X>;
    /// One number.
    pub type number<X> = X;
}

/// Declares a record: a struct generic over its number type that implements
/// [`Record`](trait@crate::Record). Each field is a `vec3` or a `number`.
///
/// ```
/// trisect_method::record! {
///     /// A plane `normal · p = distance`.
///     pub struct Plane {
///         /// Normal.
///         normal: vec3,
///         /// Signed distance from the origin, times the length of the normal.
///         distance: number,
///     }
/// }
/// # use trisect_method::Record;
/// assert_eq!(<Plane<()> as Record>::NUMBERS, 4);
/// ```
#[macro_export]
macro_rules! record {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident {
            $($(#[$field_attribute:meta])* $field:ident : $kind:ident),+ $(,)?
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name<X> {
            $($(#[$field_attribute])* pub $field: $crate::field::$kind<X>,)+
        }

        impl $crate::Record for $name<()> {
            type Of<X: $crate::Value> = $name<X>;
            const NUMBERS: usize = 0 $(+ $crate::record!(@count $kind))+;
            fn names() -> Vec<String> {
                let mut names = Vec::new();
                $(names.extend($crate::record!(@names $kind stringify!($field)));)+
                names
            }
            #[inline(always)]
            fn map<X: $crate::Value, Y: $crate::Value>(
                from: &$name<X>,
                f: impl Fn(&X) -> Y + Copy,
            ) -> $name<Y> {
                $name { $($field: $crate::record!(@map $kind from.$field, f)),+ }
            }
            #[inline(always)]
            fn zip<X: $crate::Value, Y: $crate::Value>(
                to: &mut $name<X>,
                from: &$name<Y>,
                f: impl Fn(&mut X, &Y) + Copy,
            ) {
                $($crate::record!(@zip $kind to.$field, from.$field, f);)+
            }
            #[inline(always)]
            fn with_axis_last<X: $crate::Value>(from: &$name<X>, w: usize) -> $name<X> {
                $name { $($field: $crate::record!(@turn $kind from.$field, w)),+ }
            }
        }
    };
    (@turn vec3 $from:expr, $w:ident) => { $from.with_axis_last($w) };
    (@turn number $from:expr, $w:ident) => {{
        let _ = $w;
        $from
    }};
    (@names vec3 $field:expr) => { ["_x", "_y", "_z"].map(|axis| String::from($field) + axis) };
    (@names number $field:expr) => { [String::from($field)] };
    (@count vec3) => { 3 };
    (@count number) => { 1 };
    (@map vec3 $from:expr, $f:ident) => {
        $crate::core::Vec3 { x: $f(&$from.x), y: $f(&$from.y), z: $f(&$from.z) }
    };
    (@map number $from:expr, $f:ident) => { $f(&$from) };
    (@zip vec3 $to:expr, $from:expr, $f:ident) => {
        $f(&mut $to.x, &$from.x);
        $f(&mut $to.y, &$from.y);
        $f(&mut $to.z, &$from.z)
    };
    (@zip number $to:expr, $from:expr, $f:ident) => { $f(&mut $to, &$from) };
}
