//! Documents on a terminal.
//!
//! Table libraries wrap words inside cells when a terminal is narrow, which makes columns of
//! numbers unreadable; here a table that is too wide goes on below, its first column repeated.

use crate::document::{Content, Document, Section, Shown};
pub use crate::inline::cut;
use crate::inline::plain;
use crate::table::Table;

/// What a document shows on a terminal, as text of at most `width` columns, for 40 columns or more.
pub(crate) fn draw(document: &Document, width: usize) -> String {
    let shown = |section: &&Section| {
        matches!(section.shown, Shown::Terminal | Shown::Everywhere)
            && !(section.is_empty() && section.missing.is_empty())
    };
    let sections =
        document.sections.iter().filter(shown).map(|section| draw_section(section, width));
    let source =
        (!document.source.line.is_empty()).then(|| wrap(&document.source.line, width, "  "));
    source.into_iter().chain(sections).collect::<Vec<_>>().join("\n")
}

fn draw_section(section: &Section, width: usize) -> String {
    if section.is_empty() {
        return wrap(&plain(&section.missing), width, "");
    }
    let says =
        if section.says.is_empty() { None } else { Some(wrap(&plain(&section.says), width, "")) };
    let content = match &section.content {
        Content::Prose | Content::Figure(_) | Content::Pictures(_) => String::new(),
        Content::Table(table) => draw_table(table, width),
        Content::Findings(findings) => {
            let draw = |finding: &crate::document::Finding| {
                let about = hang("", &format!("{}:", finding.about), width, "  ");
                let [says, how] = [&finding.says, &finding.how];
                let answer = [says, how].map(|text| hang("  ", &plain(text), width, "  "));
                about + &answer.concat()
            };
            findings.iter().map(draw).collect::<Vec<_>>().join("\n")
        }
        Content::List(items) => {
            let draw = |(head, text): &(String, String)| hang(head, &plain(text), width, "       ");
            items.iter().map(draw).collect()
        }
    };
    let says = says.unwrap_or_default();
    // What a table means stands below it, what opens a list above.
    if matches!(section.content, Content::Table(_)) { content + &says } else { says + &content }
}

/// Characters that a terminal shows.
fn columns(text: &str) -> usize {
    text.chars().count()
}

/// Breaks a text at spaces.
fn wrap(text: &str, width: usize, indent: &str) -> String {
    hang("", text, width, indent)
}

/// A head that keeps its spaces, then words that break before `width` and go on indented.
fn hang(head: &str, text: &str, width: usize, indent: &str) -> String {
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

fn draw_table(table: &Table, width: usize) -> String {
    let head: Vec<String> = table.columns.iter().map(|column| column.head.clone()).collect();
    let cells = table.rows.iter().map(|row| row.iter().map(|cell| plain(&cell.text())).collect());
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(cells).collect();
    let count = table.columns.len();
    let widest = |column: usize| rows.iter().map(|row| columns(&row[column])).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(widest).collect();
    let rest_widest = widths.iter().skip(1).max().map_or(0, |w| w + 1);
    let name = widths[0].min(width.saturating_sub(rest_widest).max(8));
    let total = |gap: usize| name + widths.iter().skip(1).map(|w| w + gap).sum::<usize>();
    let gap = if total(2) <= width { 2 } else { 1 };

    let mut out = String::new();
    let mut from = 1;
    while from < count || from == 1 {
        let mut to = from;
        let mut used = name;
        while to < count && (to == from || used + gap + widths[to] <= width) {
            used += gap + widths[to];
            to += 1;
        }
        if from > 1 {
            out.push('\n');
        }
        for row in &rows {
            let mut line = format!("{:<name$}", cut(&row[0], name));
            for c in from..to {
                line.push_str(&" ".repeat(gap + widths[c] - columns(&row[c])));
                line.push_str(&row[c]);
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
        if to >= count {
            break;
        }
        from = to;
    }
    out
}
