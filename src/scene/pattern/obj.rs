//! Coarse meshes in OBJ: positions with colours, normals, texture coordinates, polygons, and `st` lines for tags.

use super::PatternScene;
use crate::pattern::{CoarseMesh, Tag};
use crate::scene::error::{quoted, Fault};
use glam::{DVec2, DVec3, DVec4};
use std::collections::HashMap;

/// Largest coordinate: single precision squares it.
const LARGEST: f64 = 1e9;

/// A mesh and where its triangles stand.
pub(super) struct Raw {
    pub mesh: CoarseMesh,
    pub lines: Vec<u32>,
    pub notes: Vec<String>,
}

/// Where triangles stand.
pub(super) struct Places(Vec<u32>);

impl Places {
    pub fn triangle(&self, t: u32) -> (usize, usize) {
        (self.0.get(t as usize).map_or(1, |&line| line as usize), 1)
    }
}

impl Raw {
    pub fn clone_places(&self) -> Places {
        Places(self.lines.clone())
    }

    pub fn into_scene(self, scene: &mut PatternScene) {
        scene.mesh = self.mesh;
        scene.notes.extend(self.notes);
    }
}

/// Reads a whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader::default();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let mut fields = line.split_ascii_whitespace();
        let Some(first) = fields.next() else { continue };
        let rest: Vec<&str> = fields.collect();
        reader.line(first, &rest).map_err(|(field, what, fix)| {
            // Column of a field by counting fields again.
            let text = field.map_or(first, |k| rest[k]);
            let start = text.as_ptr() as usize - line.as_ptr() as usize;
            Fault::new((index + 1, 1 + line[..start].chars().count()), what, fix)
        })?;
        reader.lines.resize(reader.mesh.triangles.len(), index as u32 + 1);
    }
    reader.finish()
}

