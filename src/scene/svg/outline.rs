//! Boxes of path data: exact, and in time linear in their length whatever their numbers are.
//!
//! Arcs are measured as they are. Made into curves first, as path libraries do, one arc of a few characters becomes as many
//! curves as its radius asks for.

use glam::DVec2;

/// Least and greatest corner.
pub(super) type Bounds = [DVec2; 2];

/// Largest number of a path.
const LARGEST: f64 = 1e9;

fn around(points: impl IntoIterator<Item = DVec2>) -> Option<Bounds> {
    points
        .into_iter()
        .fold(None, |all: Option<Bounds>, p| Some(all.map_or([p, p], |[low, high]| [low.min(p), high.max(p)])))
}

/// Numbers and words of a value, left to right.
struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Scanner<'a> {
    fn new(text: &'a str) -> Scanner<'a> {
        Scanner { text, at: 0 }
    }

    fn bytes(&self) -> &'a [u8] {
        self.text.as_bytes()
    }

    /// Skips white space and commas.
    fn separators(&mut self) {
        while self.peek().is_some_and(|b| b.is_ascii_whitespace() || b == b',') {
            self.at += 1;
        }
    }

    fn peek(&self) -> Option<u8> {
        self.bytes().get(self.at).copied()
    }

    /// The next number after separators, `None` where none begins or it is too large to be worked with.
    fn number(&mut self) -> Option<f64> {
        self.separators();
        let start = self.at;
        let mut end = start;
        let byte = |i: usize| self.bytes().get(i).copied();
        let digits = |mut i: usize| {
            while byte(i).is_some_and(|b| b.is_ascii_digit()) {
                i += 1;
            }
            i
        };
        if matches!(byte(end), Some(b'+' | b'-')) {
            end += 1;
        }
        let whole = digits(end);
        let mut any = whole > end;
        end = whole;
        if byte(end) == Some(b'.') {
            let part = digits(end + 1);
            any |= part > end + 1;
            end = part;
        }
        if !any {
            return None;
        }
        if matches!(byte(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(byte(end + 1), Some(b'+' | b'-')));
            let power = digits(end + 1 + sign);
            // "1em" is a one with a unit.
            if power > end + 1 + sign {
                end = power;
            }
        }
        let value: f64 = self.text[start..end].parse().unwrap_or(f64::NAN);
        if !value.is_finite() || value.abs() > LARGEST {
            return None;
        }
        self.at = end;
        Some(value)
    }
}

