//! A document of no study, drawn by every renderer.

use trisect_report::document::{Content, Document, Finding, Picture, Section, Shown, Source};
use trisect_report::figure::{
    Axis, Drawing, Entry, Group, Ink, Look, Map, Mark, Panel, Plane, Row, Sample, Scale, Series,
    Shape, Square,
};
use trisect_report::format::{number, tick};
use trisect_report::html::{self, Link};
use trisect_report::markdown::{SpliceError, splice};
use trisect_report::table::{Cell, Kind, Table};

fn drawing() -> Drawing {
    let axis = |scale, values: &[f64]| Axis::over("size", scale, values.iter().copied(), tick);
    let marks = [Mark::Bar(3.0), Mark::Span(1.0, 4.0)].into_iter();
    let point = Mark::Point { at: 2.0, shape: Shape::Diamond, filled: false };
    let marks = marks.chain([point]).map(|mark| (Ink::series(2), mark)).collect();
    let method = "<method>".into();
    let row = Row { label: "a < b".into(), method, marks, note: "3".into() };
    let group = Group { heading: "bars & points".into(), rows: vec![row] };
    let shapes = (0..5).map(|i| Series::points(Look::of(i), i % 2 == 0, vec![(1.0, 1e-9)]));
    let others = [
        Series::front(vec![(1.0, 1.0), (2.0, 1e-9)]),
        Series::line(Look::of(0), vec![(1.0, 1.0), (9.0, 0.5)]).of("first").says("1 & more"),
    ];
    let errors = [1.0, 0.5, 1e-9];
    let plane = Plane {
        rules: vec![0.5],
        labels: vec![(1.0, 1.0, "first".into())],
        ..Plane::new(
            "plane",
            axis(Scale::Log, &[1.0, 9.0]),
            axis(Scale::Log, &errors).broken(errors),
            200,
            shapes.chain(others).collect(),
        )
    };
    let squares = vec![Square { weight: 0.5, text: "7".into() }];
    let map = Map {
        title: "map".into(),
        columns: vec!["1".into()],
        rows: vec![("a row with a name that is too long for a phone".into(), squares)],
    };
    Drawing {
        panels: vec![
            Panel::rows("rows", axis(Scale::Linear, &[0.0, 3.0]), Some(1.0), vec![group]),
            Panel::Plane(plane),
            Panel::Map(map),
        ],
        legend: vec![
            Entry::of(Look::plain(Ink::Muted), "points"),
            Entry::new(Sample::Dashes, "a rule"),
            Entry::new(Sample::Line(Ink::Grid), "a line"),
        ],
        key: vec!["1  the first".into()],
    }
}

fn table() -> Table {
    Table::of(&[("one", Some(1234.5)), ("two", None)])
        .name("name", |(name, _)| *name)
        .number("speed", number, |(_, speed)| *speed)
        .note("how fast")
        .cells("ratio", Kind::Number, |(_, speed)| speed.map(|_| Cell::Ratio(2.0, [1.5, 2.5])))
        .prose("what it is", |(name, _)| format!("`{name}` <as text>"))
        .filtered("one")
}

fn document() -> Document {
    let picture = Picture { name: "A".into(), says: "b".into(), size: [1, 2], png: "iVBO".into() };
    Document {
        title: "Title",
        heading: "Heading",
        source: Source {
            line: "program on machine".into(),
            measured: "Measured by `program`.".into(),
            generator: "program".into(),
            steadiness: Some("The machine was quiet.".into()),
            facts: vec![("Command", "`program`".into())],
        },
        sections: vec![
            Section::findings("found", vec![Finding::new("About", "`this`", "thus")])
                .shown(Shown::Everywhere),
            Section::new("", "", Content::List(vec![("head".into(), "**text**".into())]))
                .folded("All of them"),
            Section::figure("a-figure", "A figure", "A caption.", drawing()),
            Section::new("pictures", "Pictures", Content::Pictures(vec![picture])),
            Section::table("a-table", "A table", "speed: in words.", table())
                .part("numbers")
                .shown(Shown::Everywhere),
            Section::table("nothing", "Nothing", "", Table::default())
                .missing("Left out: nothing.")
                .part("nothing"),
            Section::list("list", "First", vec![("says".into(), "**yes**".into())]),
            Section::list("list", "Second", vec![("says".into(), "no".into())]),
        ],
    }
}

