//! Heat maps: numbers of pixels as colours, and the legend that says which.

use colorous::{Gradient, INFERNO, VIRIDIS};

use crate::frame::{Frame, LINE, MARGIN, Rgb, width_of};
use crate::judge::Verdict;

/// Errors of less than the first are shown as that, and of more than the second as the second.
const ERRORS: [f64; 2] = [1e-8, 1e-3];

/// Where there is nothing to measure.
const NOTHING: Rgb = [40, 40, 46];
const FALSE_HIT: Rgb = [255, 0, 255];
const FALSE_MISS: Rgb = [255, 40, 30];

/// A legend's bar.
const BAR: [i32; 2] = [260, 12];

/// What a picture's numbers are, all together.
pub(crate) struct Legend {
    title: String,
    gradient: Gradient,
    /// What stands below the bar, and where, in shares of it.
    marks: Vec<(f64, String)>,
    /// Colours beside the bar, and what they mean.
    others: Vec<(Rgb, String)>,
}

/// The colours of numbers of tests, from 0 to the largest.
pub(crate) fn of_counts(what: &str, counts: &[usize]) -> (Vec<Rgb>, Legend) {
    let largest = counts.iter().copied().max().unwrap_or(0);
    let sum: usize = counts.iter().sum();
    let mean = sum as f64 / counts.len().max(1) as f64;
    let top = round_up(largest);
    let share = |count: usize| count as f64 / top as f64;
    let colors = counts.iter().map(|&count| color(INFERNO, share(count))).collect();
    let marks = (0..=4).map(|quarter| f64::from(quarter) / 4.0);
    let legend = Legend {
        title: format!("{what} of the camera's ray: {mean:.1} on average, {largest} at most"),
        gradient: INFERNO,
        marks: marks.map(|at| (at, format!("{}", at * top as f64))).collect(),
        others: Vec::new(),
    };
    (colors, legend)
}

