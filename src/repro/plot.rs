//! Plots as SVG: bars with intervals, lines, meshes. Plain shapes and text, no fonts measured, no scripts, no links.

use std::fmt::Write;

/// Colours of series, told apart by colour-blind readers too (Okabe, Ito 2008).
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const FONT: &str = "font-family=\"system-ui, 'Liberation Sans', sans-serif\" font-size=\"12\" fill=\"#1c1e22\"";
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 70.0;
const TOP: f64 = 34.0;

/// A bar.
#[derive(Clone, Copy, Debug)]
pub struct Bar {
    /// Its height.
    pub value: f64,
    /// Its interval.
    pub interval: Option<[f64; 2]>,
}

/// Bars in groups, one of each series in a group.
pub struct Bars {
    /// Label of the vertical axis.
    pub axis: String,
    /// Names of the series.
    pub series: Vec<String>,
    /// Label and bars of each group; `None` where a series has none.
    pub groups: Vec<(String, Vec<Option<Bar>>)>,
    /// Logarithmic heights.
    pub logarithmic: bool,
}

/// Lines through points.
pub struct Lines {
    /// Labels of both axes.
    pub axes: [String; 2],
    /// Logarithmic axes.
    pub logarithmic: [bool; 2],
    /// Name and points of each series.
    pub series: Vec<(String, Vec<[f64; 2]>)>,
}

/// Faces of a mesh, each filled by what it is.
pub struct Mesh {
    /// What the fills mean, the first for fill 0.
    pub fills: Vec<String>,
    /// Corners, y up, and number of the fill.
    pub faces: Vec<(Vec<[f64; 2]>, usize)>,
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A scale from values to pixels.
struct Scale {
    range: [f64; 2],
    pixels: [f64; 2],
    logarithmic: bool,
}

impl Scale {
    /// Fits `values`; linear scales of `from_zero` begin at 0.
    fn new(values: impl Iterator<Item = f64>, pixels: [f64; 2], logarithmic: bool, from_zero: bool) -> Scale {
        let usable = values.filter(|x| x.is_finite() && (!logarithmic || *x > 0.0));
        let [low, high] = usable.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
        let [low, high] = if low <= high { [low, high] } else { [1.0, 2.0] };
        let range = if logarithmic {
            // Whole steps of 1, 2, 5.
            let (mut a, mut b) = (ticks_log(1e-300, low).last().copied().unwrap_or(low), high);
            if let Some(&next) = ticks_log(high, high * 10.0).first() {
                b = next;
            }
            if a >= b {
                (a, b) = (a * 0.5, b * 2.0);
            }
            [a, b]
        } else {
            let low = if from_zero { low.min(0.0) } else { low };
            let step = step(high - low);
            let high = (high / step).ceil() * step;
            let low = (low / step).floor() * step;
            [low, if high > low { high } else { low + 1.0 }]
        };
        Scale { range, pixels, logarithmic }
    }

    fn at(&self, x: f64) -> f64 {
        let [a, b] = self.range;
        let t = if self.logarithmic { (x.max(a) / a).ln() / (b / a).ln() } else { (x - a) / (b - a) };
        self.pixels[0] + t.clamp(0.0, 1.0) * (self.pixels[1] - self.pixels[0])
    }

    fn ticks(&self) -> Vec<f64> {
        let [a, b] = self.range;
        if self.logarithmic {
            let all = ticks_log(a, b);
            let decades: Vec<f64> =
                all.iter().copied().filter(|x| (x.log10() - x.log10().round()).abs() < 1e-9).collect();
            return if all.len() > 7 && decades.len() > 1 { decades } else { all };
        }
        let step = step(b - a);
        (0..).map(|i| a + step * f64::from(i)).take_while(|x| *x <= b + 1e-9 * (b - a)).collect()
    }
}

/// Numbers 1, 2, 5 times powers of ten from `a` to `b`.
fn ticks_log(a: f64, b: f64) -> Vec<f64> {
    let first = a.log10().floor() as i32;
    let last = b.log10().ceil() as i32;
    (first..=last)
        .flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(e)))
        .filter(|x| *x >= a * (1.0 - 1e-12) && *x <= b * (1.0 + 1e-12))
        .collect()
}

fn step(span: f64) -> f64 {
    let rough = (span / 5.0).max(f64::MIN_POSITIVE);
    let power = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= rough * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A number on an axis or a bar: at most four digits.
fn label(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let magnitude = x.abs().log10().floor();
    if magnitude < -4.0 {
        return format!("{x:.0e}");
    }
    let digits = (3.0 - magnitude).clamp(0.0, 8.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn open(width: f64, height: f64) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" {FONT}>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    )
}

fn text(out: &mut String, x: f64, y: f64, anchor: &str, content: &str) {
    let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escape(content));
}

fn line(out: &mut String, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], style: &str) {
    let _ = writeln!(out, "<line x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\" {style}/>");
}

