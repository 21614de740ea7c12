//! The `operations` of a scene, done in order.

use super::document::{HandleName, Operation, PointName};
use crate::ferguson::inherit::Continuity;
use crate::ferguson::mesh::{HalfEdge, Mesh};
use crate::ferguson::split::Axis;
use crate::ferguson::FergusonError;
use glam::{DVec2, DVec4};

/// What is wrong with an operation and what to do.
pub(super) type Wrong = (String, String);

fn wrong(what: &str, fix: &str) -> Wrong {
    (what.to_owned(), fix.to_owned())
}

/// Does one operation.
pub(super) fn apply(mesh: &mut Mesh, op: &Operation) -> Result<(), Wrong> {
    let named = [
        op.split.is_some(),
        op.remove_split.is_some(),
        op.move_point.is_some(),
        op.handle.is_some(),
        op.twist.is_some(),
        op.colour.is_some(),
        op.sector.is_some(),
    ];
    if named.iter().filter(|&&x| x).count() != 1 {
        let fix = "give one of split, remove_split, move, handle, twist, colour, sector";
        return Err(wrong("an operation has to say what it does, once", fix));
    }
    let mode = match op.mode.as_deref() {
        None | Some("c1") => Continuity::C1,
        Some("c0") => Continuity::C0,
        Some(_) => return Err(wrong("the mode is unknown", "use \"c1\" or \"c0\"")),
    };
    let done = if let Some(p) = op.split {
        match (op.u, op.v) {
            (Some(at), None) => mesh.split(p, Axis::U, at).map(drop),
            (None, Some(at)) => mesh.split(p, Axis::V, at).map(drop),
            _ => return Err(wrong("a split has one parameter", "give \"u\" or \"v\"")),
        }
    } else if let Some(c) = op.remove_split {
        mesh.remove_split(c).map(drop)
    } else if let Some(name) = op.move_point {
        let point = point(mesh, name)?;
        mesh.move_point(point, place(op)?, mode)
    } else if let Some(name) = op.handle {
        let (c, end) = handle(mesh, name)?;
        mesh.move_handle(c, end, place(op)?, mode)
    } else if let Some(corner) = op.twist {
        let corner = half_edge(mesh, corner)?;
        mesh.set_twist(corner, place(op)?, mode)
    } else if let Some(name) = op.colour {
        let point = point(mesh, name)?;
        mesh.set_colour(point, coordinates(mesh, op.to.as_deref().unwrap_or(&[]))?, mode)
    } else if let Some(corner) = op.sector {
        let corner = half_edge(mesh, corner)?;
        mesh.set_sector_colour(corner, coordinates(mesh, op.to.as_deref().unwrap_or(&[]))?, mode)
    } else {
        Ok(())
    };
    done.map_err(|e: FergusonError| {
        let text = e.to_string();
        let (what, fix) = text.split_once("; ").unwrap_or((&text, "correct the operation"));
        wrong(what, fix)
    })
}

fn point(mesh: &Mesh, name: PointName) -> Result<u32, Wrong> {
    match name {
        PointName::Number(point) => Ok(point),
        PointName::Corner(corner) => Ok(mesh.corner(half_edge(mesh, corner)?).point),
    }
}

/// A curve and which of its ends.
fn handle(mesh: &Mesh, name: HandleName) -> Result<(u32, usize), Wrong> {
    match name {
        HandleName::Curve([c, end @ 0..=1]) => Ok((c, end as usize)),
        HandleName::Side([p, side, end @ 0..=1]) => {
            let h = half_edge(mesh, [p, side])?;
            let side = mesh.side(h);
            let end = usize::from((end == 1) != side.against);
            // Where the side ends inside its curve there is a T-section, and no handle of its own.
            if [side.from != 0.0, side.to != 1.0][end] {
                return Err(wrong("the side ends in a T-section there", "give the patch across, whose side is longer"));
            }
            Ok((side.curve, end))
        }
        HandleName::Curve(_) => Err(wrong("a curve has the ends 0 and 1", "give [curve, 0] or [curve, 1]")),
        HandleName::Side(_) => {
            Err(wrong("a side has the ends 0 and 1", "give [patch, side, 0], where it begins, or [patch, side, 1]"))
        }
    }
}

fn half_edge(mesh: &Mesh, [p, corner]: [u32; 2]) -> Result<HalfEdge, Wrong> {
    if (p as usize) < mesh.patches.len() && corner < 4 {
        Ok(HalfEdge::new(p, corner as usize))
    } else {
        Err(wrong("no such corner of a patch", "give [patch, corner], the corner from 0 to 3"))
    }
}

fn place(op: &Operation) -> Result<DVec2, Wrong> {
    match op.to.as_deref() {
        Some(&[x, y]) => Ok(DVec2::new(x, y)),
        _ => Err(wrong("a place has two numbers", "give \"to\": [x, y]")),
    }
}

/// Coordinates in the mesh's space of sRGB numbers from a file: three, or four with alpha.
pub(super) fn coordinates(mesh: &Mesh, numbers: &[f64]) -> Result<DVec4, Wrong> {
    let rgba = match *numbers {
        [r, g, b] => DVec4::new(r, g, b, 1.0),
        [r, g, b, a] => DVec4::new(r, g, b, a),
        _ => {
            return Err(wrong(
                "a colour has three or four numbers",
                "give [red, green, blue] or [red, green, blue, alpha]",
            ))
        }
    };
    if !(0.0..=1.0).contains(&rgba.w) {
        return Err((format!("alpha {} is out of range", rgba.w), "give 0 (clear) to 1 (opaque)".to_owned()));
    }
    let c = mesh.colour.space.encode(rgba, mesh.colour.premultiplied);
    if c.is_finite() {
        Ok(c)
    } else {
        Err(wrong("the colour is too far out to be converted", "use numbers from 0 to 1"))
    }
}
