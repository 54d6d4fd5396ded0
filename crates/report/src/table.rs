//! Tables, defined once: a terminal, a document and a page draw the same columns.

use serde::ser::SerializeStruct as _;
use serde::{Serialize, Serializer};

use crate::format::{grouped, ratio};

/// How a number is written.
pub type Write = fn(f64) -> String;

/// What a cell holds.
#[derive(Clone, Debug)]
pub enum Cell {
    /// Nothing was found.
    Missing,
    /// A text, or a mark.
    Text(String),
    /// A number, and how it is written.
    Number(f64, Write),
    /// A ratio with its quartiles.
    Ratio(f64, [f64; 2]),
    /// The ends of a range, sorted by how wide it is.
    Range([f64; 2], Write),
}

impl Cell {
    /// As it is shown.
    pub fn text(&self) -> String {
        match self {
            Self::Missing => "–".to_owned(),
            Self::Text(text) => text.clone(),
            Self::Number(value, write) => write(*value),
            Self::Ratio(value, [low, high]) => format!("{} ({low:.2}–{high:.2})", ratio(*value)),
            Self::Range([low, high], write) => format!("{}–{}", write(*low), write(*high)),
        }
    }

    /// What it is sorted by; nothing stays last.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Missing | Self::Text(_) => None,
            Self::Number(value, _) | Self::Ratio(value, _) => Some(*value),
            Self::Range([low, high], _) => Some(high - low),
        }
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut cell = to.serialize_struct("Cell", 2)?;
        cell.serialize_field("text", &self.text())?;
        cell.serialize_field("value", &self.value())?;
        cell.end()
    }
}

impl From<Option<Cell>> for Cell {
    fn from(cell: Option<Cell>) -> Self {
        cell.unwrap_or(Self::Missing)
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Names in a catalogue, which documents set as code.
    Name,
    /// Texts.
    Text,
    /// Sentences, which a page may break.
    Prose,
    /// Numbers.
    Number,
}

/// The head of a column.
#[derive(Clone, Debug, Serialize)]
pub struct Column {
    /// Its name.
    pub head: String,
    /// What it holds.
    pub kind: Kind,
    /// What it means, for those that the section's prose does not explain.
    pub note: &'static str,
}

/// A table.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, a cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// Words that rows may be filtered by, as an example, where a page lets its reader sort and filter
    /// them.
    pub filter: Option<&'static str>,
}

/// A count, its digits grouped.
pub fn count(x: f64) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it was a count")]
    grouped(x as u64)
}

impl Table {
    /// A table with a row for each of these, which columns are added to.
    pub fn of<R>(rows: &[R]) -> Columns<'_, R> {
        let table = Self { rows: rows.iter().map(|_| Vec::new()).collect(), ..Self::default() };
        Columns { of: rows, table }
    }

    /// Some of the columns, under other heads. Of columns with one head the first is taken, and then the
    /// next.
    pub fn pick(&self, heads: &[(&str, &str)]) -> Self {
        let mut taken = Vec::new();
        let mut picked = Self { rows: vec![Vec::new(); self.rows.len()], ..Self::default() };
        for (head, shown) in heads {
            let is_next = |&(place, column): &(usize, &Column)| {
                column.head == *head && !taken.contains(&place)
            };
            let Some((place, column)) = self.columns.iter().enumerate().find(is_next) else {
                continue;
            };
            taken.push(place);
            picked.columns.push(Column { head: (*shown).to_owned(), ..column.clone() });
            for (row, of) in picked.rows.iter_mut().zip(&self.rows) {
                row.push(of[place].clone());
            }
        }
        picked
    }
}

/// A table that columns are added to.
pub struct Columns<'a, R> {
    of: &'a [R],
    table: Table,
}

impl<'a, R> Columns<'a, R> {
    /// A column of any cells.
    pub fn cells<C: Into<Cell>>(
        mut self,
        head: impl Into<String>,
        kind: Kind,
        cell: impl Fn(&'a R) -> C,
    ) -> Self {
        self.table.columns.push(Column { head: head.into(), kind, note: "" });
        for (row, of) in self.table.rows.iter_mut().zip(self.of) {
            row.push(cell(of).into());
        }
        self
    }

    /// A column of names in a catalogue.
    pub fn name<T: Into<String>>(self, head: &str, text: impl Fn(&'a R) -> T) -> Self {
        self.cells(head, Kind::Name, |row| Cell::Text(text(row).into()))
    }

    /// A column of texts.
    pub fn text<T: Into<String>>(self, head: &str, text: impl Fn(&'a R) -> T) -> Self {
        self.cells(head, Kind::Text, |row| Cell::Text(text(row).into()))
    }

    /// A column of sentences.
    pub fn prose<T: Into<String>>(self, head: &str, text: impl Fn(&'a R) -> T) -> Self {
        self.cells(head, Kind::Prose, |row| Cell::Text(text(row).into()))
    }

    /// A column of numbers, written in one way.
    pub fn number<N: Into<Option<f64>>>(
        self,
        head: impl Into<String>,
        write: Write,
        number: impl Fn(&'a R) -> N,
    ) -> Self {
        self.cells(head, Kind::Number, |row| {
            number(row).into().map(|number| Cell::Number(number, write))
        })
    }

    /// A column of counts.
    pub fn count(self, head: impl Into<String>, number: impl Fn(&'a R) -> u64) -> Self {
        self.number(head, count, |row| number(row) as f64)
    }

    /// What the last column means.
    pub fn note(mut self, note: &'static str) -> Self {
        if let Some(column) = self.table.columns.last_mut() {
            column.note = note;
        }
        self
    }

    /// The table.
    pub fn done(self) -> Table {
        self.table
    }

    /// The table, whose rows the reader of a page may sort and filter by words like these.
    pub fn filtered(self, example: &'static str) -> Table {
        Table { filter: Some(example), ..self.table }
    }
}