fn legend(out: &mut String, names: &[&str]) {
    let mut x = LEFT;
    for (name, colour) in names.iter().zip(COLOURS.iter().cycle()) {
        let _ = writeln!(out, "<rect x=\"{x:.1}\" y=\"8\" width=\"12\" height=\"12\" fill=\"{colour}\"/>");
        text(out, x + 17.0, 18.5, "start", name);
        x += 40.0 + 6.6 * name.chars().count() as f64;
    }
}

fn vertical_axis(out: &mut String, scale: &Scale, right: f64, name: &str) {
    for tick in scale.ticks() {
        let y = scale.at(tick);
        line(out, [LEFT, y], [right, y], "stroke=\"#e4e6ea\"");
        text(out, LEFT - 6.0, y + 4.0, "end", &label(tick));
    }
    let middle = 0.5 * (scale.pixels[0] + scale.pixels[1]);
    let _ = writeln!(
        out,
        "<text transform=\"translate(14 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        escape(name)
    );
}

impl Bars {
    /// The plot.
    pub fn svg(&self) -> String {
        let series = self.series.len() as f64;
        let bar = (96.0 / series).clamp(26.0, 48.0);
        let widest =
            self.groups.iter().flat_map(|(name, _)| name.lines()).map(|l| l.chars().count()).max().unwrap_or(0);
        let group = (bar * series + 24.0).max(6.6 * widest as f64 + 12.0);
        let lines = self.groups.iter().map(|(name, _)| name.lines().count()).max().unwrap_or(1) as f64;
        let right = (LEFT + group * self.groups.len() as f64).max(420.0);
        let bottom = TOP + HEIGHT;
        let mut out = open(right + 12.0, bottom + 10.0 + 16.0 * lines);
        let bars = || self.groups.iter().flat_map(|(_, bars)| bars.iter().flatten());
        let values = bars().flat_map(|b| std::iter::once(b.value).chain(b.interval.into_iter().flatten()));
        let scale = Scale::new(values, [bottom, TOP + 14.0], self.logarithmic, true);
        vertical_axis(&mut out, &scale, right, &self.axis);
        for (g, (name, bars)) in self.groups.iter().enumerate() {
            let middle = LEFT + group * (g as f64 + 0.5);
            for (k, b) in bars.iter().enumerate() {
                let Some(b) = b.filter(|b| b.value.is_finite()) else { continue };
                let x = middle + bar * (k as f64 - 0.5 * series);
                let y = scale.at(b.value);
                let _ = writeln!(
                    out,
                    "<rect x=\"{:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                    x + 1.0,
                    bar - 2.0,
                    bottom - y,
                    COLOURS[k % COLOURS.len()]
                );
                let mut top = y;
                if let Some([low, high]) = b.interval {
                    let (c, y0, y1) = (x + 0.5 * bar, scale.at(low), scale.at(high));
                    top = top.min(y1);
                    let style = "stroke=\"#1c1e22\" stroke-width=\"1.2\"";
                    line(&mut out, [c, y0], [c, y1], style);
                    line(&mut out, [c - 4.0, y0], [c + 4.0, y0], style);
                    line(&mut out, [c - 4.0, y1], [c + 4.0, y1], style);
                }
                let _ = writeln!(
                    out,
                    "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"10\">{}</text>",
                    x + 0.5 * bar,
                    top - 4.0,
                    label(b.value)
                );
            }
            for (i, row) in name.lines().enumerate() {
                text(&mut out, middle, bottom + 16.0 + 16.0 * i as f64, "middle", row);
            }
        }
        line(&mut out, [LEFT, bottom], [right, bottom], "stroke=\"#4a4e57\"");
        legend(&mut out, &self.series.iter().map(String::as_str).collect::<Vec<_>>());
        out + "</svg>\n"
    }
}