/// Box of path data. Reads as far as the data are well formed, as SVG has it.
pub(super) fn of_path(text: &str) -> Option<Bounds> {
    let mut scan = Scanner::new(text);
    let mut all: Option<Bounds> = None;
    let mut grow = |points: &[DVec2]| {
        let more = around(points.iter().copied());
        all = match (all, more) {
            (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
            (a, b) => a.or(b),
        };
    };
    let (mut at, mut start) = (DVec2::ZERO, DVec2::ZERO);
    // Last control point of a cubic or quadratic before, for S and T.
    let (mut cubic, mut quadratic) = (None, None);
    let mut command = 0u8;
    loop {
        scan.separators();
        match scan.peek() {
            Some(c) if c.is_ascii_alphabetic() => {
                command = c;
                scan.at += 1;
            }
            // Numbers that follow repeat the command, a move as lines.
            Some(_) if matches!(command, b'Z' | b'z' | 0) => return all,
            Some(_) => {
                command = if command == b'M' {
                    b'L'
                } else if command == b'm' {
                    b'l'
                } else {
                    command
                }
            }
            None => return all,
        }
        let base = if command.is_ascii_lowercase() { at } else { DVec2::ZERO };
        let (mut new_cubic, mut new_quadratic) = (None, None);
        let Some(to) = (match command.to_ascii_uppercase() {
            b'Z' => Some(start),
            b'M' => step(&mut scan, base).inspect(|p| start = *p),
            b'L' => step(&mut scan, base),
            b'H' => next(&mut scan).map(|x| DVec2::new(base.x + x, at.y)),
            b'V' => next(&mut scan).map(|y| DVec2::new(at.x, base.y + y)),
            kind @ (b'C' | b'S') => (|| {
                let first =
                    if kind == b'C' { step(&mut scan, base)? } else { cubic.map_or(at, |c: DVec2| 2.0 * at - c) };
                let (second, to) = (step(&mut scan, base)?, step(&mut scan, base)?);
                grow(&extremes([at, first, second, to]));
                new_cubic = Some(second);
                Some(to)
            })(),
            kind @ (b'Q' | b'T') => (|| {
                let c =
                    if kind == b'Q' { step(&mut scan, base)? } else { quadratic.map_or(at, |q: DVec2| 2.0 * at - q) };
                let to = step(&mut scan, base)?;
                grow(&extremes([at, at + (c - at) * (2.0 / 3.0), to + (c - to) * (2.0 / 3.0), to]));
                new_quadratic = Some(c);
                Some(to)
            })(),
            b'A' => (|| {
                let (radii, turn) = (DVec2::new(next(&mut scan)?, next(&mut scan)?).abs(), next(&mut scan)?);
                let (large, sweep) = (flag(&mut scan)?, flag(&mut scan)?);
                let to = base + DVec2::new(next(&mut scan)?, next(&mut scan)?);
                grow(&arc([at, to], radii, turn.to_radians(), large, sweep));
                Some(to)
            })(),
            _ => None,
        }) else {
            return all;
        };
        // A move alone draws nothing, but SVG counts it as a point of zero length only; lines follow it as a rule.
        grow(&[at, to][usize::from(command.eq_ignore_ascii_case(&b'M'))..]);
        at = to;
        (cubic, quadratic) = (new_cubic, new_quadratic);
    }
}

fn next(scan: &mut Scanner) -> Option<f64> {
    scan.number()
}

fn step(scan: &mut Scanner, base: DVec2) -> Option<DVec2> {
    Some(base + DVec2::new(next(scan)?, next(scan)?))
}

/// A flag of an arc: one digit, which the next number may touch.
fn flag(scan: &mut Scanner) -> Option<bool> {
    scan.separators();
    let flag = match scan.peek()? {
        b'0' => false,
        b'1' => true,
        _ => return None,
    };
    scan.at += 1;
    Some(flag)
}

/// Ends and turning points of a cubic in x and y.
fn extremes(p: [DVec2; 4]) -> Vec<DVec2> {
    let at = |t: f64| {
        let s = 1.0 - t;
        p[0] * (s * s * s) + p[1] * (3.0 * s * s * t) + p[2] * (3.0 * s * t * t) + p[3] * (t * t * t)
    };
    let mut all = vec![p[0], p[3]];
    let steps = [p[1] - p[0], p[2] - p[1], p[3] - p[2]];
    for [a, b, c] in [steps.map(|d| d.x), steps.map(|d| d.y)] {
        // a s^2 + 2 b s t + c t^2 = 0, in a form that does not cancel.
        let (q2, q1) = (a - 2.0 * b + c, b - a);
        let root = (q1 * q1 - q2 * a).max(0.0).sqrt();
        let q = -(q1 + root.copysign(q1));
        all.extend([q / q2, a / q].into_iter().filter(|t| *t > 0.0 && *t < 1.0).map(at));
    }
    all
}

/// Ends and turning points of an elliptical arc (SVG 2, appendix B.2).
fn arc([from, to]: [DVec2; 2], mut radii: DVec2, turn: f64, large: bool, sweep: bool) -> Vec<DVec2> {
    let mut all = vec![from, to];
    if radii.x == 0.0 || radii.y == 0.0 || from == to {
        return all;
    }
    let axis = DVec2::from_angle(turn);
    // Half the chord in the ellipse's own axes.
    let half = (from - to) * 0.5;
    let own = DVec2::new(axis.dot(half), axis.perp_dot(half));
    let scale = (own / radii).length_squared();
    if scale > 1.0 {
        radii *= scale.sqrt();
    }
    let r2 = radii * radii;
    let o2 = own * own;
    let below = r2.x * o2.y + r2.y * o2.x;
    let k = ((r2.x * r2.y - below).max(0.0) / below).sqrt() * if large == sweep { -1.0 } else { 1.0 };
    let centre_own = DVec2::new(k * radii.x * own.y / radii.y, -k * radii.y * own.x / radii.x);
    let rotate = |p: DVec2| DVec2::new(axis.x * p.x - axis.y * p.y, axis.y * p.x + axis.x * p.y);
    let centre = rotate(centre_own) + (from + to) * 0.5;
    let angle = |p: DVec2| (p / radii).to_angle();
    let (a, b) = (angle(own - centre_own), angle(-own - centre_own));
    let full = std::f64::consts::TAU;
    let extent = if sweep { (b - a).rem_euclid(full) } else { (a - b).rem_euclid(full) };
    // Where x and y of the ellipse turn.
    let tx = (-radii.y * axis.y).atan2(radii.x * axis.x);
    let ty = (radii.y * axis.x).atan2(radii.x * axis.y);
    for t in [tx, tx + 0.5 * full, ty, ty + 0.5 * full] {
        let along = if sweep { (t - a).rem_euclid(full) } else { (a - t).rem_euclid(full) };
        if along < extent {
            all.push(centre + rotate(radii * DVec2::from_angle(t)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(d: &str, expected: [f64; 4]) {
        let [low, high] = of_path(d).unwrap();
        for (a, b) in [low.x, low.y, high.x, high.y].iter().zip(expected) {
            assert!((a - b).abs() < 1e-9, "{d}: {low} {high}, not {expected:?}");
        }
    }

    #[test]
    fn paths_are_measured_to_where_they_turn() {
        path("M1,1h2v3z", [1.0, 1.0, 3.0, 4.0]);
        path("m0 0c0,4 4,4 4,0", [0.0, 0.0, 4.0, 3.0]);
        path("M0 0q2 2 4 0t4 0", [0.0, -1.0, 8.0, 1.0]);
        path("M0 0A1 1 0 0 1 2 0", [0.0, -1.0, 2.0, 0.0]);
        path("M0 0a1 1 0 012 0", [0.0, -1.0, 2.0, 0.0]);
        path("M0 0A1 1 0 0 0 2 0", [0.0, 0.0, 2.0, 1.0]);
        path("M-2 0A2 1 90 0 1 2 0", [-2.0, -4.0, 2.0, 0.0]);
    }

    #[test]
    fn what_is_no_path_is_read_as_far_as_it_goes() {
        path("M1 1 2 2 nan", [1.0, 1.0, 2.0, 2.0]);
        assert!(of_path("").is_none() && of_path("1 2 3").is_none());
    }
}
