//! The chart functions that every figure is an instance of: rows (bars, dots and spans by
//! category) and planes (points and lines in two dimensions).
//!
//! A figure is drawn twice, wide and narrow, because text that is scaled down with a wide
//! drawing is too small to read on a phone.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::format::{power_of_ten, times_power_of_ten};
use crate::text::cut;
use crate::theme::{Ink, finish_svg};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Grid<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Heights in pixels of the parts of a drawing, and the size of its text.
const TEXT: i32 = 12;
const ROW: i32 = 17;
const HEADING: i32 = 24;
const TITLE: i32 = 26;
const AXIS: i32 = 44;
const LEGEND: i32 = 20;

/// How wide a drawing is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// For screens and paper: panels stand side by side.
    Wide,
    /// For phones: panels stand below each other.
    Narrow,
}

impl Layout {
    fn width(self) -> i32 {
        match self {
            Self::Wide => 860,
            Self::Narrow => 358,
        }
    }
}

/// How values become places.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    /// Decades, or 1-2-5 steps where there are few. Zeros lie on a floor line below all values.
    Log,
    /// Powers of two, for sizes in memory.
    Binary,
}

/// An axis: its name, scale and ends.
pub(crate) struct Axis {
    name: String,
    scale: Scale,
    low: f64,
    high: f64,
    /// Whether `low` stands for zero.
    floor: bool,
    /// Ends of a stretch without values that is drawn short, with a break in the axis.
    gap: Option<(f64, f64)>,
    write: fn(f64) -> String,
}

impl Axis {
    /// An axis that holds all values. A linear axis starts at the smallest value given, so pass
    /// a 0 where lengths are read.
    pub(crate) fn over(
        name: &str,
        scale: Scale,
        values: impl IntoIterator<Item = f64>,
        write: fn(f64) -> String,
    ) -> Self {
        let values: Vec<f64> = values.into_iter().filter(|x| x.is_finite()).collect();
        let min = |keep: fn(f64) -> bool| {
            values.iter().copied().filter(|&x| keep(x)).fold(f64::INFINITY, f64::min)
        };
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (low, high, floor) = match scale {
            Scale::Linear => {
                let low = min(|_| true);
                if low.is_finite() { (low, high, false) } else { (0.0, 1.0, false) }
            }
            Scale::Log | Scale::Binary => {
                let zeros = values.iter().any(|&x| x <= 0.0);
                let low = min(|x| x > 0.0);
                if low.is_finite() { (low, high, zeros) } else { (0.1, 1.0, zeros) }
            }
        };
        let (low, high) = match scale {
            Scale::Linear if low == high => (low - 0.5, high + 0.5),
            Scale::Linear => (low, high),
            // Half a decade of air tells a point from the frame; zeros need a decade of their own.
            Scale::Log if high / low > 30.0 || floor => {
                let low = 10f64.powf(low.log10().floor());
                (if floor { low / 10.0 } else { low }, 10f64.powf((high * 1.2).log10().ceil()))
            }
            Scale::Log => (low / 1.15, high * 1.15),
            Scale::Binary => (low / 1.3, high * 1.3),
        };
        Self { name: name.into(), scale, low, high, floor, gap: None, write }
    }

