//! What a figure shows: rows (bars, dots and spans by category), planes (points and lines in two
//! dimensions) and maps (grids of cells). How it is drawn is the business of `svg`.

pub use crate::axis::{Axis, Scale};

/// What a colour is for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// The ground.
    Paper,
    /// What is read.
    Text,
    /// What is read last.
    Muted,
    /// Lines of a grid, and series that are not told apart.
    Grid,
    /// One of the series colours.
    Series(u8),
}

/// How many series colours there are.
pub(crate) const SERIES: usize = 7;

impl Ink {
    /// The ink of the `i`th series.
    pub fn series(i: usize) -> Self {
        Self::Series(u8::try_from(i % SERIES).unwrap_or(0))
    }
}

/// The shape of a point, so that no meaning hangs on colour alone.
#[derive(Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "shapes")]
pub enum Shape {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
}

/// How a method, or whatever a series stands for, is drawn everywhere.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// The colour.
    pub ink: Ink,
    /// The shape of its points.
    pub shape: Shape,
}

impl Look {
    /// The look of the `i`th series: seven colours and five shapes share no divisor, so 35
    /// looks differ.
    pub fn of(i: usize) -> Self {
        let shapes = [Shape::Circle, Shape::Square, Shape::Up, Shape::Diamond, Shape::Down];
        Self { ink: Ink::series(i), shape: shapes[i % shapes.len()] }
    }

    /// Circles in an ink that is no series'.
    pub fn plain(ink: Ink) -> Self {
        Self { ink, shape: Shape::Circle }
    }
}

/// What a row shows.
#[derive(Clone, Copy)]
pub enum Mark {
    /// A bar from the left end of the axis.
    Bar(f64),
    /// A thin line between two values.
    Span(f64, f64),
    /// A point; hollow where it is not filled.
    Point {
        /// The value.
        at: f64,
        /// Its shape.
        shape: Shape,
        /// Whether it is filled.
        filled: bool,
    },
}

/// A labelled row of marks, with a note behind them.
pub struct Row {
    /// What the row is of.
    pub label: String,
    /// The method that it lights up with on a page, or nothing.
    pub method: String,
    /// The marks and their colours.
    pub marks: Vec<(Ink, Mark)>,
    /// What stands behind them.
    pub note: String,
}

/// Rows under a heading.
pub struct Group {
    /// The heading, or nothing.
    pub heading: String,
    /// The rows.
    pub rows: Vec<Row>,
}

/// Rows by category.
pub struct Rows {
    pub(crate) title: String,
    pub(crate) axis: Axis,
    /// A value to draw a line at.
    pub(crate) rule: Option<f64>,
    pub(crate) groups: Vec<Group>,
}

/// How the points of a series are joined.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Join {
    /// Not at all.
    No,
    /// By straight lines.
    Straight,
    /// Right, then down: the border of what is beaten by a front.
    Step,
}

/// Points of one look.
pub struct Series {
    /// The look.
    pub look: Look,
    /// Whether points are filled.
    pub filled: bool,
    /// How they are joined.
    pub join: Join,
    /// Whether points are drawn, or the line alone.
    pub marked: bool,
    /// Where they are.
    pub points: Vec<(f64, f64)>,
    /// The method that they light up with on a page, or nothing.
    pub method: String,
    /// What a page says where a pointer or the keyboard is on them, beside the method.
    pub says: String,
}

impl Series {
    fn new(look: Look, filled: bool, join: Join, points: Vec<(f64, f64)>) -> Self {
        let (method, says) = (String::new(), String::new());
        Self { look, filled, join, marked: true, points, method, says }
    }

    /// Points that are not joined.
    pub fn points(look: Look, filled: bool, points: Vec<(f64, f64)>) -> Self {
        Self::new(look, filled, Join::No, points)
    }

    /// Points on a line.
    pub fn line(look: Look, points: Vec<(f64, f64)>) -> Self {
        Self::new(look, true, Join::Straight, points)
    }

    /// The same, which lights up with a method.
    #[must_use]
    pub fn of(self, method: impl Into<String>) -> Self {
        Self { method: method.into(), ..self }
    }

    /// The same, of which a page says this.
    #[must_use]
    pub fn says(self, says: impl Into<String>) -> Self {
        Self { says: says.into(), ..self }
    }

