//! Reader of the authors' format, with the place of every fault.

use crate::scene::error::{quoted, Fault};
use crate::scene::numbering::{HalfEdges, FINEST_LEVEL};
use crate::scene::{ColourEdit, CornerRule, EditLines, Frame, GeometryEdit, InputMesh, Scene};
use glam::{DVec2, DVec4};
use std::collections::HashMap;

/// Reads a whole model.
pub(in crate::scene) fn read(bytes: &[u8]) -> Result<Scene, Fault> {
    // Comments may be in any encoding; only the fields that are used have to be plain ASCII.
    let text = String::from_utf8_lossy(bytes);
    let mut model = Model::default();
    let mut surface = None;
    for (index, line) in text.lines().enumerate() {
        let line = Line { text: line, number: index + 1 };
        let mut fields = line.fields();
        match fields.next().map(|field| field.text) {
            Some("v") => model.vertex(&line)?,
            Some("f") => model.face(&line)?,
            Some("ve") => model.geometry_edit(&line)?,
            Some("ce") => model.colour_edit(&line)?,
            Some("fs" | "as" | "vn") => surface = surface.or(Some(line.number)),
            Some("t") if fields.next().is_some_and(|field| field.text == "crease") => {
                surface = surface.or(Some(line.number));
            }
            _ => {}
        }
    }
    if let (Some(line), true) = (surface, model.geometry.is_empty() && model.colours.is_empty()) {
        return Err(Fault::new(
            (line, 1),
            "this is a scene of technique surface (an OBJ surface)",
            "give a gradient mesh (2D `v`, `f`, `ve`, `ce` lines) or a JSON scene",
        ));
    }
    model.finish(&text)
}

/// One line and its number from 1.
struct Line<'a> {
    text: &'a str,
    number: usize,
}

/// One field of a line; `start` is its byte in the line.
#[derive(Clone, Copy)]
struct Field<'a> {
    text: &'a str,
    start: usize,
}

impl<'a> Line<'a> {
    /// The fields between blanks (spaces, tabs), up to a comment.
    fn fields(&self) -> impl Iterator<Item = Field<'a>> {
        let line = self.text;
        line.split_ascii_whitespace()
            .map(move |text| Field { text, start: text.as_ptr() as usize - line.as_ptr() as usize })
            .take_while(|field| !field.text.starts_with('#'))
    }

    fn place(&self, byte: usize) -> (usize, usize) {
        (self.number, self.text[..byte].chars().count() + 1)
    }

    /// The fields after the first token, each with the name it has in messages.
    fn named<const N: usize>(&self, form: &str, names: [&'static str; N]) -> Result<[Named<'a>; N], Fault> {
        let mut fields = self.fields().skip(1);
        let mut named = [Named { name: "", field: Field { text: "", start: 0 } }; N];
        for (slot, name) in named.iter_mut().zip(names) {
            let field = fields.next().ok_or_else(|| {
                let place = self.place(self.text.trim_end().len());
                Fault::new(place, format!("{name} is missing"), format!("write `{form}`"))
            })?;
            *slot = Named { name, field };
        }
        Ok(named)
    }

    fn real(&self, Named { name, field }: Named) -> Result<f64, Fault> {
        // Single precision as in the authors' tool: their positions and edits depend on its rounding.
        match field.text.parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(f64::from(value)),
            Ok(_) => Err(Fault::new(
                self.place(field.start),
                format!("{name} {} is not a finite single-precision number", quoted(field.text)),
                "give a number below 3.4e38",
            )),
            Err(_) => Err(Fault::new(
                self.place(field.start),
                format!("{name} {} is not a number", quoted(field.text)),
                "give a decimal number such as 0.5",
            )),
        }
    }

    fn whole(&self, Named { name, field }: Named) -> Result<u64, Fault> {
        field.text.parse().map_err(|_| {
            Fault::new(
                self.place(field.start),
                format!("{name} {} is not a whole number", quoted(field.text)),
                "give a whole number from 0",
            )
        })
    }

    fn level(&self, named: Named) -> Result<u32, Fault> {
        let level = self.whole(named)?;
        if level > u64::from(FINEST_LEVEL) {
            return Err(Fault::new(
                self.place(named.field.start),
                format!("level {level} is too fine"),
                format!("levels go from 0 to {FINEST_LEVEL}"),
            ));
        }
        Ok(level as u32)
    }
}

#[derive(Clone, Copy)]
struct Named<'a> {
    name: &'static str,
    field: Field<'a>,
}

/// What has been read so far; each edit with its line, because ranges are known only at the end.
#[derive(Default)]
struct Model {
    mesh: InputMesh,
    geometry: Vec<(GeometryEdit, usize)>,
    geometry_by_key: HashMap<(u32, u64), usize>,
    colours: Vec<(ColourEdit, usize)>,
    colour_by_key: HashMap<(u32, u64), usize>,
}