    /// The same logarithmic axis, broken where its values leave more than three decades empty,
    /// so that what differs little within a cluster does not vanish.
    pub(crate) fn broken(mut self, values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> =
            values.into_iter().filter(|x| *x > 0.0 && x.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let widest = sorted
            .windows(2)
            .map(|w| (w[0], w[1]))
            .max_by(|a, b| (a.1 / a.0).total_cmp(&(b.1 / b.0)));
        if let (Some((below, above)), false) = (widest, self.floor)
            && above / below > 1e3
        {
            self.low = sorted[0] / 1.6;
            self.high = sorted[sorted.len() - 1] * 1.6;
            self.gap = Some((below * 1.6, above / 1.6));
        }
        self
    }

    pub(crate) fn is_broken(&self) -> bool {
        self.gap.is_some()
    }

    /// The same linear axis with air on both sides.
    pub(crate) fn with_margin(mut self) -> Self {
        let air = (self.high - self.low) * 0.06;
        self.low -= air;
        self.high += air;
        self
    }

    /// The same axis with room on the right for text.
    fn with_room(mut self, share: f64) -> Self {
        match self.scale {
            Scale::Linear => self.high += (self.high - self.low) * share,
            Scale::Log | Scale::Binary => self.high *= (self.high / self.low).powf(share),
        }
        self
    }

    fn place(&self, x: f64) -> f64 {
        match self.scale {
            Scale::Linear => x.clamp(self.low, self.high),
            Scale::Log | Scale::Binary => {
                let x = x.max(self.low).min(self.high).log10();
                let Some((from, to)) = self.gap.map(|(a, b)| (a.log10(), b.log10())) else {
                    return x;
                };
                // The break takes a tenth of what the values take.
                let values = self.high.log10() - self.low.log10() - (to - from);
                let short = values / 10.0;
                if x <= from {
                    x
                } else if x < to {
                    from + (x - from) / (to - from) * short
                } else {
                    x - (to - from) + short
                }
            }
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.place(self.low)..self.place(self.high)
    }

    /// At most `count` values with their labels, smallest first.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "exponents of finite floats, and steps of at least 1"
    )]
    fn ticks(&self, count: i32) -> Vec<(f64, String)> {
        let count = f64::from(count.max(2));
        let inside =
            |x: &f64| *x >= self.low * (1.0 - 1e-9) - 1e-300 && *x <= self.high * (1.0 + 1e-9);
        match self.scale {
            Scale::Linear => {
                let raw = (self.high - self.low) / count;
                let ten = 10f64.powf(raw.log10().floor());
                let step =
                    [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * ten).into_iter().find(|s| *s >= raw);
                let step = step.unwrap_or(raw);
                let first = (self.low / step - 1e-9).ceil() as i64;
                let last = (self.high / step + 1e-9).floor() as i64;
                (first..=last).map(|i| i as f64 * step).map(|x| (x, (self.write)(x))).collect()
            }
            Scale::Log => {
                let (first, last) = (self.low.log10().floor(), self.high.log10().ceil());
                if let Some((from, to)) = self.gap {
                    let decades = self.high.log10() - self.low.log10() - (to / from).log10();
                    let steps: &[f64] =
                        if decades * 3.0 < count { &[1.0, 2.0, 5.0] } else { &[1.0] };
                    return (first as i32..=last as i32)
                        .flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)))
                        .filter(inside)
                        .filter(|x| *x <= from || *x >= to)
                        .map(|x| (x, times_power_of_ten(x)))
                        .collect();
                }
                let decades = last - first;
                if self.high / self.low <= 300.0 && !self.floor {
                    let steps: &[f64] = if self.high / self.low < 6.0 {
                        &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0]
                    } else {
                        &[1.0, 2.0, 5.0]
                    };
                    return (first as i32..=last as i32)
                        .flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)))
                        .filter(inside)
                        .map(|x| (x, (self.write)(x)))
                        .collect();
                }
                let step = (decades / count).ceil().max(1.0) as usize;
                let mut ticks: Vec<(f64, String)> = (first as i32..=last as i32)
                    .rev()
                    .step_by(step)
                    .map(|e| (10f64.powi(e), power_of_ten(e)))
                    .filter(|(x, _)| inside(x))
                    .filter(|(x, _)| !self.floor || *x > self.low * 5.0)
                    .collect();
                if self.floor {
                    ticks.push((self.low, "0".into()));
                }
                ticks.reverse();
                ticks
            }
            Scale::Binary => {
                let (first, last) = (self.low.log2().ceil(), self.high.log2().floor());
                let step = ((last - first) / count).ceil().max(1.0) as i32;
                // Aligned to the step, so that KiB and MiB fall on ticks.
                ((first as i32).div_euclid(step)..=(last as i32).div_euclid(step))
                    .map(|i| 2f64.powi(i * step))
                    .filter(inside)
                    .map(|x| (x, (self.write)(x)))
                    .collect()
            }
        }
    }
}

