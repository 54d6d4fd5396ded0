//! Figures as SVG. Each is drawn twice, wide and narrow, because text that is scaled down with a wide
//! drawing is too small to read on a phone.

mod backend;
mod pen;
mod plane;
mod rows;

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use crate::figure::{Drawing, Entry, Ink, Panel, Sample};
use crate::inline::{cut, escape, plain};
use backend::{Backend, colour};
use pen::{
    AXIS, Area, Drawn, HEADING, LEGEND, Place, ROW, TEXT, TITLE, dashes, line, lit_with, mark, px,
    text, text_width,
};

pub(crate) use backend::css;
use backend::without_colours;

/// The fonts of figures: whatever the reader's system writes its menus in.
const FONTS: &str = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif";

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

/// Why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw {figure}: {message}")]
pub struct DrawError {
    figure: String,
    message: String,
}

/// A figure that is drawn.
pub(crate) struct Svg {
    /// The root element's attributes but its size.
    root: String,
    size: (i32, i32),
    /// Title and description, for those who cannot see it.
    named: String,
    body: String,
}

impl Svg {
    /// A file of its own.
    pub(crate) fn file(&self) -> String {
        let Self { root, size: (width, height), named, body } = self;
        let css = css();
        format!(
            "<svg width=\"{width}\" height=\"{height}\" {root}>\n{named}<style>\n{css}</style>\n{body}</svg>\n"
        )
    }

    /// A part of a page that has the style sheet and decides its size.
    pub(crate) fn inline(&self) -> String {
        let Self { root, named, body, .. } = self;
        format!("<svg {root}>\n{named}{}</svg>\n", without_colours(body))
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

/// Draws a figure. `name`, `title` and `description` are for readers that cannot see it.
pub(crate) fn draw(
    drawing: &Drawing,
    layout: Layout,
    name: &str,
    title: &str,
    description: &str,
) -> Result<Svg, DrawError> {
    let width = layout.width();
    let has_map = drawing.panels.iter().any(|panel| matches!(panel, Panel::Map(_)));
    let columns = match (layout, drawing.panels.len()) {
        // Three that are to be compared stand in one line.
        (Layout::Wide, 3) if !has_map => 3,
        (Layout::Wide, panels) if !has_map => panels.clamp(1, 2),
        _ => 1,
    };
    let line_height = |line: &[Panel]| line.iter().map(Panel::height).max().unwrap_or(0);
    let legend = legend_places(&drawing.legend, width);
    let legend_height = legend.last().map_or(0, |(_, y)| y + LEGEND + 6);
    let key_columns = if layout == Layout::Wide && drawing.key.len() > 2 { 2 } else { 1 };
    let key_rows = px(drawing.key.len().div_ceil(key_columns));
    let key_columns = px(key_columns);
    let key_height = if key_rows > 0 { key_rows * ROW + 8 } else { 0 };
    let lines = || drawing.panels.chunks(columns);
    let height = legend_height + lines().map(line_height).sum::<i32>() + key_height + 4;

    let mut body = String::new();
    let draw_on = |root: Area| -> Drawn {
        root.draw(&Rectangle::new([(0, 0), (width, height)], colour(Ink::Paper).filled()))?;
        for (entry, &(x, y)) in drawing.legend.iter().zip(&legend) {
            let middle = y + LEGEND / 2;
            lit_with(&root, (&entry.method, ""), || {
                match entry.sample {
                    Sample::Point(look, filled) => mark(&root, (x + 7, middle), look, filled, 5)?,
                    Sample::Dashes => dashes(&root, (x, middle), x + 14, [5, 9], Ink::Text)?,
                    Sample::Line(ink) => line(&root, (x, middle), (x + 14, middle), ink, 2)?,
                }
                text(&root, &entry.text, (x + 18, middle), Ink::Text, HPos::Left)
            })?;
        }
        let mut top = legend_height;
        for line in lines() {
            for (i, panel) in line.iter().enumerate() {
                let left = px(i) * width / px(columns);
                let at = Place { left, right: left + width / px(columns), top };
                match panel {
                    Panel::Rows(rows) => rows::draw_rows(&root, rows, at)?,
                    Panel::Plane(plane) => plane::draw_plane(&root, plane, at)?,
                    Panel::Map(map) => rows::draw_map(&root, map, at)?,
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
    };
    let size = (width.unsigned_abs(), height.unsigned_abs());
    draw_on(Backend { out: &mut body, size }.into_drawing_area())
        .map_err(|e| DrawError { figure: name.into(), message: e.to_string() })?;
    let root = format!(
        "viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" \
         aria-labelledby=\"{name}-title {name}-desc\" font-family=\"{FONTS}\" font-size=\"{TEXT}\""
    );
    let named = format!(
        "<title id=\"{name}-title\">{}</title>\n<desc id=\"{name}-desc\">{}</desc>\n",
        escape(&plain(title)),
        escape(&plain(description))
    );
    Ok(Svg { root, size: (width, height), named, body })
}

/// Where legend entries stand: in lines, broken where the next does not fit.
fn legend_places(entries: &[Entry], width: i32) -> Vec<(i32, i32)> {
    let (mut x, mut y) = (4, 0);
    let place = |entry: &Entry| {
        let w = 18 + text_width(&entry.text, TEXT) + 14;
        if x > 4 && x + w - 14 > width {
            (x, y) = (4, y + LEGEND);
        }
        let at = (x, y);
        x += w;
        at
    };
    entries.iter().map(place).collect()
}
