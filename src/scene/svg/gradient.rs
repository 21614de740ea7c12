//! Which gradients a drawing has, and where the shapes that they fill put them.

use super::paint::filled_with;
use super::patches::{self, Grid};
use super::shape::{bounds, is_shape, transform};
use super::xml::{shown, Element};
use crate::ferguson::blend::Blend;
use crate::ferguson::Mesh;
use crate::patch::space::{Interpolation, Space};
use crate::scene::error::Fault;
use glam::{DAffine2, DMat2, DVec2};
use std::collections::HashMap;

/// Most patches of one scene.
const MOST: usize = 250_000;

/// A shape that is filled with something.
struct Use<'a> {
    shape: &'a Element,
    map: DAffine2,
}

struct Drawing<'a> {
    gradients: Vec<&'a Element>,
    by_name: HashMap<&'a str, &'a Element>,
    uses: HashMap<String, Vec<Use<'a>>>,
}

fn is_gradient(element: &Element) -> bool {
    matches!(element.name.as_str(), "meshgradient" | "mesh")
}

fn walk<'a>(text: &str, element: &'a Element, outer: DAffine2, found: &mut Drawing<'a>) -> Result<(), Fault> {
    if is_gradient(element) {
        found.gradients.push(element);
        if let Some(id) = element.get("id") {
            found.by_name.entry(id).or_insert(element);
        }
        return Ok(());
    }
    let placed =
        matches!(element.name.as_str(), "g" | "svg" | "a" | "switch" | "defs" | "symbol") || is_shape(&element.name);
    let map = if placed { outer * transform(text, element, "transform")? } else { outer };
    if is_shape(&element.name) {
        if let Some(id) = filled_with(element) {
            found.uses.entry(id).or_default().push(Use { shape: element, map });
        }
    }
    element.children.iter().try_for_each(|child| walk(text, child, map, found))
}

/// Reads all gradients into one mesh.
pub(super) fn read(text: &str, root: &Element) -> Result<(Mesh, Vec<String>), Fault> {
    let mut found = Drawing { gradients: Vec::new(), by_name: HashMap::new(), uses: HashMap::new() };
    walk(text, root, DAffine2::IDENTITY, &mut found)?;
    if found.gradients.is_empty() {
        let fix = "give a drawing with a <meshgradient>";
        return Err(root.fault(text, "the drawing has no mesh gradient", fix));
    }
    let mut notes = Vec::new();
    let mut grids: Vec<Grid> = Vec::new();
    let (mut colour, mut blend) = (Interpolation::default(), Blend::Linear);
    let flip = DAffine2::from_scale(DVec2::new(1.0, -1.0));
    for (i, gradient) in found.gradients.iter().enumerate() {
        let source = with_rows(&found, gradient);
        if source.children.iter().all(|row| row.name != "meshrow") {
            notes.push(format!("the gradient {} has no rows and draws nothing", name_of(gradient)));
            continue;
        }
        let own = transform(text, gradient, "gradientTransform")? * transform(text, gradient, "transform")?;
        let box_units = match gradient.get("gradientUnits") {
            None | Some("objectBoundingBox") => true,
            Some("userSpaceOnUse") => false,
            Some(other) => {
                let fix = "use userSpaceOnUse or objectBoundingBox";
                return Err(gradient.fault(text, format!("gradientUnits {} is unknown", shown(other)), fix));
            }
        };
        let space = settings(text, gradient)?;
        if i == 0 {
            (colour, blend) = space;
        } else if space.0 != colour {
            let fix = "keep gradients of one space in a drawing";
            return Err(gradient.fault(text, "this gradient has another colour space than the first", fix));
        }
        let grid = patches::read(text, source)?;
        let nothing = Vec::new();
        let uses = gradient.get("id").and_then(|id| found.uses.get(id)).unwrap_or(&nothing);
        let mut maps = Vec::new();
        for place in uses {
            let unit = if box_units {
                match bounds(text, place.shape)? {
                    Some([at, size]) => DAffine2 { matrix2: DMat2::from_diagonal(size), translation: at },
                    None => return Err(place.shape.fault(text, "the shape has no size", "give it one")),
                }
            } else {
                DAffine2::IDENTITY
            };
            maps.push(flip * place.map * unit * own);
        }
        if maps.is_empty() {
            notes
                .push(format!("the gradient {} fills no shape and is drawn in its own coordinates", name_of(gradient)));
            maps.push(flip * own);
        } else if uses.iter().any(|place| place.shape.name != "rect") {
            notes.push(format!(
                "the gradient {} is drawn whole, not clipped to the shape that it fills",
                name_of(gradient)
            ));
        }
        for map in maps {
            let placed = grid.mapped(map);
            if grids.iter().map(Grid::patches).sum::<usize>() + placed.patches() > MOST {
                return Err(gradient.fault(
                    text,
                    format!("the drawing has more than {MOST} patches"),
                    "split the drawing",
                ));
            }
            if !placed.is_moderate() {
                return Err(gradient.fault(text, "a coordinate is too large", "scale the drawing to moderate numbers"));
            }
            grids.push(placed);
        }
    }
    if grids.is_empty() {
        return Err(root.fault(
            text,
            "no mesh gradient of the drawing has rows",
            "give a gradient with <meshrow> elements",
        ));
    }
    Ok((patches::mesh(&grids, colour, blend), notes))
}

/// The gradient itself, or, where it has no rows, the one it refers to, through at most 8 references.
fn with_rows<'a>(found: &Drawing<'a>, gradient: &'a Element) -> &'a Element {
    let mut at = gradient;
    for _ in 0..8 {
        if at.children.iter().any(|child| child.name == "meshrow") {
            break;
        }
        let target = at.get("href").and_then(|href| href.trim().strip_prefix('#'));
        match target.and_then(|id| found.by_name.get(id)) {
            Some(next) => at = next,
            None => break,
        }
    }
    at
}

fn name_of(gradient: &Element) -> String {
    shown(gradient.get("id").unwrap_or("without a name"))
}

/// What our own writer says of colours beyond SVG.
fn settings(text: &str, gradient: &Element) -> Result<(Interpolation, Blend), Fault> {
    let mut colour = Interpolation::default();
    if let Some(name) = gradient.get("space") {
        let fix = "use a space that gradtess knows";
        colour.space =
            Space::named(name).ok_or_else(|| gradient.fault(text, format!("space {} is unknown", shown(name)), fix))?;
    }
    colour.premultiplied = gradient.get("alpha") == Some("premultiplied");
    let blend = gradient.get("blend").and_then(Blend::named).unwrap_or(Blend::Linear);
    Ok((colour, blend))
}