/// The shape of a point, so that no meaning hangs on colour alone.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
}

/// How a method, or whatever a series stands for, is drawn everywhere.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Look {
    pub(crate) ink: Ink,
    pub(crate) shape: Shape,
}

impl Look {
    /// The look of the `i`th series: seven colours and five shapes share no divisor, so 35
    /// looks differ.
    pub(crate) fn of(i: usize) -> Self {
        let shapes = [Shape::Circle, Shape::Square, Shape::Up, Shape::Diamond, Shape::Down];
        Self { ink: Ink::series(i), shape: shapes[i % shapes.len()] }
    }
}

/// What a row shows.
pub(crate) enum Mark {
    /// A bar from the left end of the axis.
    Bar(f64),
    /// A thin line between two values.
    Span(f64, f64),
    /// A point; hollow where `filled` is false.
    Point { at: f64, shape: Shape, filled: bool },
}

/// A labelled row of marks in one colour, with a note behind them.
pub(crate) struct Row {
    pub(crate) label: String,
    pub(crate) ink: Ink,
    pub(crate) marks: Vec<Mark>,
    pub(crate) note: String,
}

/// Rows under a heading.
pub(crate) struct Group {
    pub(crate) heading: String,
    pub(crate) rows: Vec<Row>,
}

/// Rows by category.
pub(crate) struct Rows {
    pub(crate) title: String,
    pub(crate) axis: Axis,
    /// A value to draw a line at.
    pub(crate) rule: Option<f64>,
    pub(crate) groups: Vec<Group>,
}

/// How the points of a series are joined.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Join {
    No,
    Straight,
    /// Right, then down: the border of what is beaten by a front.
    Step,
}

/// Points of one look.
pub(crate) struct Series {
    pub(crate) look: Look,
    pub(crate) filled: bool,
    pub(crate) join: Join,
    pub(crate) marked: bool,
    pub(crate) points: Vec<(f64, f64)>,
}

/// Points and lines in two dimensions.
pub(crate) struct Plane {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) height: i32,
    pub(crate) series: Vec<Series>,
    /// Dashed lines across; the legend says what they stand for.
    pub(crate) rules: Vec<f64>,
    /// Texts beside points.
    pub(crate) labels: Vec<(f64, f64, String)>,
}

/// A cell of a map.
pub(crate) struct Cell {
    /// From 0, nothing to show, to 1: the share of the cell that is filled.
    pub(crate) weight: f64,
    /// Stands in the cell where there is room.
    pub(crate) text: String,
}

/// A grid of cells.
pub(crate) struct Map {
    pub(crate) title: String,
    /// Heads of the columns.
    pub(crate) columns: Vec<String>,
    /// Labels of the rows with their cells.
    pub(crate) rows: Vec<(String, Vec<Cell>)>,
}

/// One of the charts of a figure.
pub(crate) enum Panel {
    Rows(Rows),
    Plane(Plane),
    /// Takes a line for itself.
    Map(Map),
}

/// What an entry of a legend explains.
pub(crate) enum Sample {
    Point(Look, bool),
    /// A rule across a plane.
    Dashes,
    /// A line without points.
    Line(Ink),
}

/// An entry of a legend.
pub(crate) struct Entry {
    pub(crate) sample: Sample,
    pub(crate) text: String,
}

/// Everything that is drawn in one figure.
#[derive(Default)]
pub(crate) struct Drawing {
    pub(crate) panels: Vec<Panel>,
    pub(crate) legend: Vec<Entry>,
    /// Sentences below the charts.
    pub(crate) key: Vec<String>,
}

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw {figure}: {message}")]
pub struct DrawError {
    figure: String,
    message: String,
}

