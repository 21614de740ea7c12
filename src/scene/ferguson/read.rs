//! Reader of the JSON form.

use super::document::{CurveEntry, Document, PatchEntry};
use super::operations::{apply, coordinates};
use crate::ferguson::blend::{Blend, BLENDS};
use crate::ferguson::mesh::{Corner, Curve, HalfEdge, Jet, Mesh, Patch, Point, Section, Side};
use crate::ferguson::FergusonError;
use crate::patch::space::{Space, SPACES};
use crate::scene::error::{quoted, Fault};
use crate::scene::json_document::document;
use crate::scene::json_position::{place, Step};
use glam::{DVec2, DVec4};
use std::collections::HashMap;
use Step::{Index, Key};

/// Largest coordinate: beyond it, differences lose the precision that exactness needs.
const LARGEST: f64 = 1e9;

/// Reads a whole mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, Fault> {
    let (text, document) = document::<Document>(bytes, |d| d.gradtess)?;
    Reader { text, document: &document }.mesh()
}

struct Reader<'a> {
    text: &'a str,
    document: &'a Document,
}

impl Reader<'_> {
    fn fault(&self, path: &[Step], what: impl std::fmt::Display, fix: impl std::fmt::Display) -> Fault {
        Fault::new(place(self.text, path), what, fix)
    }

    fn mesh(&self) -> Result<Mesh, Fault> {
        let d = self.document;
        self.numbers()?;
        let sided = d.patches.iter().filter(|p| p.sides.is_some()).count();
        let mut mesh = match sided {
            0 => self.quads()?,
            n if n == d.patches.len() => self.sided()?,
            _ => {
                let i = d.patches.iter().position(|p| p.sides.is_none()).unwrap_or(0);
                let what = "some patches name their sides and this one does not";
                return Err(self.fault(&[Key("patches"), Index(i)], what, "give \"sides\" everywhere or nowhere"));
            }
        };
        mesh.name = d.name.clone();
        self.settings(&mut mesh)?;
        self.colours(&mut mesh)?;
        for (p, entry) in d.patches.iter().enumerate() {
            for (i, twist) in entry.twists.iter().flatten().enumerate() {
                mesh.patches[p].corners[i].twist = DVec2::from(*twist);
            }
        }
        if sided > 0 {
            for (p, entry) in d.patches.iter().enumerate() {
                match entry.inherits {
                    Some(all) => (0..4).for_each(|i| mesh.patches[p].corners[i].inherits = all[i]),
                    None => (0..4).for_each(|i| mesh.note_inheritance(HalfEdge::new(p as u32, i))),
                }
            }
        }
        for (i, op) in d.operations.iter().enumerate() {
            let path = [Key("operations"), Index(i)];
            apply(&mut mesh, op).map_err(|(what, fix)| self.fault(&path, what, fix))?;
        }
        mesh.take_journal();
        Ok(mesh)
    }

    /// Every coordinate is a number that can be worked with, and every index there.
    fn numbers(&self) -> Result<(), Fault> {
        let d = self.document;
        if d.patches.is_empty() {
            return Err(self.fault(&[Key("patches")], "the scene has no patch", "list at least one patch"));
        }
        let fine = |x: &f64| x.is_finite() && x.abs() <= LARGEST;
        let far = "a coordinate is too large";
        for (i, point) in d.points.iter().enumerate() {
            if !point.iter().all(fine) {
                return Err(self.fault(&[Key("points"), Index(i)], far, "scale the scene to moderate numbers"));
            }
        }
        for (i, curve) in d.curves.iter().enumerate() {
            let path = [Key("curves"), Index(i)];
            if !curve.handles.iter().flatten().all(fine) {
                return Err(self.fault(&path, far, "scale the scene to moderate numbers"));
            }
            self.index(&path, curve.points.iter(), d.points.len(), "point")?;
        }
        for (i, patch) in d.patches.iter().enumerate() {
            let path = [Key("patches"), Index(i)];
            self.index(&path, patch.points.iter(), d.points.len(), "point")?;
            if !patch.twists.iter().flatten().flatten().all(fine)
                || !patch.jets.iter().flatten().flatten().flatten().all(fine)
            {
                return Err(self.fault(&path, far, "use ordinary twists and colours"));
            }
        }
        Ok(())
    }

    fn index<'i>(
        &self,
        path: &[Step],
        mut all: impl Iterator<Item = &'i u32>,
        end: usize,
        what: &str,
    ) -> Result<(), Fault> {
        match all.find(|&&i| i as usize >= end) {
            None => Ok(()),
            Some(i) => Err(self.fault(
                path,
                format!("{what} {i} does not exist"),
                format!("there are {end}, and numbers count from 0"),
            )),
        }
    }

    fn settings(&self, mesh: &mut Mesh) -> Result<(), Fault> {
        let d = self.document;
        let unknown = |key, value: &str, names: String| {
            Err(self.fault(&[Key(key)], format!("{} is no {key}", quoted(value)), format!("use one of {names}")))
        };
        if let Some(name) = &d.space {
            match Space::named(name) {
                Some(space) => mesh.colour.space = space,
                None => return unknown("space", name, SPACES.map(|s| s.1).join(", ")),
            }
        }
        if let Some(name) = &d.blend {
            match Blend::named(name) {
                Some(blend) => mesh.blend = blend,
                None => return unknown("blend", name, BLENDS.map(|b| b.1).join(", ")),
            }
        }
        match d.alpha.as_deref() {
            None | Some("straight") => {}
            Some("premultiplied") => mesh.colour.premultiplied = true,
            Some(name) => return unknown("alpha", name, "straight, premultiplied".to_owned()),
        }
        Ok(())
    }

    /// Patches by their points, curves between those straight or as given.
    fn quads(&self) -> Result<Mesh, Fault> {
        let d = self.document;
        let points: Vec<DVec2> = d.points.iter().map(|&p| p.into()).collect();
        let quads: Vec<[u32; 4]> = d.patches.iter().map(|p| p.points).collect();
        let mut mesh = Mesh::from_quads(&points, &quads, &[]).map_err(|e| self.topology(&e))?;
        let known: HashMap<[u32; 2], usize> =
            mesh.curves.iter().enumerate().map(|(c, curve)| (curve.ends, c)).collect();
        for (i, entry) in d.curves.iter().enumerate() {
            let [a, b] = entry.points;
            let handles = entry.handles.map(DVec2::from);
            if let Some(&c) = known.get(&[a, b]) {
                mesh.curves[c].handles = handles;
            } else if let Some(&c) = known.get(&[b, a]) {
                mesh.curves[c].handles = [handles[1], handles[0]];
            } else {
                let what = format!("no patch has an edge between the points {a} and {b}");
                return Err(self.fault(&[Key("curves"), Index(i)], what, "name the two points of an edge"));
            }
        }
        Ok(mesh)
    }

    fn topology(&self, e: &FergusonError) -> Fault {
        let FergusonError::Topology { patch, what } = e else {
            return self.fault(&[Key("patches")], e, "correct the patches");
        };
        let (what, fix) = what.split_once("; ").unwrap_or((what, "correct the patch"));
        self.fault(&[Key("patches"), Index(*patch as usize)], what, fix)
    }

    /// Patches with their sides, as the program writes them.
    fn sided(&self) -> Result<Mesh, Fault> {
        let d = self.document;
        let mut mesh = Mesh::default();
        mesh.points = d.points.iter().map(|&at| Point { at: at.into(), on: None, corners: Vec::new() }).collect();
        let curve =
            |c: &CurveEntry| Curve { ends: c.points, handles: c.handles.map(DVec2::from), sides: Default::default() };
        mesh.curves = d.curves.iter().map(curve).collect();
        for (p, entry) in d.patches.iter().enumerate() {
            let path = [Key("patches"), Index(p)];
            let patch = self.patch(entry, p, mesh.curves.len(), &path)?;
            for i in 0..4 {
                let h = HalfEdge::new(p as u32, i);
                let side = patch.sides[i];
                mesh.curves[side.curve as usize].sides[usize::from(side.against)].push(h);
                mesh.points[entry.points[i] as usize].corners.push(h);
            }
            mesh.patches.push(patch);
        }
        for c in 0..mesh.curves.len() {
            let mut sides = std::mem::take(&mut mesh.curves[c].sides);
            for list in &mut sides {
                list.sort_by(|a, b| mesh.side(*a).from.total_cmp(&mesh.side(*b).from));
                for &h in list.iter() {
                    let t = mesh.start(h);
                    if t > 0.0 && t < 1.0 {
                        let point = mesh.corner(h).point as usize;
                        mesh.points[point].on = Some(Section { curve: c as u32, t });
                    }
                }
            }
            mesh.curves[c].sides = sides;
        }
        if let Some((p, what)) = mesh.fault() {
            return Err(self.fault(&[Key("patches"), Index(p as usize)], what, "correct the sides"));
        }
        Ok(mesh)
    }

    fn patch(&self, entry: &PatchEntry, p: usize, curves: usize, path: &[Step]) -> Result<Patch, Fault> {
        let given = entry.sides.ok_or_else(|| self.fault(path, "the patch has no sides", "give \"sides\""))?;
        self.index(path, given.iter().map(|s| &s.0), curves, "curve")?;
        let sides =
            given.map(|s| Side { curve: s.0, against: s.1 > s.2, from: s.1.min(s.2), to: s.1.max(s.2), level: s.3 });
        let corners = [0, 1, 2, 3].map(|i| Corner {
            point: entry.points[i],
            twist: DVec2::ZERO,
            colour: Jet { value: DVec4::ONE, ..Jet::default() },
            inherits: false,
        });
        Ok(Patch {
            sides,
            corners,
            root: entry.root.unwrap_or(p as u32),
            rect: entry.part.unwrap_or([0.0, 0.0, 1.0, 1.0]),
            alive: true,
        })
    }

    /// Colours per point, per corner, or with all derivatives; white where there are none.
    fn colours(&self, mesh: &mut Mesh) -> Result<(), Fault> {
        let d = self.document;
        if !d.colours.is_empty() && d.colours.len() != d.points.len() {
            let what = format!("there are {} colours for {} points", d.colours.len(), d.points.len());
            return Err(self.fault(&[Key("colours")], what, format!("give {} colours", d.points.len())));
        }
        let mut of_points = Vec::new();
        for (i, numbers) in d.colours.iter().enumerate() {
            let c = coordinates(mesh, numbers);
            of_points.push(c.map_err(|(what, fix)| self.fault(&[Key("colours"), Index(i)], what, fix))?);
        }
        let white = mesh.colour.space.encode(DVec4::ONE, mesh.colour.premultiplied);
        for (p, entry) in d.patches.iter().enumerate() {
            for i in 0..4 {
                let value = match &entry.colours {
                    Some(all) => {
                        let path = [Key("patches"), Index(p), Key("colours"), Index(i)];
                        coordinates(mesh, &all[i]).map_err(|(what, fix)| self.fault(&path, what, fix))?
                    }
                    None => of_points.get(entry.points[i] as usize).copied().unwrap_or(white),
                };
                mesh.patches[p].corners[i].colour.value = value;
            }
        }
        mesh.apply_blend();
        for (p, entry) in d.patches.iter().enumerate() {
            for (i, jet) in entry.jets.iter().flatten().enumerate() {
                let [value, du, dv, duv] = jet.map(DVec4::from);
                mesh.patches[p].corners[i].colour = Jet { value, du, dv, duv };
            }
        }
        Ok(())
    }
}
