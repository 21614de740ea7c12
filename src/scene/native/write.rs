//! Writer of the native format: one element a line, so that scenes compare well as text.

use super::VERSION;
use crate::scene::{CornerRule, Frame, Handle, Scene};
use glam::{DVec2, DVec4};

/// The scene as JSON text. Empty lists and default values are left out.
///
/// Numbers are written with as many digits as bring them back bit for bit; numbers that are not finite, which no
/// reader produces, become `null` and are refused when read again.
pub fn write(scene: &Scene) -> String {
    let mut members = vec![
        member("gradtess", VERSION.to_string()),
        member("technique", text("subdivision")),
        member("name", text(&scene.name)),
    ];
    if scene.corners == CornerRule::Smooth {
        members.push(member("corners", text("smooth")));
    }
    members.push(list("vertices", scene.mesh.positions.iter().map(|&p| point(p))));
    let faces = scene.mesh.face_start.windows(2);
    members.push(list("faces", faces.map(|f| numbers(&scene.mesh.corners[f[0] as usize..f[1] as usize]))));
    let optional = [
        list("corner_colours", scene.corner_colours.iter().map(|&c| colour(c))),
        if scene.sharp.is_empty() { String::new() } else { member("sharp", numbers(&scene.sharp)) },
        list("handles", scene.handles.iter().map(handle)),
        list("face_points", scene.face_points.iter().map(handle)),
        list(
            "geometry",
            scene.geometry.iter().map(|edit| {
                let vertex = edit.vertex.map_or(String::new(), |vertex| format!(", \"vertex\": {vertex}"));
                let frame = if edit.frame == Frame::Boundary { ", \"frame\": \"boundary\"" } else { "" };
                format!(
                    "{{ \"level\": {}, \"half_edge\": {}{vertex}, \"a\": {}, \"b\": {}{frame} }}",
                    edit.level,
                    edit.half_edge,
                    real(edit.a),
                    real(edit.b)
                )
            }),
        ),
        list(
            "colour",
            scene.colours.iter().map(|edit| {
                let (level, half_edge, colour) = (edit.level, edit.half_edge, colour(edit.colour));
                format!("{{ \"level\": {level}, \"half_edge\": {half_edge}, \"colour\": {colour} }}")
            }),
        ),
    ];
    let reference = scene.reference.as_ref().map(|r| {
        let rect: Vec<String> = r.rect.iter().map(|&x| real(x)).collect();
        let (file, rect, opacity, locked) = (text(&r.file), rect.join(", "), real(r.opacity), r.locked);
        let value = format!("{{ \"file\": {file}, \"rect\": [{rect}], \"opacity\": {opacity}, \"locked\": {locked} }}");
        member("reference", value)
    });
    members.extend(reference);
    members.extend(optional.into_iter().filter(|member| !member.is_empty()));
    format!("{{\n{}\n}}\n", members.join(",\n"))
}

fn member(key: &str, value: String) -> String {
    format!("  \"{key}\": {value}")
}

/// A member with one element a line; nothing when there are no elements.
fn list(key: &str, elements: impl Iterator<Item = String>) -> String {
    let elements: Vec<String> = elements.map(|element| format!("    {element}")).collect();
    if elements.is_empty() {
        return String::new();
    }
    member(key, format!("[\n{}\n  ]", elements.join(",\n")))
}

fn text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn real(value: f64) -> String {
    // Whole numbers read better without the fraction that the serialiser would add; -0 keeps its sign.
    if value.fract() == 0.0 && value.abs() < 1e15 && !(value == 0.0 && value.is_sign_negative()) {
        return format!("{value}");
    }
    serde_json::Value::from(value).to_string()
}

fn numbers(values: &[u32]) -> String {
    let values: Vec<String> = values.iter().map(u32::to_string).collect();
    format!("[{}]", values.join(", "))
}

fn point(p: DVec2) -> String {
    format!("[{}, {}]", real(p.x), real(p.y))
}

fn colour(c: DVec4) -> String {
    let alpha = if c.w == 1.0 { String::new() } else { format!(", {}", real(c.w)) };
    format!("[{}, {}, {}{alpha}]", real(c.x), real(c.y), real(c.z))
}

fn handle(handle: &Handle) -> String {
    format!("{{ \"half_edge\": {}, \"at\": {} }}", handle.half_edge, point(handle.at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    #[test]
    fn reals_read_back_bit_for_bit() {
        for value in [0.0, -0.0, 1.0, -3.0, 0.1, 1e300, -2.5e-310, 1e15, 1e16, f64::MAX, f64::MIN_POSITIVE, 1.0 / 3.0] {
            let back: f64 = serde_json::from_str(&real(value)).unwrap();
            assert_eq!(back.to_bits(), value.to_bits(), "{value}");
        }
    }

    #[test]
    fn a_plain_scene_is_short() {
        let scene = Scene { name: "a \"b\"".into(), mesh: shapes::builtin("triangle").unwrap(), ..Scene::default() };
        let text = write(&scene);
        assert!(text.contains("\"a \\\"b\\\"\"") && text.contains("[0, 1, 2]"), "{text}");
        assert!(!text.contains("corner_colours") && !text.contains("sharp\""), "{text}");
    }
}