#[test]
fn on_a_terminal() {
    insta::assert_snapshot!(document().to_text(80));
    for width in [40, 60] {
        let text = document().to_text(width);
        assert!(text.lines().all(|line| line.chars().count() <= width), "{text}");
    }
}

#[test]
fn columns_are_picked_in_order_under_other_heads() {
    let picked = table().pick(&[("speed", "fast"), ("name", "who"), ("none", "none")]);
    let heads: Vec<&str> = picked.columns.iter().map(|column| column.head.as_str()).collect();
    assert_eq!(heads, ["fast", "who"]);
    let cells = picked.rows.iter().map(|row| row.iter().map(Cell::text).collect::<Vec<_>>());
    assert_eq!(cells.collect::<Vec<_>>(), [["1,235", "one"], ["–", "two"]]);
}

#[test]
fn spliced_into_a_text() {
    let marked = |name| format!("<!-- trisect:{name} -->\nold\n<!-- end of trisect:{name} -->\n");
    let text = ["found", "numbers", "nothing", "list", "other"].map(marked).concat();
    let once = splice(&text, &document()).expect("there are markers");
    assert_eq!(splice(&once, &document()).expect("still"), once);
    assert_eq!(once.matches("\nold\n").count(), 1, "what is of another document stays");
    insta::assert_snapshot!(once);
    assert!(matches!(splice("no marker", &document()), Err(SpliceError::NoMarker(_))));
    let open = splice("<!-- trisect:list -->", &document());
    assert_eq!(open, Err(SpliceError::Open("list")));
}

#[test]
fn on_a_page() {
    let link = Link { page: "other.html", name: "Other", says: "more" };
    let page = html::draw(&document(), &[link]).expect("it is drawn");
    let (head, rest) = page.html.split_once("<style>").expect("a style sheet");
    let (_, body) = rest.split_once("</style>").expect("it ends");
    let mut drawn = format!("{head}{body}");
    while let Some((from, to)) = drawn.find("<svg").zip(drawn.find("</svg>")) {
        drawn.replace_range(from..to + "</svg>".len(), "SVG");
    }
    let (body, _) = drawn.split_once("<script>").expect("a script");
    insta::assert_snapshot!(body);
}

/// Figures are XML, are named for those who cannot see them, load nothing, and every colour follows the
/// reader's screen.
#[test]
fn as_figures() {
    let page = html::draw(&document(), &[]).expect("it is drawn");
    let names: Vec<&str> = page.figures.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["a-figure.svg", "a-figure-narrow.svg"]);
    for (name, svg) in &page.figures {
        let tree = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{name}: {e}"));
        for id in tree.root_element().attribute("aria-labelledby").expect("a label").split(' ') {
            let named = tree.descendants().find(|node| node.attribute("id") == Some(id));
            assert!(named.and_then(|node| node.text()).is_some_and(|text| !text.is_empty()));
        }
        assert_eq!(svg.matches("://").count(), 1, "the namespace alone");
        for node in tree.descendants().filter(|n| n.attribute("fill").is_some_and(|f| f != "none"))
        {
            assert!(node.attribute("class").is_some(), "{name}: {node:?}");
        }
        let texts: Vec<&str> = tree
            .descendants()
            .filter(|node| node.has_tag_name("text"))
            .filter_map(|node| node.text())
            .collect();
        for text in ["a < b", "bars & points", "first", "10⁻⁹", "points", "a rule"] {
            assert!(texts.contains(&text), "{name}: {text}: {texts:?}");
        }
    }
}

