//! Which gradients a drawing has, and where the shapes that they fill put them.

use super::paint::{filled_with, opacity};
use super::patches::{self, Grid};
use super::shape::{bounds, is_shape, transform};
use super::xml::{shown, Element};
use crate::ferguson::blend::Blend;
use crate::ferguson::Mesh;
use crate::patch::space::{Interpolation, Space};
use crate::scene::error::Fault;
use glam::{DAffine2, DMat2, DVec2};
use std::collections::{HashMap, HashSet};

/// Most patches of one scene.
const MOST: usize = 250_000;

/// A shape that is filled with something.
struct Use<'a> {
    shape: &'a Element,
    map: DAffine2,
    opacity: f64,
}

/// What an element hands down to those in it.
#[derive(Clone, Copy)]
struct Inherited<'a> {
    map: DAffine2,
    /// Where the fill is said.
    fill: Option<&'a Element>,
    fill_opacity: f64,
    /// Of all groups around.
    opacity: f64,
    shown: bool,
}

struct Drawing<'a> {
    gradients: Vec<&'a Element>,
    by_name: HashMap<&'a str, &'a Element>,
    uses: HashMap<String, Vec<Use<'a>>>,
}

fn is_gradient(element: &Element) -> bool {
    matches!(element.name.as_str(), "meshgradient" | "mesh")
}

fn walk<'a>(text: &str, element: &'a Element, outer: Inherited<'a>, found: &mut Drawing<'a>) -> Result<(), Fault> {
    if is_gradient(element) {
        found.gradients.push(element);
        if let Some(id) = element.get("id") {
            found.by_name.entry(id).or_insert(element);
        }
        return Ok(());
    }
    let mut own = outer;
    let placed =
        matches!(element.name.as_str(), "g" | "svg" | "a" | "switch" | "defs" | "symbol") || is_shape(&element.name);
    if placed {
        own.map = outer.map * transform(text, element, "transform")?;
        own.fill_opacity = opacity(text, element, "fill-opacity")?.unwrap_or(outer.fill_opacity);
        own.opacity *= opacity(text, element, "opacity")?.unwrap_or(1.0);
        own.shown &= element.property("display") != Some("none");
    }
    // Shapes that others are cut or drawn with are not drawn themselves.
    own.shown &= !matches!(element.name.as_str(), "clippath" | "mask" | "pattern" | "marker");
    if element.property("fill").is_some() {
        own.fill = Some(element);
    }
    if own.shown && is_shape(&element.name) {
        if let Some(id) = own.fill.and_then(filled_with) {
            let opacity = own.fill_opacity * own.opacity;
            found.uses.entry(id).or_default().push(Use { shape: element, map: own.map, opacity });
        }
    }
    element.children.iter().try_for_each(|child| walk(text, child, own, found))
}

/// Reads all gradients into one mesh.
pub(super) fn read(text: &str, root: &Element) -> Result<(Mesh, Vec<String>), Fault> {
    let mut found = Drawing { gradients: Vec::new(), by_name: HashMap::new(), uses: HashMap::new() };
    let nothing = Inherited { map: DAffine2::IDENTITY, fill: None, fill_opacity: 1.0, opacity: 1.0, shown: true };
    walk(text, root, nothing, &mut found)?;
    if found.gradients.is_empty() {
        let fix = "give a drawing with a <meshgradient>";
        return Err(root.fault(text, "the drawing has no mesh gradient", fix));
    }
    let mut notes = Vec::new();
    let mut grids: Vec<Grid> = Vec::new();
    let (mut colour, mut blend) = (Interpolation::default(), Blend::Linear);
    let flip = DAffine2::from_scale(DVec2::new(1.0, -1.0));
    let templates_used: HashSet<&str> = found.gradients.iter().filter_map(|e| template(e)).collect();
    for (i, gradient) in found.gradients.iter().enumerate() {
        let chain = templates(&found, gradient);
        // What a gradient does not say it takes from those that it refers to: its rows, and every attribute.
        let with = |name: &str| chain.iter().copied().find(|e| e.get(name).is_some()).unwrap_or(gradient);
        let has_rows = |e: &&Element| e.children.iter().any(|child| child.name == "meshrow");
        let Some(source) = chain.iter().copied().find(has_rows) else {
            notes.push(format!("the gradient {} has no rows and draws nothing", name_of(gradient)));
            continue;
        };
        let uses = gradient.get("id").and_then(|id| found.uses.get(id)).map_or(&[][..], |uses| &uses[..]);
        // A template that others are made from draws nothing itself.
        if uses.is_empty() && gradient.get("id").is_some_and(|id| templates_used.contains(id)) {
            continue;
        }
        let turned = chain.iter().copied().find(|e| e.get("gradientTransform").or(e.get("transform")).is_some());
        let turned = turned.unwrap_or(gradient);
        let own = transform(text, turned, "gradientTransform")? * transform(text, turned, "transform")?;
        let box_units = match with("gradientUnits").get("gradientUnits") {
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
        let grid = patches::read(text, source, with)?;
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
            maps.push((flip * place.map * unit * own, place.opacity));
        }
        if maps.is_empty() {
            notes
                .push(format!("the gradient {} fills no shape and is drawn in its own coordinates", name_of(gradient)));
            maps.push((flip * own, 1.0));
        } else if uses.iter().any(|place| place.shape.name != "rect") {
            notes.push(format!(
                "the gradient {} is drawn whole, not clipped to the shape that it fills",
                name_of(gradient)
            ));
        }
        for (map, opacity) in maps {
            let placed = grid.mapped(map).fainter(opacity, colour.premultiplied);
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

/// Name of the gradient that this one refers to.
fn template(gradient: &Element) -> Option<&str> {
    gradient.get("href")?.trim().strip_prefix('#')
}

/// The gradient, and those that it refers to, nearest first: at most 8.
fn templates<'a>(found: &Drawing<'a>, gradient: &'a Element) -> Vec<&'a Element> {
    let mut chain = vec![gradient];
    while let Some(next) = template(chain[chain.len() - 1]).and_then(|id| found.by_name.get(id)) {
        if chain.len() == 8 {
            break;
        }
        chain.push(next);
    }
    chain
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