/// Width of a text in pixels: an estimate that errs on the wide side for most fonts.
fn text_width(text: &str, size: i32) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "texts are short")]
    let width = (text.chars().count() as f64 * f64::from(size) * 0.56).ceil() as i32;
    width
}

fn px(n: usize) -> i32 {
    i32::try_from(n).unwrap_or(i32::MAX)
}

impl Rows {
    fn height(&self) -> i32 {
        let rows: usize = self.groups.iter().map(|g| g.rows.len()).sum();
        TITLE + px(self.groups.len()) * HEADING + px(rows) * ROW + 6 + AXIS
    }
}

impl Plane {
    fn title_height(&self) -> i32 {
        if self.title.is_empty() { 6 } else { TITLE }
    }
}

impl Panel {
    fn height(&self) -> i32 {
        match self {
            Self::Rows(rows) => rows.height(),
            Self::Plane(plane) => plane.title_height() + plane.height + AXIS,
            Self::Map(map) => TITLE + HEADING + px(map.rows.len()) * ROW + 6,
        }
    }
}

/// Draws a figure as a standalone SVG file. `name`, `title` and `description` are for readers
/// that cannot see it.
pub(crate) fn draw(
    drawing: &Drawing,
    layout: Layout,
    name: &str,
    title: &str,
    description: &str,
) -> Result<String, DrawError> {
    let width = layout.width();
    let has_map = drawing.panels.iter().any(|panel| matches!(panel, Panel::Map(_)));
    let columns = match layout {
        // Three that are to be compared stand in one line.
        Layout::Wide if !has_map && drawing.panels.len() == 3 => 3,
        Layout::Wide if !has_map => px(drawing.panels.len()).clamp(1, 2),
        _ => 1,
    };
    let lines: Vec<&[Panel]> =
        drawing.panels.chunks(usize::try_from(columns).unwrap_or(1)).collect();
    let line_height = |line: &[Panel]| line.iter().map(Panel::height).max().unwrap_or(0);
    let legend = legend_places(&drawing.legend, width);
    let legend_height = legend.last().map_or(0, |(_, y)| y + LEGEND + 6);
    let key_columns = if layout == Layout::Wide && drawing.key.len() > 2 { 2 } else { 1 };
    let key_rows = px(drawing.key.len().div_ceil(key_columns));
    let key_columns = px(key_columns);
    let key_height = if key_rows > 0 { key_rows * ROW + 8 } else { 0 };
    let height = legend_height + lines.iter().map(|l| line_height(l)).sum::<i32>() + key_height + 4;

    let mut svg = String::new();
    let drawn = {
        let size = (width.unsigned_abs(), height.unsigned_abs());
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        (|| -> Drawn {
            root.draw(&Rectangle::new([(0, 0), (width, height)], Ink::Paper.rgb().filled()))?;
            for (entry, &(x, y)) in drawing.legend.iter().zip(&legend) {
                let middle = y + LEGEND / 2;
                match entry.sample {
                    Sample::Point(look, filled) => mark(&root, (x + 7, middle), look, filled, 5)?,
                    Sample::Dashes => dashes(&root, (x, middle), x + 14, Ink::Text)?,
                    Sample::Line(ink) => line(&root, (x, middle), (x + 14, middle), ink, 2)?,
                }
                text(&root, &entry.text, (x + 18, y + LEGEND / 2), Ink::Text, HPos::Left)?;
            }
            let mut top = legend_height;
            for line in &lines {
                for (i, panel) in line.iter().enumerate() {
                    let left = px(i) * width / columns;
                    let at = Place { left, right: left + width / columns, top };
                    match panel {
                        Panel::Rows(rows) => draw_rows(&root, rows, at)?,
                        Panel::Plane(plane) => draw_plane(&root, plane, at)?,
                        Panel::Map(map) => draw_map(&root, map, at)?,
                    }
                }
                top += line_height(line);
            }
            for (i, sentence) in drawing.key.iter().enumerate() {
                let (column, row) = (px(i) / key_rows.max(1), px(i) % key_rows.max(1));
                let at = (8 + column * width / key_columns, top + row * ROW + ROW / 2);
                let room = usize::try_from((width / key_columns - 12) * 100 / (TEXT * 53));
                text(&root, &cut(sentence, room.unwrap_or(0)), at, Ink::Text, HPos::Left)?;
            }
            root.present()
        })()
    };
    drawn.map_err(|e| DrawError { figure: name.into(), message: e.to_string() })?;
    Ok(finish_svg(&svg, name, title, description))
}