impl Model {
    fn vertex(&mut self, line: &Line) -> Result<(), Fault> {
        let [x, y] = line.named("v X Y", ["x", "y"])?;
        self.mesh.positions.push(DVec2::new(line.real(x)?, line.real(y)?));
        Ok(())
    }

    fn face(&mut self, line: &Line) -> Result<(), Fault> {
        let before = self.mesh.corners.len();
        for field in line.fields().skip(1) {
            let number = field.text.split('/').next().unwrap_or_default();
            let vertex = number.parse::<u32>().ok().and_then(|n| n.checked_sub(1)).ok_or_else(|| {
                Fault::new(
                    line.place(field.start),
                    format!("{} is not a vertex number", quoted(field.text)),
                    "vertices count from 1 in the order of the `v` lines",
                )
            })?;
            self.mesh.corners.push(vertex);
        }
        let corners = self.mesh.corners.len() - before;
        if corners < 3 {
            let what = format!("a face has at least three corners, this one has {corners}");
            return Err(Fault::new(line.place(0), what, "write `f V1 V2 V3 ...` or remove the line"));
        }
        if self.mesh.face_start.is_empty() {
            self.mesh.face_start.push(0);
        }
        let end = u32::try_from(self.mesh.corners.len())
            .map_err(|_| Fault::new(line.place(0), "the mesh has too many face corners", "split the model"))?;
        self.mesh.face_start.push(end);
        self.mesh.face_line.push(line.number as u32);
        Ok(())
    }

    fn geometry_edit(&mut self, line: &Line) -> Result<(), Fault> {
        let [level, vertex, half_edge, a, b, boundary] = line.named(
            "ve LEVEL VERTEX HALFEDGE A B BOUNDARY",
            ["the level", "the vertex", "the half-edge", "a", "b", "the boundary flag"],
        )?;
        let frame = match boundary.field.text {
            "0" => Frame::Sector,
            "1" => Frame::Boundary,
            other => {
                let what = format!("the boundary flag is {}", quoted(other));
                let fix = "give 0 (along two edges) or 1 (beyond the boundary)";
                return Err(Fault::new(line.place(boundary.field.start), what, fix));
            }
        };
        let vertex = line.whole(vertex)?;
        let edit = GeometryEdit {
            level: line.level(level)?,
            half_edge: line.whole(half_edge)?,
            vertex: Some(vertex),
            a: line.real(a)?,
            b: line.real(b)?,
            frame,
        };
        let next = self.geometry.len();
        match *self.geometry_by_key.entry((edit.level, vertex)).or_insert(next) {
            index if index < next => self.geometry[index] = (edit, line.number),
            _ => self.geometry.push((edit, line.number)),
        }
        Ok(())
    }

    fn colour_edit(&mut self, line: &Line) -> Result<(), Fault> {
        let [level, half_edge, r, g, b] =
            line.named("ce LEVEL HALFEDGE R G B", ["the level", "the half-edge", "red", "green", "blue"])?;
        let edit = ColourEdit {
            level: line.level(level)?,
            half_edge: line.whole(half_edge)?,
            colour: DVec4::new(line.real(r)?, line.real(g)?, line.real(b)?, 1.0),
        };
        let next = self.colours.len();
        match *self.colour_by_key.entry((edit.level, edit.half_edge)).or_insert(next) {
            index if index < next => self.colours[index] = (edit, line.number),
            _ => self.colours.push((edit, line.number)),
        }
        Ok(())
    }

    /// Checks what only the whole file can tell: vertex numbers and half-edge ranges.
    fn finish(self, text: &str) -> Result<Scene, Fault> {
        let mesh = self.mesh;
        if mesh.face_line.is_empty() {
            return Err(Fault::new((1, 1), "the file has no face", "give `v X Y` and `f V1 V2 V3 ...` lines"));
        }
        let vertices = mesh.positions.len();
        if let Some(corner) = mesh.corners.iter().position(|&v| v as usize >= vertices) {
            let face = mesh.face_start.partition_point(|&start| start as usize <= corner) - 1;
            let field = 1 + corner - mesh.face_start[face] as usize;
            let what = format!("vertex {} does not exist", u64::from(mesh.corners[corner]) + 1);
            let fix = format!("there are {vertices} `v` lines, and numbers count from 1");
            return Err(Fault::new(field_place(text, mesh.face_line[face] as usize, field), what, fix));
        }
        let input = HalfEdges::of_input(&mesh);
        for (edit, line) in &self.geometry {
            if let Some((what, fix)) = input.refuse_geometry(edit) {
                return Err(Fault::new(field_place(text, *line, 3), what, fix));
            }
        }
        for (edit, line) in &self.colours {
            if let Some((what, fix)) = input.refuse_colour(edit) {
                return Err(Fault::new(field_place(text, *line, 2), what, fix));
            }
        }
        let edit_lines = EditLines {
            geometry: self.geometry.iter().map(|(_, line)| *line as u32).collect(),
            colours: self.colours.iter().map(|(_, line)| *line as u32).collect(),
        };
        Ok(Scene {
            mesh,
            edit_lines,
            corners: CornerRule::Sharp,
            geometry: self.geometry.into_iter().map(|(edit, _)| edit).collect(),
            colours: self.colours.into_iter().map(|(edit, _)| edit).collect(),
            ..Scene::default()
        })
    }
}