/// What is of a method is marked as such in every layout, and says what a page says of it.
/// Before all that it is about.
#[test]
fn a_page_says_first_how_steady_the_machine_was() {
    let page = html::draw(&document(), &[]).expect("it is drawn");
    let head = page.html.split("<h2").next().unwrap_or_default();
    assert!(head.contains("The machine was quiet."), "{head}");
}

#[test]
fn figures_mark_what_is_of_a_method() {
    let page = html::draw(&document(), &[]).expect("it is drawn");
    for (name, svg) in &page.figures {
        let tree = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{name}: {e}"));
        let marked: Vec<_> =
            tree.descendants().filter(|node| node.has_attribute("data-method")).collect();
        let of = |method| {
            marked.iter().filter(move |node| node.attribute("data-method") == Some(method))
        };
        assert_eq!(of("<method>").count(), 1, "{name}: a row");
        assert_eq!(of("first").count(), 2, "{name}: a line and its label");
        let said =
            of("first").flat_map(roxmltree::Node::children).find(|n| n.has_tag_name("title"));
        assert_eq!(said.and_then(|node| node.text()), Some("first: 1 & more"), "{name}");
    }
    assert!(page.html.contains("data-method=\"first\""));
    // The page's style sheet has the colours.
    assert!(!page.html.contains("fill=\"#") && !page.html.contains("stroke=\"#"));
}

/// Numbers that no machine measures have places and ticks like all others.
#[test]
fn extreme_numbers_are_drawn() {
    let extremes = [0.0, 1.0, -1.5, 9_007_199_254_740_992.0, 1e308, 5e-324];
    let pairs = extremes.into_iter().flat_map(|a| extremes.map(|b| [a, b]));
    for (values, scale) in
        pairs.flat_map(|pair| [Scale::Linear, Scale::Log, Scale::Binary].map(|scale| (pair, scale)))
    {
        let axis = || Axis::over("size", scale, values, tick);
        let series = vec![Series::line(Look::of(0), values.map(|x| (x, x)).into())];
        let marks = values.map(|value| (Ink::Text, Mark::Bar(value))).into();
        let method = String::new();
        let row = Row { label: "row".into(), method, marks, note: "a note".into() };
        let group = Group { heading: String::new(), rows: vec![row] };
        let panels = vec![
            Panel::plane("plane", axis(), axis(), 200, series),
            Panel::rows("rows", axis(), Some(1.0), vec![group]),
        ];
        let section = Section::figure("extreme", "", "", Drawing::of(panels));
        let document = Document { sections: vec![section], ..document() };
        let page = html::draw(&document, &[]).expect("it is drawn");
        for (name, svg) in page.figures {
            let is_clean = [">NaN", "\"NaN", "inf<"].iter().all(|said| !svg.contains(said));
            assert!(is_clean, "{name}: {values:?}: {svg}");
        }
    }
}

/// A figure and another one in its place: both are drawn, and a switch shows one of them; without anything of the
/// other there is no switch.
#[test]
fn a_switch_shows_one_of_two_figures() {
    let figure = |id, drawing| Section::figure(id, id, "A caption.", drawing);
    let page = |other: Drawing| {
        let sections = vec![figure("one", drawing()).or(figure("other", other))];
        html::draw(&Document { sections, ..document() }, &[]).expect("it is drawn")
    };
    let both = page(drawing());
    let names: Vec<&str> = both.figures.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["one.svg", "one-narrow.svg", "other.svg", "other-narrow.svg"]);
    let radios = both.html.matches("<input type=\"radio\" name=\"one-shown\"").count();
    assert_eq!((radios, both.html.matches(" checked>").count()), (2, 1));
    let alone = page(Drawing::default());
    assert_eq!(alone.figures.len(), 2);
    assert!(!alone.html.contains("radio\""));
}