/// Where legend entries stand: in lines, broken where the next does not fit.
fn legend_places(entries: &[Entry], width: i32) -> Vec<(i32, i32)> {
    let (mut x, mut y) = (4, 0);
    entries
        .iter()
        .map(|e| {
            let w = 18 + text_width(&e.text, TEXT) + 14;
            if x > 4 && x + w - 14 > width {
                (x, y) = (4, y + LEGEND);
            }
            let at = (x, y);
            x += w;
            at
        })
        .collect()
}

/// Where a panel lies in a drawing.
#[derive(Clone, Copy)]
struct Place {
    left: i32,
    right: i32,
    top: i32,
}

fn style(ink: Ink, size: i32, h: HPos, v: VPos) -> TextStyle<'static> {
    // The backend divides sizes by 1.24; this undoes it.
    let font = FontDesc::new(FontFamily::SansSerif, f64::from(size) * 1.24, FontStyle::Normal);
    let mut style = TextStyle::from(font).pos(Pos::new(h, v));
    style.color = ink.rgb().to_backend_color();
    style
}

fn text(area: &Area, what: &str, at: (i32, i32), ink: Ink, h: HPos) -> Drawn {
    area.draw(&Text::new(what.to_string(), at, style(ink, TEXT, h, VPos::Center)))
}

fn line(area: &Area, from: (i32, i32), to: (i32, i32), ink: Ink, width: u32) -> Drawn {
    area.draw(&PathElement::new([from, to], ink.rgb().stroke_width(width)))
}

fn dashes(area: &Area, from: (i32, i32), to: i32, ink: Ink) -> Drawn {
    let mut x = from.0;
    while x < to {
        line(area, (x, from.1), ((x + 5).min(to), from.1), ink, 1)?;
        x += 9;
    }
    Ok(())
}

/// The edge of a break in an axis.
fn dotted(area: &Area, from: (i32, i32), to: i32) -> Drawn {
    let mut x = from.0;
    while x < to {
        line(area, (x, from.1), ((x + 2).min(to), from.1), Ink::Grid, 1)?;
        x += 6;
    }
    Ok(())
}

fn mark(area: &Area, (x, y): (i32, i32), look: Look, filled: bool, r: i32) -> Drawn {
    let corners: Vec<(i32, i32)> = match look.shape {
        Shape::Circle => {
            let r = r.unsigned_abs() + 1;
            // A rim of paper keeps points apart that lie on each other.
            area.draw(&Circle::new((x, y), r + 1, Ink::Paper.rgb().filled()))?;
            return if filled {
                area.draw(&Circle::new((x, y), r, look.ink.rgb().filled()))
            } else {
                area.draw(&Circle::new((x, y), r - 1, look.ink.rgb().stroke_width(2)))
            };
        }
        Shape::Square => vec![(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)],
        Shape::Up => vec![(x, y - r - 1), (x + r + 1, y + r), (x - r - 1, y + r)],
        Shape::Down => vec![(x, y + r + 1), (x + r + 1, y - r), (x - r - 1, y - r)],
        Shape::Diamond => {
            vec![(x, y - r - 2), (x + r + 1, y), (x, y + r + 2), (x - r - 1, y)]
        }
    };
    let closed: Vec<_> = corners.iter().chain(&corners[..2]).copied().collect();
    let fill = if filled { look.ink } else { Ink::Paper };
    let rim = if filled { Ink::Paper } else { look.ink };
    if filled {
        area.draw(&PathElement::new(closed, rim.rgb().stroke_width(2)))?;
        area.draw(&Polygon::new(corners, fill.rgb()))
    } else {
        area.draw(&Polygon::new(corners, fill.rgb()))?;
        area.draw(&PathElement::new(closed, rim.rgb().stroke_width(2)))
    }
}