    /// A line without points.
    pub fn bare(ink: Ink, points: Vec<(f64, f64)>) -> Self {
        Self { marked: false, ..Self::line(Look::plain(ink), points) }
    }

    /// The border of what is beaten by a front.
    pub fn front(points: Vec<(f64, f64)>) -> Self {
        Self { join: Join::Step, ..Self::bare(Ink::Muted, points) }
    }
}

/// All points of some series.
pub fn points(series: &[Series]) -> impl Iterator<Item = (f64, f64)> {
    series.iter().flat_map(|series| series.points.iter().copied())
}

/// Points and lines in two dimensions.
pub struct Plane {
    /// What stands above it.
    pub title: String,
    /// The axis across.
    pub x: Axis,
    /// The axis up.
    pub y: Axis,
    /// Height in units of the drawing.
    pub height: i32,
    /// Points and lines.
    pub series: Vec<Series>,
    /// Dashed lines across; the legend says what they stand for.
    pub rules: Vec<f64>,
    /// Texts beside points. One that is a method's name lights up with it.
    pub labels: Vec<(f64, f64, String)>,
}

/// A cell of a map.
pub struct Square {
    /// From 0, nothing to show, to 1: the share of the cell that is filled.
    pub weight: f64,
    /// Stands in the cell where there is room.
    pub text: String,
}

/// A grid of cells.
pub struct Map {
    /// What stands above it.
    pub title: String,
    /// Heads of the columns.
    pub columns: Vec<String>,
    /// The rows: methods, which light up on a page, with their cells.
    pub rows: Vec<(String, Vec<Square>)>,
}

/// One of the charts of a figure.
pub enum Panel {
    /// Rows by category.
    Rows(Rows),
    /// Points and lines.
    Plane(Plane),
    /// Takes a line for itself.
    Map(Map),
}

impl Panel {
    /// Rows with room behind the marks for their notes, and a line at some value.
    pub fn rows(title: &str, axis: Axis, rule: Option<f64>, groups: Vec<Group>) -> Self {
        let notes = groups.iter().flat_map(|g| &g.rows).map(|r| r.note.chars().count()).max();
        let axis = axis.with_room(0.035 * notes.unwrap_or(0) as f64);
        Self::Rows(Rows { title: title.into(), axis, rule, groups })
    }

    /// Points and lines.
    pub fn plane(title: &str, x: Axis, y: Axis, height: i32, series: Vec<Series>) -> Self {
        Self::Plane(Plane::new(title, x, y, height, series))
    }
}

impl Plane {
    /// Points and lines, without rules and labels.
    pub fn new(title: &str, x: Axis, y: Axis, height: i32, series: Vec<Series>) -> Self {
        let (rules, labels) = (Vec::new(), Vec::new());
        Self { title: title.into(), x, y, height, series, rules, labels }
    }
}

/// What an entry of a legend explains.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Sample {
    /// A point, filled or not.
    Point(Look, bool),
    /// A rule across a plane.
    Dashes,
    /// A line without points.
    Line(Ink),
}

/// An entry of a legend.
pub struct Entry {
    /// What it explains.
    pub sample: Sample,
    /// What that stands for.
    pub text: String,
    /// The method that it lights up with on a page, or nothing.
    pub method: String,
}

impl Entry {
    /// What a sample stands for.
    pub fn new(sample: Sample, text: impl Into<String>) -> Self {
        Self { sample, text: text.into(), method: String::new() }
    }

    /// What filled points stand for.
    pub fn of(look: Look, text: impl Into<String>) -> Self {
        Self::new(Sample::Point(look, true), text)
    }

    /// The same, which lights up with a method.
    #[must_use]
    pub fn lit_with(self, method: impl Into<String>) -> Self {
        Self { method: method.into(), ..self }
    }
}

/// Everything that is drawn in one figure.
#[derive(Default)]
pub struct Drawing {
    /// The charts.
    pub panels: Vec<Panel>,
    /// What looks stand for.
    pub legend: Vec<Entry>,
    /// Sentences below the charts.
    pub key: Vec<String>,
}

impl Drawing {
    /// Charts without a legend.
    pub fn of(panels: Vec<Panel>) -> Self {
        Self { panels, ..Self::default() }
    }
}
