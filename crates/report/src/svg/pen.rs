//! What panels are drawn with: texts, lines, marks and frames.

use std::convert::Infallible;

use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::element::{Drawable, PointCollection};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters_backend::{BackendCoord, DrawingErrorKind};

use super::backend::{Backend, colour, filled_and_rimmed};
use crate::figure::{Axis, Ink, Look, Shape};
use crate::inline::escape;

pub(super) type Area<'a> = DrawingArea<Backend<'a>, Shift>;
pub(super) type Grid<'a, Y> = DrawingArea<Backend<'a>, Cartesian2d<Axis, Y>>;
pub(super) type Problem = DrawingAreaErrorKind<Infallible>;
pub(super) type Drawn = Result<(), Problem>;

/// Heights in pixels of the parts of a drawing, and the size of its text.
pub(super) const TEXT: i32 = 12;
pub(super) const ROW: i32 = 17;
pub(super) const HEADING: i32 = 24;
pub(super) const TITLE: i32 = 26;
pub(super) const AXIS: i32 = 44;
pub(super) const LEGEND: i32 = 20;

/// Width of a text in pixels: an estimate that errs on the wide side for most fonts.
pub(super) fn text_width(text: &str, size: i32) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "texts are short")]
    let width = (text.chars().count() as f64 * f64::from(size) * 0.56).ceil() as i32;
    width
}

pub(super) fn px(n: usize) -> i32 {
    i32::try_from(n).unwrap_or(i32::MAX)
}

/// Where a panel lies in a drawing.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
}

/// SVG that plotters has no elements for.
struct Raw(String);

impl<'a> PointCollection<'a, BackendCoord> for &'a Raw {
    type Point = &'a BackendCoord;
    type IntoIter = std::iter::Empty<&'a BackendCoord>;
    fn point_iter(self) -> Self::IntoIter {
        std::iter::empty()
    }
}

impl Drawable<Backend<'_>> for Raw {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        _: I,
        backend: &mut Backend<'_>,
        _: (u32, u32),
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        backend.out.push_str(&self.0);
        Ok(())
    }
}

/// Draws what lights up with a method, of which a page says something; all that `draw` draws where there is
/// no method.
pub(super) fn lit_with<R>(
    area: &Area,
    (method, says): (&str, &str),
    draw: impl FnOnce() -> Result<R, Problem>,
) -> Result<R, Problem> {
    if method.is_empty() {
        return draw();
    }
    let title = match says {
        "" => String::new(),
        says => format!("<title>{}: {}</title>", escape(method), escape(says)),
    };
    area.draw(&Raw(format!("<g data-method=\"{}\">{title}\n", escape(method))))?;
    let drawn = draw()?;
    area.draw(&Raw("</g>\n".into()))?;
    Ok(drawn)
}

fn text_of(area: &Area, what: &str, at: (i32, i32), ink: Ink, (h, size): (HPos, i32)) -> Drawn {
    let font = FontDesc::new(FontFamily::SansSerif, f64::from(size), FontStyle::Normal);
    let colour = colour(ink);
    let style = TextStyle::from(font).pos(Pos::new(h, VPos::Center)).color(&colour);
    area.draw(&Text::new(what, at, style))
}

pub(super) fn text(area: &Area, what: &str, at: (i32, i32), ink: Ink, h: HPos) -> Drawn {
    text_of(area, what, at, ink, (h, TEXT))
}

/// The title of a panel.
pub(super) fn title(area: &Area, what: &str, panel: Place) -> Drawn {
    let at = (panel.left + 4, panel.top + 10);
    text_of(area, what, at, Ink::Text, (HPos::Left, TEXT + 1))
}

pub(super) fn line(area: &Area, from: (i32, i32), to: (i32, i32), ink: Ink, width: u32) -> Drawn {
    area.draw(&PathElement::new([from, to], colour(ink).stroke_width(width)))
}

/// A line of dashes, each so long and so far from the next.
pub(super) fn dashes(
    area: &Area,
    (x, y): (i32, i32),
    to: i32,
    [length, step]: [i32; 2],
    ink: Ink,
) -> Drawn {
    let mut starts = (x..to).step_by(step.unsigned_abs() as usize);
    starts.try_for_each(|x| line(area, (x, y), ((x + length).min(to), y), ink, 1))
}

/// A point. A rim of paper keeps points apart that lie on each other.
pub(super) fn mark(area: &Area, (x, y): (i32, i32), look: Look, filled: bool, r: i32) -> Drawn {
    let corners = match look.shape {
        Shape::Circle => Vec::new(),
        Shape::Square => vec![(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)],
        Shape::Up => vec![(x, y - r - 1), (x + r + 1, y + r), (x - r - 1, y + r)],
        Shape::Down => vec![(x, y + r + 1), (x + r + 1, y - r), (x - r - 1, y - r)],
        Shape::Diamond => vec![(x, y - r - 2), (x + r + 1, y), (x, y + r + 2), (x - r - 1, y)],
    };
    // The rim of a filled point lies outside its shape.
    let (paint, outset) = if filled {
        (filled_and_rimmed("o p", look.ink, Ink::Paper), 1)
    } else {
        (filled_and_rimmed("p", Ink::Paper, look.ink), 0)
    };
    let shape = if corners.is_empty() {
        format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\"", r + outset)
    } else {
        let corners: Vec<String> = corners.iter().map(|(x, y)| format!("{x},{y}")).collect();
        format!("<polygon points=\"{}\"", corners.join(" "))
    };
    area.draw(&Raw(format!("{shape} {paint}/>\n")))
}

/// Draws title, grid, ticks and names of axes, and returns the place of values. What stands upright
/// writes its own ticks.
pub(super) fn frame<'a, Y: Ranged>(
    root: &Area<'a>,
    heading: &str,
    (x, y): (&Axis, Y),
    (left, right, top, bottom): (i32, i32, i32, i32),
    panel: Place,
) -> Result<Grid<'a, Y>, Problem> {
    title(root, heading, panel)?;
    let place = Cartesian2d::new(x.clone(), y, (left..right, bottom..top));
    let grid = root.clone().apply_coord_spec(place);
    for tick in x.ticks(usize::try_from((right - left) / 62).unwrap_or(0)) {
        let at = x.map(&tick, (left, right));
        line(root, (at, top), (at, bottom), Ink::Grid, 1)?;
        text(root, &x.label(tick), (at, bottom + 12), Ink::Muted, HPos::Center)?;
    }
    let middle = i32::midpoint(left, right);
    text(root, &x.name, (middle, bottom + 30), Ink::Text, HPos::Center)?;
    line(root, (left, bottom), (right, bottom), Ink::Muted, 1)?;
    Ok(grid)
}