/// Draws title, grid, ticks and names of axes, and returns the place of values. An axis `y` of
/// `None` leaves the vertical to rows.
fn frame<'a>(
    root: &Area<'a>,
    title: &str,
    x: &Axis,
    y: Option<&Axis>,
    inner: (i32, i32, i32, i32),
    panel: Place,
) -> Result<Grid<'a>, DrawingAreaErrorKind<std::io::Error>> {
    let (left, right, top, bottom) = inner;
    let down = y.map_or(0.0..1.0, Axis::range);
    let grid = root.clone().apply_coord_spec(Cartesian2d::<RangedCoordf64, RangedCoordf64>::new(
        x.range(),
        down.clone(),
        (left..right, bottom..top),
    ));
    let heading = style(Ink::Text, TEXT + 1, HPos::Left, VPos::Center);
    root.draw(&Text::new(title.to_string(), (panel.left + 4, panel.top + 10), heading))?;
    for (value, label) in x.ticks((right - left) / 62) {
        let (at, _) = grid.map_coordinate(&(x.place(value), down.start));
        line(root, (at, top), (at, bottom), Ink::Grid, 1)?;
        text(root, &label, (at, bottom + 12), Ink::Muted, HPos::Center)?;
    }
    let middle = i32::midpoint(left, right);
    text(root, &x.name, (middle, bottom + 30), Ink::Text, HPos::Center)?;
    if let Some(y) = y {
        for (value, label) in y.ticks((bottom - top) / 34) {
            let (_, at) = grid.map_coordinate(&(x.range().start, y.place(value)));
            line(root, (left, at), (right, at), Ink::Grid, 1)?;
            text(root, &label, (left - 6, at), Ink::Muted, HPos::Right)?;
        }
        line(root, (left, top), (left, bottom), Ink::Muted, 1)?;
        if let Some((from, to)) = y.gap {
            let at = |v| grid.map_coordinate(&(x.range().start, y.place(v))).1;
            let (low, high) = (at(from), at(to));
            let back = [(left - 3, high + 4), (right, low - 4)];
            root.draw(&Rectangle::new(back, Ink::Paper.rgb().filled()))?;
            for edge in [high + 4, low - 4] {
                line(root, (left - 6, edge + 3), (left + 6, edge - 3), Ink::Muted, 1)?;
                dotted(root, (left + 8, edge), right)?;
            }
        }
    }
    line(root, (left, bottom), (right, bottom), Ink::Muted, 1)?;
    Ok(grid)
}

