//! Colours of stops, and the gradient that a shape is filled with.

use super::xml::{shown, Element};
use crate::scene::error::Fault;
use glam::DVec4;
use std::str::FromStr;

/// Colour and opacity of a stop: sRGB with straight alpha. Black where there is none, as CSS has it.
pub(super) fn stop_colour(text: &str, stop: &Element) -> Result<DVec4, Fault> {
    let rgba = match stop.property("stop-color") {
        None => DVec4::new(0.0, 0.0, 0.0, 1.0),
        Some("currentColor" | "currentcolor") => match stop.property("color") {
            Some(value) => colour(value).ok_or_else(|| unknown(text, stop, value))?,
            None => DVec4::new(0.0, 0.0, 0.0, 1.0),
        },
        Some(value) => colour(value).ok_or_else(|| unknown(text, stop, value))?,
    };
    let opacity = opacity(text, stop, "stop-opacity")?.unwrap_or(1.0);
    Ok(rgba * DVec4::new(1.0, 1.0, 1.0, opacity))
}

/// An opacity that an element states, 0 to 1.
pub(super) fn opacity(text: &str, element: &Element, name: &str) -> Result<Option<f64>, Fault> {
    let Some(value) = element.property(name).filter(|value| *value != "inherit") else { return Ok(None) };
    let number = number_or_percent(value).filter(|o| o.is_finite());
    let wrong = || element.fault(text, format!("{} is no opacity", shown(value)), "give a number from 0 to 1");
    Ok(Some(number.ok_or_else(wrong)?.clamp(0.0, 1.0)))
}

fn unknown(text: &str, stop: &Element, value: &str) -> Fault {
    stop.fault(text, format!("{} is no colour", shown(value)), "give a name, #rrggbb or rgb(r, g, b)")
}

fn number_or_percent(value: &str) -> Option<f64> {
    let value = value.trim();
    match value.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().ok().map(|p| p / 100.0),
        None => value.parse().ok(),
    }
}

/// A CSS colour. `rgb()` is read in full precision, the rest by the `svgtypes` crate.
fn colour(value: &str) -> Option<DVec4> {
    let value = value.trim();
    let inside = value.strip_prefix("rgba(").or(value.strip_prefix("rgb(")).and_then(|v| v.strip_suffix(')'));
    if let Some(inside) = inside {
        let parts: Vec<&str> = inside.split([',', '/', ' ']).map(str::trim).filter(|p| !p.is_empty()).collect();
        if parts.len() == 3 || parts.len() == 4 {
            let mut c = [0.0, 0.0, 0.0, 1.0];
            for (i, part) in parts.iter().enumerate() {
                let scale = if i < 3 && !part.ends_with('%') { 255.0 } else { 1.0 };
                c[i] = (number_or_percent(part)? / scale).clamp(0.0, 1.0);
            }
            return Some(DVec4::from(c)).filter(|c| c.is_finite());
        }
    }
    // An ICC colour may follow the sRGB one.
    let first = value.split(" icc-color").next().unwrap_or(value);
    let c = svgtypes::Color::from_str(first.trim()).ok()?;
    Some(DVec4::new(c.red.into(), c.green.into(), c.blue.into(), c.alpha.into()) / 255.0)
}

/// Name of the paint server that an element is filled with.
pub(super) fn filled_with(element: &Element) -> Option<String> {
    let value = element.property("fill")?.trim();
    let inside = value.strip_prefix("url(")?;
    let (inside, _) = inside.split_once(')')?;
    let inside = inside.trim().trim_matches(['"', '\'']);
    inside.strip_prefix('#').map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_every_kind() {
        let close = |value: &str, c: [f64; 4]| (colour(value).unwrap() - DVec4::from(c)).abs().max_element() < 1e-12;
        assert!(close("#0f0", [0.0, 1.0, 0.0, 1.0]) && close("#ff000080", [1.0, 0.0, 0.0, 128.0 / 255.0]));
        assert!(close("lightblue", [173.0 / 255.0, 216.0 / 255.0, 230.0 / 255.0, 1.0]));
        assert!(
            close("rgb(12.5%, 50%, 100%)", [0.125, 0.5, 1.0, 1.0])
                && close("rgba(255 0 0 / 0.25)", [1.0, 0.0, 0.0, 0.25])
        );
        assert!(colour("rgb(a, b, c)").is_none() && colour("fuzzy").is_none());
    }

    #[test]
    fn fills_name_their_gradient() {
        let with =
            |fill: &str| Element { attributes: vec![("style", format!("fill:{fill};x:y"))], ..Element::default() };
        assert_eq!(filled_with(&with("url(#a)")), Some("a".to_owned()));
        assert_eq!(filled_with(&with("url( '#b' ) none")), Some("b".to_owned()));
        assert_eq!(filled_with(&with("red")), None);
    }
}
