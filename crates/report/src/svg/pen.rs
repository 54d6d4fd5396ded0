//! What panels are drawn with: texts, lines, marks and frames.

use std::convert::Infallible;

use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::backend::{Backend, colour};
use crate::figure::{Axis, Ink, Look, Shape};

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

pub(super) fn mark(area: &Area, (x, y): (i32, i32), look: Look, filled: bool, r: i32) -> Drawn {
    let (ink, paper) = (colour(look.ink), colour(Ink::Paper));
    let corners: Vec<(i32, i32)> = match look.shape {
        Shape::Circle => {
            let r = r.unsigned_abs() + 1;
            // A rim of paper keeps points apart that lie on each other.
            area.draw(&Circle::new((x, y), r + 1, paper.filled()))?;
            let (r, style) = if filled { (r, ink.filled()) } else { (r - 1, ink.stroke_width(2)) };
            return area.draw(&Circle::new((x, y), r, style));
        }
        Shape::Square => vec![(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)],
        Shape::Up => vec![(x, y - r - 1), (x + r + 1, y + r), (x - r - 1, y + r)],
        Shape::Down => vec![(x, y + r + 1), (x + r + 1, y - r), (x - r - 1, y - r)],
        Shape::Diamond => {
            vec![(x, y - r - 2), (x + r + 1, y), (x, y + r + 2), (x - r - 1, y)]
        }
    };
    let closed: Vec<_> = corners.iter().chain(&corners[..2]).copied().collect();
    let (fill, rim) = if filled { (ink, paper) } else { (paper, ink) };
    let rim = PathElement::new(closed, rim.stroke_width(2));
    let fill = Polygon::new(corners, fill);
    if filled {
        area.draw(&rim)?;
        area.draw(&fill)
    } else {
        area.draw(&fill)?;
        area.draw(&rim)
    }
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