impl Lines {
    /// The plot.
    pub fn svg(&self) -> String {
        let right = LEFT + 480.0;
        let bottom = TOP + HEIGHT;
        let mut out = open(right + 20.0, bottom + 42.0);
        let all = |axis: usize| self.series.iter().flat_map(move |(_, points)| points.iter().map(move |p| p[axis]));
        let x = Scale::new(all(0), [LEFT, right], self.logarithmic[0], false);
        let y = Scale::new(all(1), [bottom, TOP], self.logarithmic[1], true);
        vertical_axis(&mut out, &y, right, &self.axes[1]);
        for tick in x.ticks() {
            line(&mut out, [x.at(tick), bottom], [x.at(tick), bottom + 5.0], "stroke=\"#4a4e57\"");
            text(&mut out, x.at(tick), bottom + 18.0, "middle", &label(tick));
        }
        text(&mut out, 0.5 * (LEFT + right), bottom + 36.0, "middle", &self.axes[0]);
        for ((_, points), colour) in self.series.iter().zip(COLOURS.iter().cycle()) {
            let usable = |p: &&[f64; 2]| (0..2).all(|i| p[i].is_finite() && (!self.logarithmic[i] || p[i] > 0.0));
            let places: Vec<[f64; 2]> = points.iter().filter(usable).map(|p| [x.at(p[0]), y.at(p[1])]).collect();
            let list: Vec<String> = places.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
            let _ = writeln!(
                out,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\"/>",
                list.join(" ")
            );
            for [px, py] in places {
                let _ = writeln!(out, "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"3\" fill=\"{colour}\"/>");
            }
        }
        line(&mut out, [LEFT, bottom], [right, bottom], "stroke=\"#4a4e57\"");
        legend(&mut out, &self.series.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>());
        out + "</svg>\n"
    }
}

/// Fills of faces: pale, so that the edges stay the darkest.
const FILLS: [&str; 4] = ["#e4e6ea", "#f3a69a", "#f4dd8a", "#a9d8a4"];

impl Mesh {
    /// The plot.
    pub fn svg(&self) -> String {
        let points = || self.faces.iter().flat_map(|(corners, _)| corners.iter());
        let bound = |axis: usize| {
            points().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p[axis]), h.max(p[axis])])
        };
        let [[x0, x1], [y0, y1]] = [bound(0), bound(1)];
        let size = 360.0;
        let scale = size / (x1 - x0).max(y1 - y0).max(f64::MIN_POSITIVE);
        let (width, height) = (scale * (x1 - x0), scale * (y1 - y0));
        let (width, height) = if width.is_finite() { (width, height) } else { (size, size) };
        let mut out = open((width + 20.0).max(420.0), height + TOP + 10.0);
        for (corners, fill) in &self.faces {
            let at = |p: &[f64; 2]| format!("{:.1},{:.1}", 10.0 + scale * (p[0] - x0), TOP + scale * (y1 - p[1]));
            let list: Vec<String> = corners.iter().map(at).collect();
            let _ = writeln!(
                out,
                "<polygon points=\"{}\" fill=\"{}\" stroke=\"#4a4e57\" stroke-linejoin=\"round\"/>",
                list.join(" "),
                FILLS[fill % FILLS.len()]
            );
        }
        let mut x = 10.0;
        for (name, fill) in self.fills.iter().zip(FILLS) {
            let _ = writeln!(out, "<rect x=\"{x:.1}\" y=\"8\" width=\"12\" height=\"12\" fill=\"{fill}\"/>");
            text(&mut out, x + 17.0, 18.5, "start", name);
            x += 40.0 + 6.6 * name.chars().count() as f64;
        }
        out + "</svg>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_hold_their_values_and_have_round_ticks() {
        let scale = Scale::new([0.3, 7.2].into_iter(), [100.0, 0.0], false, true);
        assert_eq!(scale.range, [0.0, 8.0]);
        assert_eq!(scale.at(4.0), 50.0);
        let scale = Scale::new([3.0, 900.0].into_iter(), [0.0, 1.0], true, false);
        assert_eq!(scale.range.map(|x| x.round()), [2.0, 1000.0]);
        assert!(scale.ticks().len() > 1);
        let none = Scale::new(std::iter::empty(), [0.0, 1.0], false, false);
        assert!(none.at(3.0).is_finite());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([0.0, 0.25, 1234.5, 94464.0, 1e-7].map(label), ["0", "0.25", "1234", "94464", "1e-7"]);
    }

    #[test]
    fn names_cannot_break_out_of_a_plot() {
        let bar = Bar { value: 2.0, interval: Some([1.5, 2.5]) };
        let bars = Bars {
            axis: "a<b".to_owned(),
            series: vec!["</svg><script>".to_owned()],
            groups: vec![("x & y".to_owned(), vec![Some(bar)])],
            logarithmic: false,
        };
        let svg = bars.svg();
        assert!(!svg.contains("<script>") && svg.contains("x &amp; y") && svg.matches("</svg>").count() == 1);
    }
}