fn draw_rows(root: &Area, rows: &Rows, panel: Place) -> Drawn {
    let labels = rows.groups.iter().flat_map(|g| &g.rows).map(|r| text_width(&r.label, TEXT));
    let left = panel.left + 14 + labels.max().unwrap_or(0).min((panel.right - panel.left) / 2);
    let right = panel.right - 20;
    let top = panel.top + TITLE - 4;
    let bottom = panel.top + rows.height() - AXIS;
    let grid = frame(root, &rows.title, &rows.axis, None, (left, right, top, bottom), panel)?;
    let at = |value: f64| grid.map_coordinate(&(rows.axis.place(value), 0.0)).0;
    let mut y = top + 4;
    for group in &rows.groups {
        // The heading stands on the grid; paper beneath keeps it legible.
        let end = panel.left + 8 + text_width(&group.heading, TEXT);
        let back = [(panel.left + 2, y + 4), (end.min(panel.right), y + HEADING - 2)];
        root.draw(&Rectangle::new(back, Ink::Paper.rgb().filled()))?;
        text(root, &group.heading, (panel.left + 4, y + HEADING / 2 + 2), Ink::Text, HPos::Left)?;
        y += HEADING;
        for row in &group.rows {
            let middle = y + ROW / 2;
            text(root, &row.label, (left - 6, middle), Ink::Muted, HPos::Right)?;
            let mut end = left;
            for m in &row.marks {
                match *m {
                    Mark::Bar(value) => {
                        let corners = [(left, y + 2), (at(value), y + ROW - 2)];
                        root.draw(&Rectangle::new(corners, row.ink.rgb().filled()))?;
                        end = end.max(at(value));
                    }
                    Mark::Span(a, b) => {
                        line(root, (at(a), middle), (at(b), middle), row.ink, 2)?;
                        end = end.max(at(a).max(at(b)));
                    }
                    Mark::Point { at: value, shape, filled } => {
                        let look = Look { ink: row.ink, shape };
                        mark(root, (at(value), middle), look, filled, 4)?;
                        end = end.max(at(value) + 5);
                    }
                }
            }
            if !row.note.is_empty() {
                text(root, &row.note, (end + 5, middle), Ink::Text, HPos::Left)?;
            }
            y += ROW;
        }
    }
    if let Some(rule) = rows.rule {
        line(root, (at(rule), top), (at(rule), bottom), Ink::Muted, 1)?;
    }
    Ok(())
}

fn draw_map(root: &Area, map: &Map, panel: Place) -> Drawn {
    let labels = map.rows.iter().map(|(label, _)| text_width(label, TEXT)).max().unwrap_or(0);
    let left = panel.left + 10 + labels.min((panel.right - panel.left) / 2);
    let cell = (panel.right - 4 - left) / px(map.columns.len()).max(1);
    let at = |column: usize| left + px(column) * cell + cell / 2;
    let heading = style(Ink::Text, TEXT + 1, HPos::Left, VPos::Center);
    root.draw(&Text::new(map.title.clone(), (panel.left + 4, panel.top + 10), heading))?;
    let mut y = panel.top + TITLE;
    for (column, head) in map.columns.iter().enumerate() {
        text(root, head, (at(column), y + HEADING / 2), Ink::Muted, HPos::Center)?;
    }
    y += HEADING;
    for (label, cells) in &map.rows {
        let middle = y + ROW / 2;
        // The label of a narrow map is cut where it would run into the cells.
        let room = usize::try_from((left - panel.left) * 100 / (TEXT * 56)).unwrap_or(0);
        text(root, &cut(label, room), (left - 6, middle), Ink::Muted, HPos::Right)?;
        line(root, (left, y + ROW), (left + px(map.columns.len()) * cell, y + ROW), Ink::Grid, 1)?;
        for (column, Cell { weight, text: says }) in cells.iter().enumerate() {
            let centre = at(column);
            let has_room = text_width(says, TEXT) + 13 <= cell;
            // The area of the square is the weight.
            #[expect(clippy::cast_possible_truncation, reason = "a few pixels")]
            let half = (weight.clamp(0.0, 1.0).sqrt() * f64::from(ROW - 5) / 2.0).round() as i32;
            // Beside its text where that has room, else in the same place without.
            let middle_x = if cell > 24 { centre - cell / 2 + 7 } else { centre };
            if half > 0 {
                let corners = [(middle_x - half, middle - half), (middle_x + half, middle + half)];
                root.draw(&Rectangle::new(corners, Ink::series(1).rgb().filled()))?;
            }
            if has_room {
                let place = (centre - cell / 2 + 14, middle);
                text(root, says, place, Ink::Text, HPos::Left)?;
            }
        }
        y += ROW;
    }
    Ok(())
}