/// Field (from 0, after the first), what, and the cure.
type Wrong = (Option<usize>, String, &'static str);

#[derive(Default)]
struct Reader {
    mesh: CoarseMesh,
    lines: Vec<u32>,
    positions: Vec<DVec3>,
    colours: Vec<DVec4>,
    normals: Vec<DVec3>,
    uv: Vec<DVec2>,
    /// Tags by position.
    tags: HashMap<u32, Tag>,
    /// A vertex of the mesh is a position with a normal and texture coordinates.
    vertices: HashMap<(u32, Option<u32>, Option<u32>), u32>,
    origin: Vec<u32>,
    polygons: usize,
}

fn number(fields: &[&str], k: usize, what: &str, form: &'static str) -> Result<f64, Wrong> {
    let Some(text) = fields.get(k) else {
        return Err((fields.len().checked_sub(1), format!("{what} is missing"), form));
    };
    match text.parse::<f64>() {
        Ok(x) if x.abs() <= LARGEST => Ok(x),
        _ => Err((Some(k), format!("{} is not a number of moderate size", quoted(text)), form)),
    }
}

fn triple(fields: &[&str], from: usize, form: &'static str) -> Result<DVec3, Wrong> {
    let [x, y, z] = [0, 1, 2].map(|k| number(fields, from + k, ["x", "y", "z"][k], form));
    Ok(DVec3::new(x?, y?, z?))
}

/// A number from 1, or back from -1, as one from 0.
fn index(text: &str, count: usize) -> Option<u32> {
    let n: i64 = text.parse().ok()?;
    let n = if n < 0 { count as i64 + n } else { n - 1 };
    u32::try_from(n).ok().filter(|&n| (n as usize) < count)
}

impl Reader {
    fn line(&mut self, first: &str, rest: &[&str]) -> Result<(), Wrong> {
        match first {
            "v" => {
                self.positions.push(triple(rest, 0, "write `v X Y Z` or `v X Y Z R G B`")?);
                let rgb = if rest.len() >= 6 { triple(rest, 3, "write `v X Y Z R G B`")? } else { DVec3::ONE };
                self.colours.push(rgb.extend(1.0));
            }
            "vn" => self.normals.push(triple(rest, 0, "write `vn X Y Z`")?),
            "vt" => {
                let form = "write `vt S T`";
                self.uv.push(DVec2::new(number(rest, 0, "s", form)?, number(rest, 1, "t", form)?));
            }
            "f" => self.face(rest)?,
            "st" => self.tag(rest)?,
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, rest: &[&str]) -> Result<(), Wrong> {
        if rest.len() < 3 {
            let what = format!("a face has at least three corners, this one has {}", rest.len());
            return Err((None, what, "write `f V1 V2 V3 ...` or remove the line"));
        }
        let mut corners = Vec::with_capacity(rest.len());
        for (k, text) in rest.iter().enumerate() {
            let mut parts = text.split('/');
            let fix = "numbers count from 1 in the order of the lines before, or back from -1";
            let position = index(parts.next().unwrap_or_default(), self.positions.len())
                .ok_or_else(|| (Some(k), format!("{} names no vertex", quoted(text)), fix))?;
            let mut other = |count: usize, what: &str| match parts.next().filter(|part| !part.is_empty()) {
                None => Ok(None),
                Some(part) => match index(part, count) {
                    Some(n) => Ok(Some(n)),
                    None => Err((Some(k), format!("{} names no {what}", quoted(text)), fix)),
                },
            };
            let uv = other(self.uv.len(), "texture coordinate")?;
            let normal = other(self.normals.len(), "normal")?;
            let next = self.origin.len() as u32;
            let vertex = *self.vertices.entry((position, normal, uv)).or_insert(next);
            if vertex == next {
                self.origin.push(position);
                let mesh = &mut self.mesh;
                mesh.positions.push(self.positions[position as usize]);
                mesh.colours.push(self.colours[position as usize]);
                mesh.normals.push(normal.map_or(DVec3::ZERO, |n| self.normals[n as usize]));
                mesh.uv.push(uv.map_or(DVec2::ZERO, |n| self.uv[n as usize]));
            }
            corners.push(vertex);
        }
        self.polygons += usize::from(corners.len() > 3);
        super::fan(&corners, |t| self.mesh.triangles.push(t));
        Ok(())
    }

    fn tag(&mut self, rest: &[&str]) -> Result<(), Wrong> {
        const FORM: &str = "write `st VERTEX TENSION SHARPNESS BIAS DX DY DZ`";
        let text = rest.first().ok_or((None, "the tag names no vertex".to_owned(), FORM))?;
        let fix = "tags follow the `v` lines; vertices count from 1, or back from -1";
        let vertex = index(text, self.positions.len())
            .ok_or_else(|| (Some(0), format!("{} names no vertex", quoted(text)), fix))?;
        let tag = Tag {
            tension: number(rest, 1, "the tension", FORM)?,
            sharpness: number(rest, 2, "the sharpness", FORM)?,
            bias: number(rest, 3, "the bias", FORM)?,
            deviation: triple(rest, 4, FORM)?,
        };
        tag.check(vertex + 1).map_err(|e| (Some(0), e.to_string().replace("; ", ", "), FORM))?;
        if self.tags.insert(vertex, tag).is_some() {
            let what = format!("vertex {} is tagged twice, and at most one crease may pass through it", vertex + 1);
            return Err((Some(0), what, "keep one of the tags"));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Raw, Fault> {
        if self.mesh.triangles.is_empty() {
            return Err(Fault::new((1, 1), "the file has no face", "give `v X Y Z` and `f V1 V2 V3 ...` lines"));
        }
        if !self.tags.is_empty() {
            let tag = |p: &u32| self.tags.get(p).copied().unwrap_or(Tag::NEUTRAL);
            self.mesh.tags = self.origin.iter().map(tag).collect();
        }
        let notes = match self.polygons {
            0 => Vec::new(),
            n => vec![format!("{n} polygons were cut into triangles")],
        };
        Ok(Raw { mesh: self.mesh, lines: self.lines, notes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_and_tags_are_read_and_polygons_cut() {
        let text = "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 2\nvt 0.5 0.25\nst -1 0.5 1 0 0 0.5 0\nf 1/1/1 2//1 3 4\n";
        let raw = read(text.as_bytes()).unwrap();
        assert_eq!(raw.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((raw.lines, raw.notes.len()), (vec![8, 8], 1));
        assert_eq!(raw.mesh.colours[0], DVec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!((raw.mesh.normals[1], raw.mesh.normals[2]), (DVec3::Z * 2.0, DVec3::ZERO));
        assert_eq!(raw.mesh.uv[0], DVec2::new(0.5, 0.25));
        assert_eq!((raw.mesh.tags[3].tension, raw.mesh.tags[3].deviation.y), (0.5, 0.5));
    }

    #[test]
    fn faults_name_line_column_and_cure() {
        let cases = [
            ("f 1 2 9", (4, 7), "names no vertex"),
            ("f 1 2", (4, 1), "three corners"),
            ("f 1/3 2 3", (4, 3), "texture coordinate"),
            ("f 1//1 2 3", (4, 3), "names no normal"),
            ("v 1 2", (4, 5), "z is missing"),
            ("v 1 nan 2", (4, 5), "not a number"),
            ("st 9 0 0 0 0 0 0", (4, 4), "names no vertex"),
            ("st 1 0 2 0 0 0 0", (4, 4), "vertex 1"),
            ("st 1 0 0", (4, 8), "the bias is missing"),
            ("", (1, 1), "no face"),
        ];
        for (line, place, what) in cases {
            let Err(fault) = read(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n").as_bytes()) else {
                panic!("{line} was read");
            };
            assert_eq!((fault.line, fault.column), place, "{line}: {fault:?}");
            assert!(fault.what.contains(what), "{line}: {fault:?}");
        }
    }
}
