//! Rows by category, and maps.

use plotters::coord::types::RangedCoordi32;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::backend::colour;
use super::pen::{
    AXIS, Area, Drawn, HEADING, Place, ROW, TEXT, TITLE, frame, line, lit_with, mark, px, text,
    text_width, title,
};
use crate::figure::{Ink, Look, Map, Mark, Row, Rows, Square};
use crate::inline::cut;

impl Rows {
    pub(super) fn height(&self) -> i32 {
        let rows: usize = self.groups.iter().map(|g| g.rows.len()).sum();
        let headings = self.groups.iter().filter(|g| !g.heading.is_empty()).count();
        TITLE + px(headings) * HEADING + px(rows) * ROW + 6 + AXIS
    }
}

pub(super) fn draw_rows(root: &Area, rows: &Rows, panel: Place) -> Drawn {
    let labels = rows.groups.iter().flat_map(|g| &g.rows).map(|r| text_width(&r.label, TEXT));
    let left = panel.left + 14 + labels.max().unwrap_or(0).min((panel.right - panel.left) / 2);
    let right = panel.right - 20;
    let top = panel.top + TITLE - 4;
    let bottom = panel.top + rows.height() - AXIS;
    let upright = RangedCoordi32::from(bottom..top);
    let inner = (left, right, top, bottom);
    let grid = frame(root, &rows.title, (&rows.axis, upright), inner, panel)?;
    let at = |value: f64| grid.map_coordinate(&(value, bottom)).0;
    let mut y = top + 4;
    for group in &rows.groups {
        if !group.heading.is_empty() {
            // The heading stands on the grid; paper beneath keeps it legible.
            let end = panel.left + 8 + text_width(&group.heading, TEXT);
            let back = [(panel.left + 2, y + 4), (end.min(panel.right), y + HEADING - 2)];
            root.draw(&Rectangle::new(back, colour(Ink::Paper).filled()))?;
            let at = (panel.left + 4, y + HEADING / 2 + 2);
            text(root, &group.heading, at, Ink::Text, HPos::Left)?;
            y += HEADING;
        }
        for row in &group.rows {
            lit_with(root, (&row.method, ""), || draw_row(root, row, (left, y), at))?;
            y += ROW;
        }
    }
    if let Some(rule) = rows.rule {
        line(root, (at(rule), top), (at(rule), bottom), Ink::Muted, 1)?;
    }
    Ok(())
}

/// Draws a row at `y`, its marks right of `left`.
fn draw_row(root: &Area, row: &Row, (left, y): (i32, i32), at: impl Fn(f64) -> i32) -> Drawn {
    let middle = y + ROW / 2;
    text(root, &row.label, (left - 6, middle), Ink::Muted, HPos::Right)?;
    let mut end = left;
    for &(ink, ref m) in &row.marks {
        match *m {
            Mark::Bar(value) => {
                let corners = [(left, y + 2), (at(value), y + ROW - 2)];
                root.draw(&Rectangle::new(corners, colour(ink).filled()))?;
                end = end.max(at(value));
            }
            Mark::Span(a, b) => {
                line(root, (at(a), middle), (at(b), middle), ink, 2)?;
                end = end.max(at(a).max(at(b)));
            }
            Mark::Point { at: value, shape, filled } => {
                mark(root, (at(value), middle), Look { ink, shape }, filled, 4)?;
                end = end.max(at(value) + 5);
            }
        }
    }
    if row.note.is_empty() {
        return Ok(());
    }
    text(root, &row.note, (end + 5, middle), Ink::Text, HPos::Left)
}

pub(super) fn draw_map(root: &Area, map: &Map, panel: Place) -> Drawn {
    let labels = map.rows.iter().map(|(label, _)| text_width(label, TEXT)).max().unwrap_or(0);
    let left = panel.left + 10 + labels.min((panel.right - panel.left) / 2);
    let cell = (panel.right - 4 - left) / px(map.columns.len()).max(1);
    let at = |column: usize| left + px(column) * cell + cell / 2;
    title(root, &map.title, panel)?;
    let mut y = panel.top + TITLE;
    let widest = map.columns.iter().map(|head| text_width(head, TEXT)).max().unwrap_or(0);
    // As many heads as have room.
    let step = usize::try_from((widest + 4) / cell.max(1) + 1).unwrap_or(1);
    for (column, head) in map.columns.iter().enumerate().step_by(step) {
        text(root, head, (at(column), y + HEADING / 2), Ink::Muted, HPos::Center)?;
    }
    y += HEADING;
    for (label, cells) in &map.rows {
        lit_with(root, (label, ""), || draw_cells(root, (label, cells), (left, y), cell, panel))?;
        y += ROW;
    }
    Ok(())
}

/// Draws a row of a map at `y`, its cells of that width right of `left`.
fn draw_cells(
    root: &Area,
    (label, cells): (&str, &[Square]),
    (left, y): (i32, i32),
    cell: i32,
    panel: Place,
) -> Drawn {
    let middle = y + ROW / 2;
    // The label of a narrow map is cut where it would run into the cells.
    let room = usize::try_from((left - panel.left) * 100 / (TEXT * 56)).unwrap_or(0);
    text(root, &cut(label, room), (left - 6, middle), Ink::Muted, HPos::Right)?;
    line(root, (left, y + ROW), (left + px(cells.len()) * cell, y + ROW), Ink::Grid, 1)?;
    for (column, Square { weight, text: says }) in cells.iter().enumerate() {
        let centre = left + px(column) * cell + cell / 2;
        let has_room = text_width(says, TEXT) + 13 <= cell;
        // The area of the square is the weight.
        #[expect(clippy::cast_possible_truncation, reason = "a few pixels")]
        let half = (weight.clamp(0.0, 1.0).sqrt() * f64::from(ROW - 5) / 2.0).round() as i32;
        // Beside its text where that has room, else in the same place without.
        let middle_x = if cell > 24 { centre - cell / 2 + 7 } else { centre };
        if half > 0 {
            let corners = [(middle_x - half, middle - half), (middle_x + half, middle + half)];
            root.draw(&Rectangle::new(corners, colour(Ink::series(1)).filled()))?;
        }
        if has_room {
            text(root, says, (centre - cell / 2 + 14, middle), Ink::Text, HPos::Left)?;
        }
    }
    Ok(())
}