fn draw_plane(root: &Area, plane: &Plane, panel: Place) -> Drawn {
    let top = panel.top + plane.title_height() + 16;
    let bottom = panel.top + plane.title_height() + plane.height;
    let labels = plane.y.ticks((bottom - top) / 34);
    let widest = labels.iter().map(|(_, l)| text_width(l, TEXT)).max().unwrap_or(0);
    let (left, right) = (panel.left + 14 + widest, panel.right - 24);
    let grid =
        frame(root, &plane.title, &plane.x, Some(&plane.y), (left, right, top, bottom), panel)?;
    // The name of the vertical axis stands above it, upright: nobody turns a screen.
    text(root, &plane.y.name, (panel.left + 4, top - 12), Ink::Muted, HPos::Left)?;
    let at = |&(x, y): &(f64, f64)| grid.map_coordinate(&(plane.x.place(x), plane.y.place(y)));

    for rule in &plane.rules {
        let (_, y) = at(&(plane.x.low, *rule));
        dashes(root, (left, y), right, Ink::Text)?;
    }
    for s in &plane.series {
        let places: Vec<(i32, i32)> = s.points.iter().map(at).collect();
        let joined = match s.join {
            Join::No => Vec::new(),
            Join::Straight => places.clone(),
            Join::Step => {
                let mut corners = Vec::new();
                if let Some(&(x, _)) = places.first() {
                    corners.push((x, top));
                }
                for (i, &(x, y)) in places.iter().enumerate() {
                    corners.push((x, y));
                    corners.push((places.get(i + 1).map_or(right, |next| next.0), y));
                }
                corners
            }
        };
        if joined.len() > 1 {
            root.draw(&PathElement::new(joined, s.look.ink.rgb().stroke_width(2)))?;
        }
        if s.marked {
            for &place in &places {
                mark(root, place, s.look, s.filled, 4)?;
            }
        }
    }
    // A label keeps away from those before it, from all points and from the frame.
    let mut taken: Vec<(i32, i32, i32, i32)> = Vec::new();
    let points: Vec<(i32, i32)> =
        plane.series.iter().filter(|s| s.marked).flat_map(|s| s.points.iter().map(at)).collect();
    for (x, y, what) in &plane.labels {
        let (x, y) = at(&(*x, *y));
        let w = text_width(what, TEXT) + 2;
        let free = |&(dx, dy): &(i32, i32)| {
            let (l, t) = (x + dx - w / 2, y + dy - 8);
            let (r, b) = (l + w, t + 16);
            let over =
                |&(l2, t2, r2, b2): &(i32, i32, i32, i32)| l < r2 && l2 < r && t < b2 && t2 < b;
            let hits = points
                .iter()
                .filter(|&&(px, py)| l - 4 < px && px < r + 4 && t - 3 < py && py < b + 3)
                .count();
            let outside = l < left || r > right || t < top || b > bottom;
            if outside || taken.iter().any(over) { usize::MAX } else { hits }
        };
        let around = [14, 20, 28, 38].into_iter().flat_map(|d| {
            let side = d + w / 2 - 4;
            [
                (-side, d - 6),
                (-side, 0),
                (0, d),
                (-side, -d + 6),
                (side, -d + 6),
                (side, 0),
                (0, -d),
                (side, d),
            ]
        });
        let best = around.min_by_key(free).unwrap_or((0, -14));
        let centre = (x + best.0, y + best.1);
        taken.push((centre.0 - w / 2, centre.1 - 8, centre.0 + w / 2, centre.1 + 8));
        if best.0.abs() > 24 + w / 2 || best.1.abs() > 24 {
            line(root, (x, y), centre, Ink::Muted, 1)?;
        }
        text(root, what, centre, Ink::Text, HPos::Center)?;
    }
    Ok(())
}

impl Rows {
    /// Rows with room behind the marks for their notes.
    pub(crate) fn new(title: &str, axis: Axis, rule: Option<f64>, groups: Vec<Group>) -> Self {
        let notes = groups.iter().flat_map(|g| &g.rows).map(|r| r.note.chars().count()).max();
        let axis = axis.with_room(0.035 * notes.unwrap_or(0) as f64);
        Self { title: title.into(), axis, rule, groups }
    }
}