/// The colours of verdicts: of errors by their logarithm.
pub(crate) fn of_verdicts(verdicts: &[Verdict]) -> (Vec<Rgb>, Legend) {
    let [low, high] = ERRORS.map(f64::log10);
    // Of an exact answer minus infinity.
    let share = |error: f64| ((error.log10() - low) / (high - low)).clamp(0.0, 1.0);
    let colors = verdicts.iter().map(|verdict| match *verdict {
        Verdict::Nothing => NOTHING,
        Verdict::FalseHit => FALSE_HIT,
        Verdict::FalseMiss => FALSE_MISS,
        Verdict::Error(error) => color(VIRIDIS, share(error)),
    });
    let colors = colors.collect();
    let mut errors: Vec<f64> = verdicts
        .iter()
        .filter_map(|verdict| match verdict {
            Verdict::Error(error) => Some(*error),
            _ => None,
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    let median = errors.get(errors.len() / 2);
    let count = |kind: Verdict| verdicts.iter().filter(|verdict| **verdict == kind).count();
    let of_errors = match (median, errors.last()) {
        (Some(median), Some(worst)) => format!("{median:.1e} median, {worst:.1e} at most"),
        _ => "no triangle is hit".to_owned(),
    };
    let others = [
        (FALSE_HIT, "false hits", Verdict::FalseHit),
        (FALSE_MISS, "false misses", Verdict::FalseMiss),
    ];
    let legend = Legend {
        title: format!("relative error of t: {of_errors}"),
        gradient: VIRIDIS,
        marks: (-8..=-3).map(|power| (share(10_f64.powi(power)), format!("1e{power}"))).collect(),
        others: others
            .map(|(color, says, kind)| (color, format!("{says}: {}", count(kind))))
            .into(),
    };
    (colors, legend)
}

fn color(gradient: Gradient, share: f64) -> Rgb {
    let colorous::Color { r, g, b } = gradient.eval_continuous(share);
    [r, g, b]
}

/// The next of 4, 8, 12, 20, 40, 80, 120, 200 and so on: quarters are whole numbers.
fn round_up(largest: usize) -> usize {
    let mut ten = 4;
    loop {
        if let Some(top) =
            [1, 2, 3, 5].map(|times| times * ten).into_iter().find(|top| largest <= *top)
        {
            return top;
        }
        ten *= 10;
    }
}

impl Legend {
    /// Draws it into the lower left corner.
    pub(crate) fn draw(&self, frame: &mut Frame) {
        let [_, height] = frame.size.map(u32::cast_signed);
        let others: i32 =
            self.others.iter().map(|(_, says)| BAR[1] + width_of(says) + 4 * MARGIN).sum();
        let width = width_of(&self.title).max(BAR[0] + 6 * MARGIN + others) + 2 * MARGIN;
        let top = height - (2 * MARGIN + 2 * LINE + BAR[1] + MARGIN);
        frame.shade([0, top], [width, height - top]);
        frame.write(&self.title, [MARGIN, top + MARGIN], [255, 255, 255]);
        let (left, top) = (4 * MARGIN, top + MARGIN + LINE + 2);
        for x in 0..BAR[0] {
            let share = f64::from(x) / f64::from(BAR[0] - 1);
            frame.fill([left + x, top], [1, BAR[1]], color(self.gradient, share));
        }
        for (at, says) in &self.marks {
            #[allow(clippy::cast_possible_truncation, reason = "within the bar")]
            let x = left + (at * f64::from(BAR[0] - 1)).round() as i32;
            frame.fill([x, top + BAR[1]], [1, 3], [255, 255, 255]);
            let says_at = [x - width_of(says) / 2, top + BAR[1] + 3];
            frame.write(says, says_at, [255, 255, 255]);
        }
        let mut x = left + BAR[0] + 4 * MARGIN;
        for (color, says) in &self.others {
            frame.fill([x, top], [BAR[1], BAR[1]], *color);
            x += BAR[1] + MARGIN;
            frame.write(says, [x, top - 1], [255, 255, 255]);
            x += width_of(says) + 3 * MARGIN;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_ends_above_the_largest_at_a_number_whose_quarters_are_whole() {
        let tops = [0, 4, 5, 9, 13, 21, 100, 121, 1999].map(round_up);
        assert_eq!(tops, [4, 4, 8, 12, 20, 40, 120, 200, 2000]);
    }

    #[test]
    fn counts_have_colours_in_their_order() {
        let counts = [0, 3, 12, 7];
        let (colors, legend) = of_counts("nodes", &counts);
        assert_eq!(colors[0], color(INFERNO, 0.0));
        assert_eq!(colors[2], color(INFERNO, 1.0));
        let bright = |color: Rgb| color.map(u32::from).iter().sum::<u32>();
        let mut order = [0, 1, 2, 3];
        order.sort_by_key(|&i: &usize| bright(colors[i]));
        assert_eq!(order, [0, 1, 3, 2]);
        assert_eq!(legend.title, "nodes of the camera's ray: 5.5 on average, 12 at most");
        let marks: Vec<&str> = legend.marks.iter().map(|(_, says)| says.as_str()).collect();
        assert_eq!(marks, ["0", "3", "6", "9", "12"]);
        assert_eq!(of_counts("nodes", &[]).0, [] as [Rgb; 0]);
    }

    #[test]
    fn wrong_decisions_have_colours_that_no_error_has() {
        let errors = [0.0, 1e-300, 1e-8, 1e-6, 1e-3, 5.0, f64::INFINITY].map(Verdict::Error);
        let (colors, legend) = of_verdicts(&errors);
        assert_eq!(colors[0], colors[2]);
        assert_eq!(colors[4], colors[6]);
        assert_ne!(colors[2], colors[3]);
        assert!(legend.title.starts_with("relative error of t: 1.0e-6 median"), "{}", legend.title);
        let wrong = [Verdict::FalseHit, Verdict::FalseMiss, Verdict::FalseMiss, Verdict::Nothing];
        let (wrong, legend) = of_verdicts(&wrong);
        assert!(wrong.iter().all(|wrong| !colors.contains(wrong)));
        let counts: Vec<&str> = legend.others.iter().map(|(_, says)| says.as_str()).collect();
        assert_eq!(counts, ["false hits: 1", "false misses: 2"]);
        assert!(legend.title.ends_with("no triangle is hit"));
    }
}
