//! A control net as SVG: curves, and points as discs parted into the colours of their sectors.

use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Width of the drawing in pixels.
const WIDTH: f64 = 640.0;

/// A sector of a point: the directions of its two sides, and its colour.
struct Sector {
    from: f64,
    to: f64,
    colour: [f64; 3],
}

fn control(patch: &Value) -> Vec<[f64; 6]> {
    let point = |p: &Value| {
        let numbers: Vec<f64> = p.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        <[f64; 6]>::try_from(numbers).ok()
    };
    patch["control"].as_array().into_iter().flatten().filter_map(point).collect()
}

/// The net of what `gradtess patches` has printed of a scene in sRGB.
pub fn svg(patches: &Value) -> String {
    let all: Vec<(&Value, Vec<[f64; 6]>)> = patches["patches"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|p| (p, control(p)))
        .filter(|(_, points)| points.len() == 16)
        .collect();
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for p in all.iter().flat_map(|(_, points)| points) {
        bounds = [bounds[0].min(p[0]), bounds[1].min(p[1]), bounds[2].max(p[0]), bounds[3].max(p[1])];
    }
    if all.is_empty() {
        bounds = [0.0, 0.0, 1.0, 1.0];
    }
    let margin = 14.0;
    let scale = (WIDTH - 2.0 * margin) / (bounds[2] - bounds[0]).max(1e-9);
    let height = (bounds[3] - bounds[1]) * scale + 2.0 * margin;
    let place = |p: &[f64; 6]| [margin + (p[0] - bounds[0]) * scale, height - margin - (p[1] - bounds[1]) * scale];
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.1}\" width=\"{WIDTH}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n<g fill=\"none\" stroke=\"#40444c\" stroke-width=\"1\">\n"
    );
    let mut points: BTreeMap<u64, ([f64; 2], bool, Vec<Sector>)> = BTreeMap::new();
    for (patch, net) in &all {
        for (i, slots) in crate::patch::eval::FACE_EDGES.into_iter().enumerate() {
            let q = slots.map(|slot| place(&net[slot]));
            let _ = writeln!(
                out,
                "<path d=\"M{:.1} {:.1}C{:.1} {:.1} {:.1} {:.1} {:.1} {:.1}\"/>",
                q[0][0], q[0][1], q[1][0], q[1][1], q[2][0], q[2][1], q[3][0], q[3][1]
            );
            // The side before this one ends in the corner where this one begins.
            let before = crate::patch::eval::FACE_EDGES[(i + 3) & 3].map(|slot| place(&net[slot]));
            let towards = |at: [f64; 2], others: [[f64; 2]; 3]| {
                let far = others.into_iter().find(|o| (o[0] - at[0]).hypot(o[1] - at[1]) > 1e-3).unwrap_or(at);
                (far[1] - at[1]).atan2(far[0] - at[0])
            };
            let sector = Sector {
                from: towards(q[0], [q[1], q[2], q[3]]),
                to: towards(q[0], [before[2], before[1], before[0]]),
                colour: [net[slots[0]][2], net[slots[0]][3], net[slots[0]][4]],
            };
            let id = patch["points"][i].as_u64().unwrap_or_default();
            let section = patch["inherits"][i].as_bool().unwrap_or(false);
            points.entry(id).or_insert_with(|| (q[0], section, Vec::new())).2.push(sector);
        }
    }
    out += "</g>\n<g stroke=\"#1c1e22\" stroke-width=\"0.6\">\n";
    for (at, section, sectors) in points.values() {
        let r = if *section { 3.5 } else { 7.0 };
        for s in sectors {
            let [red, green, blue] = s.colour.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8);
            // The way round that is shorter than half a turn.
            let sweep = u8::from((s.to - s.from).rem_euclid(TAU) <= PI);
            let end = |a: f64| [at[0] + r * a.cos(), at[1] + r * a.sin()];
            let (a, b) = (end(s.from), end(s.to));
            let _ = writeln!(
                out,
                "<path fill=\"#{red:02x}{green:02x}{blue:02x}\" d=\"M{:.1} {:.1}L{:.1} {:.1}A{r} {r} 0 0 {sweep} {:.1} {:.1}Z\"/>",
                at[0], at[1], a[0], a[1], b[0], b[1]
            );
        }
    }
    out + "</g>\n</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_corner_is_a_sector_of_its_colour() {
        let control: Vec<[f64; 6]> =
            (0..16).map(|i| [f64::from(i % 4), f64::from(i / 4), f64::from(u8::from(i == 0)), 0.0, 0.0, 1.0]).collect();
        let text = svg(&json!({ "patches": [{ "points": [0, 1, 2, 3], "control": control }] }));
        assert_eq!((text.matches("<path fill").count(), text.matches("#ff0000").count()), (4, 1));
        assert!(svg(&json!({})).ends_with("</svg>\n"));
    }
}
