//! Tables for terminals.
//!
//! Table libraries wrap words inside cells when a terminal is narrow, which makes columns of
//! numbers unreadable; here a table that is too wide goes on below, its first column repeated.

/// A table: the first column is a name, all others are numbers.
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// Characters that a terminal shows.
fn columns(text: &str) -> usize {
    text.chars().count()
}

/// Cuts a text that is too long, and says so.
pub(crate) fn cut(text: &str, width: usize) -> String {
    if columns(text) <= width {
        return text.into();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}

/// Breaks a text at spaces.
pub(crate) fn wrap(text: &str, width: usize, indent: &str) -> String {
    hang("", text, width, indent)
}

/// A head that keeps its spaces, then words that break before `width` and go on indented.
pub(crate) fn hang(head: &str, text: &str, width: usize, indent: &str) -> String {
    let mut out = head.to_string();
    let mut used = columns(head);
    for (i, word) in text.split_whitespace().enumerate() {
        let space = usize::from(i > 0);
        if used > columns(indent) && used + space + columns(word) > width {
            out.truncate(out.trim_end_matches(' ').len());
            out.push('\n');
            out.push_str(indent);
            used = columns(indent);
        } else if space > 0 {
            out.push(' ');
            used += 1;
        }
        out.push_str(word);
        used += columns(word);
    }
    out.push('\n');
    out
}

impl Table {
    pub(crate) fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(ToString::to_string).collect(), rows: Vec::new() }
    }

    pub(crate) fn render(&self, width: usize) -> String {
        let widths: Vec<usize> = (0..self.head.len())
            .map(|c| {
                let cells = self.rows.iter().map(|r| columns(&r[c]));
                cells.chain([columns(&self.head[c])]).max().unwrap_or(0)
            })
            .collect();
        let rest_widest = widths.iter().skip(1).max().map_or(0, |w| w + 1);
        let name = widths[0].min(width.saturating_sub(rest_widest).max(8));
        let total = |gap: usize| name + widths.iter().skip(1).map(|w| w + gap).sum::<usize>();
        let gap = if total(2) <= width { 2 } else { 1 };

        let mut out = String::new();
        let mut from = 1;
        while from < self.head.len() || from == 1 {
            let mut to = from;
            let mut used = name;
            while to < self.head.len() && (to == from || used + gap + widths[to] <= width) {
                used += gap + widths[to];
                to += 1;
            }
            if from > 1 {
                out.push('\n');
            }
            for row in std::iter::once(&self.head).chain(&self.rows) {
                let mut line = format!("{:<name$}", cut(&row[0], name));
                for c in from..to {
                    line.push_str(&" ".repeat(gap + widths[c] - columns(&row[c])));
                    line.push_str(&row[c]);
                }
                out.push_str(line.trim_end());
                out.push('\n');
            }
            if to >= self.head.len() {
                break;
            }
            from = to;
        }
        out
    }
}
