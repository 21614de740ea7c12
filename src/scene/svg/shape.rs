//! Bounding boxes of the shapes that gradients fill, for `gradientUnits="objectBoundingBox"`.

use super::outline::of_path;
use super::xml::{shown, Element};
use crate::scene::error::Fault;
use glam::{DAffine2, DMat2, DVec2};
use std::str::FromStr;

/// An affine map from a `transform` attribute.
pub(super) fn transform(text: &str, element: &Element, name: &str) -> Result<DAffine2, Fault> {
    let Some(value) = element.get(name) else { return Ok(DAffine2::IDENTITY) };
    match svgtypes::Transform::from_str(value) {
        Ok(t) => {
            let map = DAffine2 {
                matrix2: DMat2::from_cols(DVec2::new(t.a, t.b), DVec2::new(t.c, t.d)),
                translation: DVec2::new(t.e, t.f),
            };
            if map.is_finite() {
                return Ok(map);
            }
            Err(element.fault(text, format!("{name} is not finite"), "use ordinary numbers"))
        }
        Err(_) => Err(element.fault(text, format!("{name} {} is no transform", shown(value)), "correct the transform")),
    }
}

/// A length in user units. Percentages and font sizes depend on things that a scene has not.
pub(super) fn length(text: &str, element: &Element, name: &str) -> Result<f64, Fault> {
    use svgtypes::LengthUnit as Unit;
    let Some(value) = element.get(name) else { return Ok(0.0) };
    let wrong =
        |what: &str| element.fault(text, format!("{name}={} {what}", shown(value)), "give a number in user units");
    let length = svgtypes::Length::from_str(value).map_err(|_| wrong("is no length"))?;
    let factor = match length.unit {
        Unit::None | Unit::Px => 1.0,
        Unit::In => 96.0,
        Unit::Cm => 96.0 / 2.54,
        Unit::Mm => 96.0 / 25.4,
        Unit::Pt => 96.0 / 72.0,
        Unit::Pc => 16.0,
        Unit::Em | Unit::Ex | Unit::Percent => return Err(wrong("has a unit that is not known here")),
    };
    let number = length.number * factor;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(wrong("is not finite"))
    }
}

/// Whether an element is a shape that has a box.
pub(super) fn is_shape(name: &str) -> bool {
    ["rect", "circle", "ellipse", "polygon", "polyline", "path", "line"].contains(&name)
}

/// Bounding box of a shape: low corner and size. Exact; a path counts as far as it is well formed, as SVG has it.
pub(super) fn bounds(text: &str, shape: &Element) -> Result<Option<[DVec2; 2]>, Fault> {
    let at = |x: &str, y: &str| Ok(DVec2::new(length(text, shape, x)?, length(text, shape, y)?));
    let around = |centre: DVec2, radii: DVec2| Some([centre - radii, radii * 2.0]);
    Ok(match shape.name.as_str() {
        "rect" => Some([at("x", "y")?, at("width", "height")?]),
        "circle" => around(at("cx", "cy")?, at("r", "r")?),
        "ellipse" => around(at("cx", "cy")?, at("rx", "ry")?),
        "line" => box_of([at("x1", "y1")?, at("x2", "y2")?].into_iter()),
        "polygon" | "polyline" => {
            let points = svgtypes::PointsParser::from(shape.get("points").unwrap_or(""));
            box_of(points.map(|(x, y)| DVec2::new(x, y)))
        }
        "path" => of_path(shape.get("d").unwrap_or("")).map(|[low, high]| [low, high - low]),
        _ => None,
    })
}

fn box_of(points: impl Iterator<Item = DVec2>) -> Option<[DVec2; 2]> {
    let mut all: Option<[DVec2; 2]> = None;
    for p in points.filter(|p| p.is_finite()) {
        let [low, high] = all.unwrap_or([p, p]);
        all = Some([low.min(p), high.max(p)]);
    }
    all.map(|[low, high]| [low, high - low])
}
