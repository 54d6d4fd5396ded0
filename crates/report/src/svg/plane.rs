//! Points and lines in two dimensions.

use plotters::coord::ranged1d::Ranged as _;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::backend::colour;
use super::pen::{
    Area, Drawn, Grid, Place, TEXT, TITLE, dashes, frame, line, lit_with, mark, text, text_width,
};
use crate::figure::{Axis, Ink, Join, Plane, Series};

impl Plane {
    pub(super) fn title_height(&self) -> i32 {
        if self.title.is_empty() { 6 } else { TITLE }
    }
}

/// Left, right, top and bottom.
type Bounds = (i32, i32, i32, i32);

pub(super) fn draw_plane(root: &Area, plane: &Plane, panel: Place) -> Drawn {
    let top = panel.top + plane.title_height() + 16;
    let bottom = panel.top + plane.title_height() + plane.height;
    let ticks = plane.y.ticks(usize::try_from((bottom - top) / 34).unwrap_or(0));
    let labels: Vec<String> = ticks.iter().map(|&tick| plane.y.label(tick)).collect();
    let widest = labels.iter().map(|label| text_width(label, TEXT)).max().unwrap_or(0);
    let (left, right) = (panel.left + 14 + widest, panel.right - 24);
    let inner = (left, right, top, bottom);
    let grid = frame(root, &plane.title, (&plane.x, plane.y.clone()), inner, panel)?;
    for (tick, label) in ticks.iter().zip(&labels) {
        let at = plane.y.map(tick, (bottom, top));
        line(root, (left, at), (right, at), Ink::Grid, 1)?;
        text(root, label, (left - 6, at), Ink::Muted, HPos::Right)?;
    }
    line(root, (left, top), (left, bottom), Ink::Muted, 1)?;
    draw_gap(root, &plane.y, inner)?;
    // The name of the vertical axis stands above it, upright: nobody turns a screen.
    text(root, &plane.y.name, (panel.left + 4, top - 12), Ink::Muted, HPos::Left)?;

    for rule in &plane.rules {
        let y = plane.y.map(rule, (bottom, top));
        dashes(root, (left, y), right, [5, 9], Ink::Text)?;
    }
    for series in &plane.series {
        if !series.points.is_empty() {
            let subject = (&*series.method, &*series.says);
            lit_with(root, subject, || draw_series(root, &grid, series, (right, top)))?;
        }
    }
    draw_labels(root, &grid, plane, inner)
}

/// The break in an axis.
fn draw_gap(root: &Area, y: &Axis, (left, right, top, bottom): Bounds) -> Drawn {
    let Some((from, to)) = y.gap else { return Ok(()) };
    let (low, high) = (y.map(&from, (bottom, top)) - 4, y.map(&to, (bottom, top)) + 4);
    let back = [(left - 3, high), (right, low)];
    root.draw(&Rectangle::new(back, colour(Ink::Paper).filled()))?;
    for edge in [high, low] {
        line(root, (left - 6, edge + 3), (left + 6, edge - 3), Ink::Muted, 1)?;
        dashes(root, (left + 8, edge), right, [2, 6], Ink::Grid)?;
    }
    Ok(())
}

fn draw_series(root: &Area, grid: &Grid<Axis>, s: &Series, (right, top): (i32, i32)) -> Drawn {
    let places: Vec<(i32, i32)> = s.points.iter().map(|at| grid.map_coordinate(at)).collect();
    let joined = match s.join {
        Join::No => Vec::new(),
        Join::Straight => places.clone(),
        Join::Step => {
            let mut corners: Vec<_> = places.first().map(|&(x, _)| (x, top)).into_iter().collect();
            for (i, &(x, y)) in places.iter().enumerate() {
                corners.push((x, y));
                corners.push((places.get(i + 1).map_or(right, |next| next.0), y));
            }
            corners
        }
    };
    if joined.len() > 1 {
        root.draw(&PathElement::new(joined, colour(s.look.ink).stroke_width(2)))?;
    }
    if s.marked {
        for &place in &places {
            mark(root, place, s.look, s.filled, 4)?;
        }
    }
    Ok(())
}

/// Labels keep away from those before them, from all points and from the frame.
fn draw_labels(
    root: &Area,
    grid: &Grid<Axis>,
    plane: &Plane,
    (left, right, top, bottom): Bounds,
) -> Drawn {
    let marked = plane.series.iter().filter(|s| s.marked).flat_map(|s| &s.points);
    let points: Vec<(i32, i32)> = marked.map(|at| grid.map_coordinate(at)).collect();
    let mut taken: Vec<Bounds> = Vec::new();
    for (x, y, what) in &plane.labels {
        let (x, y) = grid.map_coordinate(&(*x, *y));
        let w = text_width(what, TEXT) + 2;
        let free = |&(dx, dy): &(i32, i32)| {
            let (l, t) = (x + dx - w / 2, y + dy - 8);
            let (r, b) = (l + w, t + 16);
            let over = |&(l2, r2, t2, b2): &Bounds| l < r2 && l2 < r && t < b2 && t2 < b;
            let is_near =
                |&&(px, py): &&(i32, i32)| l - 4 < px && px < r + 4 && t - 3 < py && py < b + 3;
            let outside = l < left || r > right || t < top || b > bottom;
            if outside || taken.iter().any(over) {
                usize::MAX
            } else {
                points.iter().filter(is_near).count()
            }
        };
        let around = [14, 20, 28, 38].into_iter().flat_map(|d| {
            let s = d + w / 2 - 4;
            [(-s, d - 6), (-s, 0), (0, d), (-s, -d + 6), (s, -d + 6), (s, 0), (0, -d), (s, d)]
        });
        let best = around.min_by_key(free).unwrap_or((0, -14));
        let centre = (x + best.0, y + best.1);
        taken.push((centre.0 - w / 2, centre.0 + w / 2, centre.1 - 8, centre.1 + 8));
        let is_method = plane.series.iter().any(|series| series.method == *what);
        lit_with(root, (if is_method { what } else { "" }, ""), || {
            if best.0.abs() > 24 + w / 2 || best.1.abs() > 24 {
                // To the edge of the text, and not across it.
                let end_x = x.clamp(centre.0 - w / 2, centre.0 + w / 2);
                let end = (end_x, centre.1 + 7 * (y - centre.1).signum());
                line(root, (x, y), end, Ink::Muted, 1)?;
            }
            text(root, what, centre, Ink::Text, HPos::Center)
        })?;
    }
    Ok(())
}
