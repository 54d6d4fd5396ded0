//! What plotters draws on: SVG whose colours follow the reader's light or dark screen.
//!
//! An [`Ink`] goes through plotters as a colour whose blue is the ink's number. Its element gets the
//! light colour as an attribute, and a class that asks the style sheet: a program that knows no CSS
//! shows the light theme.

use std::convert::Infallible;
use std::fmt::Write as _;

use plotters::style::RGBColor;
use plotters_backend::text_anchor::HPos;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::pen::TEXT;
use crate::figure::{Ink, SERIES};
use crate::inline::escape;

/// Name, light and dark colour of each ink, by its number. The series are Okabe and Ito's palette, whose
/// colours stay apart for colour-blind readers (M. Okabe and K. Ito, "Color Universal Design", 2008). Its
/// yellow vanishes on white and its dark blue on black, so each takes the other's place, and grey stands
/// for its black.
const INKS: [(&str, u32, u32); 4 + SERIES] = [
    ("paper", 0x00FF_FFFF, 0x0015_181C),
    ("ink", 0x001B_1F24, 0x00EC_EFF2),
    ("muted", 0x005A_626B, 0x00A9_B2BC),
    ("grid", 0x00E1_E5EA, 0x0031_373E),
    ("series-0", 0x0000_72B2, 0x0056_B4E9),
    ("series-1", 0x00D5_5E00, 0x00E8_690B),
    ("series-2", 0x0000_9E73, 0x0000_B383),
    ("series-3", 0x00CC_79A7, 0x00D9_8AB6),
    ("series-4", 0x00E6_9F00, 0x00E6_9F00),
    ("series-5", 0x0056_B4E9, 0x00F0_E442),
    ("series-6", 0x006B_6B6B, 0x00B4_B4B4),
];

/// The style sheet of the inks, for pages and for standalone figures alike. Paper is light.
pub(crate) fn css() -> String {
    let (mut light, mut dark, mut classes) = (String::new(), String::new(), String::new());
    for (name, on_light, on_dark) in INKS {
        // Writing to a string cannot fail.
        let _ = write!(light, "--{name}:#{on_light:06X};");
        let _ = write!(dark, "--{name}:#{on_dark:06X};");
        let _ = write!(classes, ".f-{name}{{fill:var(--{name})}}.s-{name}{{stroke:var(--{name})}}");
    }
    format!(
        ":root{{color-scheme:light dark;{light}}}\n\
         .p{{stroke-width:2}}.o{{paint-order:stroke}}polyline{{fill:none}}\n\
         @media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n{classes}\n"
    )
}

/// The colour that an ink goes through plotters as.
pub(super) fn colour(ink: Ink) -> RGBColor {
    let number = match ink {
        Ink::Paper => 0,
        Ink::Text => 1,
        Ink::Muted => 2,
        Ink::Grid => 3,
        Ink::Series(i) => 4 + i,
    };
    RGBColor(0, 0, number)
}

/// Attributes of a shape of a class that one ink fills and another surrounds.
pub(super) fn filled_and_rimmed(class: &str, fill: Ink, rim: Ink) -> String {
    let of = |ink| INKS[usize::from(colour(ink).2).min(INKS.len() - 1)];
    let ((fill, filled, _), (rim, rimmed, _)) = (of(fill), of(rim));
    format!("fill=\"#{filled:06X}\" stroke=\"#{rimmed:06X}\" class=\"{class} f-{fill} s-{rim}\"")
}

/// The attributes of a colour: `fill` or `stroke`, and its class.
fn paint(attribute: &str, colour: BackendColor) -> String {
    let (name, light, _) = INKS[usize::from(colour.rgb.2).min(INKS.len() - 1)];
    format!("{attribute}=\"#{light:06X}\" class=\"{}-{name}\"", &attribute[..1])
}

/// Drawn elements without what the style sheet says as well.
pub(super) fn without_colours(body: &str) -> String {
    let body = body.replace(" fill=\"none\"", "");
    let mut out = String::with_capacity(body.len());
    let mut parts = body.split("=\"#");
    out.push_str(parts.next().unwrap_or_default());
    for part in parts {
        let (_, rest) = part.split_once("\" ").unwrap_or_default();
        out.truncate(out.trim_end_matches(|c: char| c.is_ascii_lowercase()).len());
        out.push_str(rest);
    }
    out
}

fn stroke(style: &impl BackendStyle) -> String {
    let width = match style.stroke_width() {
        1 => String::new(),
        width => format!(" stroke-width=\"{width}\""),
    };
    format!("{}{width}", paint("stroke", style.color()))
}

fn fill_or_stroke(style: &impl BackendStyle, fill: bool) -> String {
    if fill { paint("fill", style.color()) } else { format!("fill=\"none\" {}", stroke(style)) }
}

fn corners(points: impl IntoIterator<Item = BackendCoord>) -> String {
    let points = points.into_iter().map(|(x, y)| format!("{x},{y}"));
    points.collect::<Vec<_>>().join(" ")
}

/// SVG elements in the order in which they are drawn.
pub(super) struct Backend<'a> {
    pub(super) out: &'a mut String,
    pub(super) size: (u32, u32),
}

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl Backend<'_> {
    #[expect(clippy::unnecessary_wraps, reason = "plotters asks for a result")]
    fn push(&mut self, element: std::fmt::Arguments) -> Done {
        let _ = writeln!(self.out, "{element}");
        Ok(())
    }
}

impl DrawingBackend for Backend<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        (x1, y1): BackendCoord,
        (x2, y2): BackendCoord,
        style: &S,
    ) -> Done {
        let paint = stroke(style);
        self.push(format_args!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {paint}/>"))
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        let (width, height, paint) = (right - x, bottom - y, fill_or_stroke(style, fill));
        self.push(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {paint}/>"
        ))
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done {
        let points = corners(path);
        let paint = fill_or_stroke(style, false);
        self.push(format_args!("<polyline points=\"{points}\" {paint}/>"))
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done {
        let paint = fill_or_stroke(style, fill);
        self.push(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {paint}/>"))
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners_of: I,
        style: &S,
    ) -> Done {
        let points = corners(corners_of);
        let paint = fill_or_stroke(style, true);
        self.push(format_args!("<polygon points=\"{points}\" {paint}/>"))
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Done {
        let anchor = match style.anchor().h_pos {
            HPos::Left => "",
            HPos::Center => " text-anchor=\"middle\"",
            HPos::Right => " text-anchor=\"end\"",
        };
        // The whole drawing has the size of most texts.
        let size = match style.size() {
            size if (size - f64::from(TEXT)).abs() < 0.5 => String::new(),
            size => format!(" font-size=\"{size}\""),
        };
        let paint = paint("fill", style.color());
        // All texts are centred upright.
        self.push(format_args!(
            "<text x=\"{x}\" y=\"{y}\" dy=\"0.5ex\"{anchor}{size} {paint}>{}</text>",
            escape(text)
        ))
    }
}
