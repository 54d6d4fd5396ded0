//! Colours, and what turns the plain output of the SVG backend into a figure that follows the
//! reader's light or dark screen, can be read aloud, and needs no font of its own.
//!
//! The backend writes colours as attributes. Each colour of the light theme names one [`Ink`],
//! so every attribute gets that ink's class beside it: a program that knows no CSS shows the
//! light theme, all others ask the style sheet.

use std::fmt::Write as _;

use plotters::style::RGBColor;

/// What a colour is for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    Paper,
    Text,
    Muted,
    Grid,
    /// One of the series colours.
    Series(u8),
}

/// Series colours: Okabe and Ito's palette, whose colours stay apart for colour-blind readers
/// (M. Okabe and K. Ito, "Color Universal Design", 2008). Its yellow vanishes on white and its
/// dark blue on black, so each takes the other's place, and grey stands
/// for its black. Two are a shade off, because a colour must name one ink.
const SERIES: [(u32, u32); 7] = [
    (0x0000_72B2, 0x0056_B4E9),
    (0x00D5_5E00, 0x00E8_690B),
    (0x0000_9E73, 0x0000_B383),
    (0x00CC_79A7, 0x00D9_8AB6),
    (0x00E6_9F00, 0x00E6_9F01),
    (0x0056_B4E8, 0x00F0_E442),
    (0x006B_6B6B, 0x00B4_B4B4),
];

impl Ink {
    /// The ink of the `i`th series.
    pub(crate) fn series(i: usize) -> Self {
        Self::Series(u8::try_from(i % SERIES.len()).unwrap_or(0))
    }

    fn all() -> impl Iterator<Item = Self> {
        [Self::Paper, Self::Text, Self::Muted, Self::Grid]
            .into_iter()
            .chain((0..SERIES.len()).map(Self::series))
    }

    /// In the light and the dark theme.
    fn hex(self) -> (u32, u32) {
        match self {
            Self::Paper => (0x00FF_FFFF, 0x0015_181C),
            Self::Text => (0x001B_1F24, 0x00EC_EFF2),
            Self::Muted => (0x005A_626B, 0x00A9_B2BC),
            Self::Grid => (0x00E1_E5EA, 0x0031_373E),
            Self::Series(i) => SERIES[usize::from(i)],
        }
    }

    pub(crate) fn rgb(self) -> RGBColor {
        let [_, r, g, b] = self.hex().0.to_be_bytes();
        RGBColor(r, g, b)
    }

    /// Name of the CSS variable.
    fn name(self) -> String {
        match self {
            Self::Paper => "paper".into(),
            Self::Text => "ink".into(),
            Self::Muted => "muted".into(),
            Self::Grid => "grid".into(),
            Self::Series(i) => format!("series-{i}"),
        }
    }
}

fn variables(dark: bool) -> String {
    Ink::all().fold(String::new(), |mut css, ink| {
        let (light_hex, dark_hex) = ink.hex();
        let _ = write!(css, "--{}:#{:06X};", ink.name(), if dark { dark_hex } else { light_hex });
        css
    })
}

/// The style sheet of the inks, for pages and for standalone figures alike. Paper is light.
pub(crate) fn css() -> String {
    let mut css = format!(
        ":root{{color-scheme:light dark;{}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{}}}}}\n",
        variables(false),
        variables(true)
    );
    for ink in Ink::all() {
        let name = ink.name();
        let _ = write!(css, ".f-{name}{{fill:var(--{name})}}.s-{name}{{stroke:var(--{name})}}");
    }
    css.push('\n');
    css
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The fonts of figures: whatever the reader's system writes its menus in.
const FONTS: &str = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif";

/// Turns the backend's output into a standalone figure.
pub(crate) fn finish_svg(svg: &str, name: &str, title: &str, description: &str) -> String {
    let mut body = svg.split_once('>').map_or("", |(_, body)| body).to_string();
    for ink in Ink::all() {
        let hex = format!("{:06X}", ink.hex().0);
        let class = ink.name();
        body = body
            .replace(&format!("fill=\"#{hex}\""), &format!("fill=\"#{hex}\" class=\"f-{class}\""))
            .replace(
                &format!("stroke=\"#{hex}\""),
                &format!("stroke=\"#{hex}\" class=\"s-{class}\""),
            );
    }
    // Said once on the root instead of on each of hundreds of texts and lines.
    for repeated in [" opacity=\"1\"", " font-family=\"sans-serif\"", " stroke=\"none\""] {
        body = body.replace(repeated, "");
    }
    let size = svg
        .split_once("width=\"")
        .and_then(|(_, rest)| rest.split_once(" xmlns"))
        .map_or("", |(size, _)| size);
    format!(
        "<svg width=\"{size} xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" \
         aria-labelledby=\"{name}-title {name}-desc\" font-family=\"{FONTS}\">\n\
         <title id=\"{name}-title\">{}</title>\n<desc id=\"{name}-desc\">{}</desc>\n\
         <style>\n{}</style>{body}",
        escape(title),
        escape(description),
        css()
    )
}

/// The same figure to stand in a page that has the style sheet: without its own, and without a
/// size, so that the page decides.
pub(crate) fn inline_svg(svg: &str) -> String {
    let (head, rest) = svg.split_once("<style>").unwrap_or((svg, ""));
    let body = rest.split_once("</style>").map_or(rest, |(_, body)| body);
    let head = match (head.find("width="), head.find("viewBox")) {
        (Some(from), Some(to)) => format!("{}{}", &head[..from], &head[to..]),
        _ => head.to_string(),
    };
    format!("{head}{body}")
}