/// Place of field `index` (0 is the first token) of line `number`.
fn field_place(text: &str, number: usize, index: usize) -> (usize, usize) {
    let line = Line { text: text.lines().nth(number - 1).unwrap_or_default(), number };
    let start = line.fields().nth(index).map_or(0, |field| field.start);
    line.place(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0\nv 1 0 7 0.5\r\nv\t1  1\n  v 0 1\ns off\nf 1/4 2//3 3 4 # all\n";

    fn with(lines: &str) -> Result<Scene, Fault> {
        read(format!("{QUAD}{lines}").as_bytes())
    }

    fn fault(lines: &str) -> Fault {
        with(lines).unwrap_err()
    }

    #[test]
    fn blanks_line_ends_and_extra_fields_do_not_matter() {
        let scene = with("ve 0 12 4 0.1 -2e3 0 junk\nce 1 143 1 0 0.5\n\n").unwrap();
        assert_eq!(scene.mesh.positions[3], DVec2::new(0.0, 1.0));
        assert_eq!(scene.mesh.corners, [0, 1, 2, 3]);
        assert_eq!(scene.mesh.face_line, [6]);
        assert_eq!(scene.geometry[0].a, f64::from(0.1f32));
        assert_eq!(scene.colours[0].half_edge, 143);
    }

    #[test]
    fn later_edit_of_the_same_key_replaces_the_earlier() {
        let scene = with("ve 0 5 4 1 1 0\nve 1 5 4 2 2 0\nve 0 5 6 3 3 0\nce 0 9 1 0 0\nce 0 9 0 1 0\n").unwrap();
        assert_eq!(scene.geometry.len(), 2);
        assert_eq!((scene.geometry[0].half_edge, scene.geometry[0].a), (6, 3.0));
        assert_eq!(scene.colours.len(), 1);
        assert_eq!(scene.colours[0].colour.y, 1.0);
    }

    #[test]
    fn faults_name_line_column_and_cure() {
        let cases = [
            ("f 1 2 5", (7, 7), "vertex 5 does not exist"),
            ("f 1 0 3", (7, 5), "\"0\" is not a vertex number"),
            ("f 1 -2 3", (7, 5), "\"-2\" is not a vertex number"),
            ("f 1 2", (7, 1), "three corners"),
            ("v 1", (7, 4), "y is missing"),
            ("v 1 nan", (7, 5), "not a finite"),
            ("v 1 1e39", (7, 5), "not a finite"),
            ("v 1 x", (7, 5), "y \"x\" is not a number"),
            ("ve 21 0 0 1 1 0", (7, 4), "level 21 is too fine"),
            ("ve 0 0 -1 1 1 0", (7, 8), "not a whole number"),
            ("ve 0 0 0 1 1 2", (7, 14), "boundary flag"),
            ("ve 0 0 0 1 1", (7, 13), "the boundary flag is missing"),
            ("ve 0 0 48 1 1 0", (7, 8), "half-edge 48 does not exist at level 0"),
            ("ve 0 0 36 1 1 1", (7, 8), "half-edge 36 does not exist at level 0"),
            ("ce 1 144 1 1 1", (7, 6), "half-edge 144 does not exist at level 1"),
            ("ce 0 0 1 1", (7, 11), "blue is missing"),
        ];
        for (line, place, what) in cases {
            let fault = fault(line);
            assert_eq!((fault.line, fault.column), place, "{line}: {fault:?}");
            assert!(fault.what.contains(what), "{line}: {fault:?}");
            assert!(!fault.fix.is_empty());
        }
    }

    #[test]
    fn surfaces_are_told_apart() {
        for tag in ["fs 0 1 0 1", "as 1", "vn 0 0 1", "t crease 1/1/0 1 2 3"] {
            assert!(fault(tag).what.contains("technique surface"), "{tag}");
        }
        assert!(with("vn 0 0 1\nce 0 0 1 1 1").is_ok());
        assert!(with("t cloth").is_ok());
    }

    #[test]
    fn a_model_needs_a_face() {
        assert!(read(b"v 0 0\n").unwrap_err().what.contains("no face"));
    }
}
