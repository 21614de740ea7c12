//! Reader of the native format: makes a scene of a document, and checks what needs more than one value.

use super::document::{head_fault, parse, Colour, Coloured, Corners, Document, FrameName, Geometry, Point};
use crate::scene::error::Fault;
use crate::scene::json_position::{element_lines, line_column, place, Step};
use crate::scene::numbering::{ends, HalfEdges, FINEST_LEVEL};
use crate::scene::{
    shapes, ColourEdit, CornerRule, EditLines, Frame, GeometryEdit, Handle, InputMesh, Reference, Scene,
};
use glam::{DVec2, DVec4};
use std::collections::HashSet;
use Step::{Index, Key};

/// Reads a whole scene.
pub(in crate::scene) fn read(bytes: &[u8]) -> Result<Scene, Fault> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        Fault::new(line_column(&valid, valid.len()), "this is not UTF-8", "save the scene as UTF-8")
    })?;
    let document = parse(text)?;
    Check { text, document: &document }.scene()
}

/// The checks that need more than one value; each names the value at fault by its path.
struct Check<'a> {
    text: &'a str,
    document: &'a Document,
}

impl Check<'_> {
    fn scene(&self) -> Result<Scene, Fault> {
        let document = self.document;
        if let Some(fault) = head_fault(self.text, &document.gradtess.into(), document.technique.as_deref()) {
            return Err(fault);
        }
        let mesh = self.mesh()?;
        let input = HalfEdges::of_input(&mesh);
        let scene = Scene {
            name: document.name.clone(),
            corners: match document.corners {
                Corners::Sharp => CornerRule::Sharp,
                Corners::Smooth => CornerRule::Smooth,
            },
            corner_colours: self.corner_colours(&mesh)?,
            sharp: self.sharp(input)?,
            handles: self.points("handles", &document.handles, input.interior + input.boundary)?,
            face_points: self.points("face_points", &document.face_points, input.interior)?,
            geometry: self.geometry(input)?,
            colours: self.colours(input)?,
            reference: self.reference()?,
            edit_lines: EditLines {
                geometry: element_lines(self.text, &[Key("geometry")]),
                colours: element_lines(self.text, &[Key("colour")]),
            },
            mesh,
        };
        Ok(scene)
    }

    fn fault(&self, path: &[Step], what: impl std::fmt::Display, fix: impl std::fmt::Display) -> Fault {
        Fault::new(place(self.text, path), what, fix)
    }

    fn mesh(&self) -> Result<InputMesh, Fault> {
        match (&self.document.builtin, &self.document.vertices, &self.document.faces) {
            (Some(name), None, None) => {
                shapes::builtin(name).map_err(|(what, fix)| self.fault(&[Key("builtin")], what, fix))
            }
            (None, Some(vertices), Some(faces)) => self.listed(vertices, faces),
            (Some(_), _, _) => {
                let fix = "remove \"builtin\", or \"vertices\" and \"faces\"";
                Err(self.fault(&[Key("builtin")], "a built-in mesh brings its own vertices and faces", fix))
            }
            (None, vertices, _) => {
                let missing = if vertices.is_none() { "vertices" } else { "faces" };
                let fix = "give \"vertices\" and \"faces\", or \"builtin\"";
                Err(self.fault(&[], format!("the scene has no \"{missing}\""), fix))
            }
        }
    }

    fn listed(&self, vertices: &[[f64; 2]], faces: &[Vec<u32>]) -> Result<InputMesh, Fault> {
        if faces.is_empty() {
            return Err(self.fault(&[Key("faces")], "the scene has no face", "list at least one face"));
        }
        let mut mesh = InputMesh {
            positions: vertices.iter().map(|&at| DVec2::from(at)).collect(),
            face_start: vec![0],
            face_line: element_lines(self.text, &[Key("faces")]),
            ..InputMesh::default()
        };
        for (f, face) in faces.iter().enumerate() {
            let path = [Key("faces"), Index(f)];
            if face.len() < 3 {
                let what = format!("a face has at least three corners, this one has {}", face.len());
                return Err(self.fault(&path, what, "list its vertex numbers"));
            }
            if let Some(k) = face.iter().position(|&v| v as usize >= vertices.len()) {
                let what = format!("vertex {} does not exist", face[k]);
                let fix = format!("there are {} vertices, and numbers count from 0", vertices.len());
                return Err(self.fault(&[path[0], path[1], Index(k)], what, fix));
            }
            mesh.corners.extend_from_slice(face);
            let end = u32::try_from(mesh.corners.len())
                .map_err(|_| self.fault(&path, "the mesh has too many face corners", "split the scene"))?;
            mesh.face_start.push(end);
        }
        Ok(mesh)
    }

    fn corner_colours(&self, mesh: &InputMesh) -> Result<Vec<DVec4>, Fault> {
        let (key, colours, wanted, whose) = match (&self.document.vertex_colours, &self.document.corner_colours) {
            (None, None) => return Ok(Vec::new()),
            (Some(_), Some(_)) => {
                let what = "colours are given per vertex and per corner";
                return Err(self.fault(&[Key("vertex_colours")], what, "keep one of the two lists"));
            }
            (Some(colours), None) => ("vertex_colours", colours, mesh.positions.len(), "vertices"),
            (None, Some(colours)) => ("corner_colours", colours, mesh.corners.len(), "half-edges"),
        };
        if colours.len() != wanted {
            let what = format!("there are {} colours for {wanted} {whose}", colours.len());
            return Err(self.fault(&[Key(key)], what, format!("give {wanted} colours")));
        }
        for (index, colour) in colours.iter().enumerate() {
            self.alpha(colour, &[Key(key), Index(index), Index(3)])?;
        }
        if key == "corner_colours" {
            return Ok(colours.iter().map(|colour| colour.0).collect());
        }
        Ok(ends(mesh).iter().map(|&(origin, _)| colours[origin as usize].0).collect())
    }

    fn alpha(&self, colour: &Colour, path: &[Step]) -> Result<(), Fault> {
        if (0.0..=1.0).contains(&colour.0.w) {
            return Ok(());
        }
        Err(self.fault(path, format!("alpha {} is out of range", colour.0.w), "give 0 (clear) to 1 (opaque)"))
    }

    fn sharp(&self, input: HalfEdges) -> Result<Vec<u32>, Fault> {
        for (index, &h) in self.document.sharp.iter().enumerate() {
            self.half_edge(h, input.interior, &[Key("sharp"), Index(index)])?;
        }
        Ok(self.document.sharp.clone())
    }

    fn half_edge(&self, h: u32, end: u64, path: &[Step]) -> Result<(), Fault> {
        if u64::from(h) < end {
            return Ok(());
        }
        let what = format!("half-edge {h} does not exist in the input mesh");
        Err(self.fault(path, what, format!("give a number from 0 to {}", end - 1)))
    }

    fn points(&self, key: &str, points: &[Point], end: u64) -> Result<Vec<Handle>, Fault> {
        let mut seen = HashSet::new();
        for (index, point) in points.iter().enumerate() {
            let path = [Key(key), Index(index), Key("half_edge")];
            self.half_edge(point.half_edge, end, &path)?;
            self.once(seen.insert(point.half_edge), &path)?;
        }
        Ok(points.iter().map(|point| Handle { half_edge: point.half_edge, at: point.at.into() }).collect())
    }

    fn reference(&self) -> Result<Option<Reference>, Fault> {
        let Some(reference) = &self.document.reference else { return Ok(None) };
        let [x0, y0, x1, y1] = reference.rect;
        if !(x1 > x0 && y1 > y0) {
            let fix = "give x0, y0, x1, y1 with x0 < x1 and y0 < y1";
            return Err(self.fault(&[Key("reference"), Key("rect")], "the rectangle is empty", fix));
        }
        if !(0.0..=1.0).contains(&reference.opacity) {
            let what = format!("opacity {} is out of range", reference.opacity);
            return Err(self.fault(&[Key("reference"), Key("opacity")], what, "give 0 (hidden) to 1"));
        }
        Ok(Some(reference.clone()))
    }

    fn once(&self, new: bool, path: &[Step]) -> Result<(), Fault> {
        if new {
            return Ok(());
        }
        Err(self.fault(path, "this place is given twice", "keep one of the two entries"))
    }

    fn level(&self, level: u32, key: &str, index: usize) -> Result<(), Fault> {
        if level <= FINEST_LEVEL {
            return Ok(());
        }
        let path = [Key(key), Index(index), Key("level")];
        Err(self.fault(&path, format!("level {level} is too fine"), format!("levels go from 0 to {FINEST_LEVEL}")))
    }

    fn geometry(&self, input: HalfEdges) -> Result<Vec<GeometryEdit>, Fault> {
        let (mut vertices, mut half_edges) = (HashSet::new(), HashSet::new());
        let mut edits = Vec::with_capacity(self.document.geometry.len());
        for (index, given) in self.document.geometry.iter().enumerate() {
            let frame = match given.frame {
                FrameName::Sector => Frame::Sector,
                FrameName::Boundary => Frame::Boundary,
            };
            let &Geometry { level, half_edge, vertex, a, b, .. } = given;
            let edit = GeometryEdit { level, half_edge, vertex, a, b, frame };
            let path = |key| [Key("geometry"), Index(index), Key(key)];
            self.level(level, "geometry", index)?;
            if let Some((what, fix)) = input.refuse_geometry(&edit) {
                return Err(self.fault(&path("half_edge"), what, fix));
            }
            // The vertex is the key where it is given, as in the authors' format: there two half-edges of one vertex
            // clash, and one half-edge under two keys does not.
            match vertex {
                Some(vertex) => self.once(vertices.insert((level, vertex)), &path("vertex"))?,
                None => self.once(half_edges.insert((level, half_edge, given.frame)), &path("half_edge"))?,
            }
            edits.push(edit);
        }
        Ok(edits)
    }

    fn colours(&self, input: HalfEdges) -> Result<Vec<ColourEdit>, Fault> {
        let mut seen = HashSet::new();
        let mut edits = Vec::with_capacity(self.document.colour.len());
        for (index, &Coloured { level, half_edge, colour }) in self.document.colour.iter().enumerate() {
            let edit = ColourEdit { level, half_edge, colour: colour.0 };
            let path = [Key("colour"), Index(index), Key("half_edge")];
            self.level(level, "colour", index)?;
            if let Some((what, fix)) = input.refuse_colour(&edit) {
                return Err(self.fault(&path, what, fix));
            }
            self.alpha(&colour, &[Key("colour"), Index(index), Key("colour"), Index(3)])?;
            self.once(seen.insert((level, half_edge)), &path)?;
            edits.push(edit);
        }
        Ok(edits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(members: &str) -> Result<Scene, Fault> {
        read(format!("{{\"gradtess\": 1, \"builtin\": \"quad\"{members}}}").as_bytes())
    }

    #[test]
    fn vertex_colours_go_to_the_corner_at_the_origin() {
        let scene = quad(", \"vertex_colours\": [[0,0,0],[0.1,0,0],[0.2,0,0],[0.3,0,0,0.5]]").unwrap();
        // Half-edge 0 comes from the last vertex.
        let reds: Vec<f64> = scene.corner_colours.iter().map(|colour| colour.x).collect();
        assert_eq!(reds, [0.3, 0.0, 0.1, 0.2]);
        assert_eq!(scene.corner_colours[0].w, 0.5);
        assert_eq!(scene.corner_colours[1].w, 1.0);
    }

    #[test]
    fn everything_has_a_default() {
        let scene = quad("").unwrap();
        assert_eq!(scene.corners, CornerRule::Sharp);
        assert!(scene.corner_colours.is_empty() && scene.name.is_empty());
        let scene = quad(", \"geometry\": [{\"level\": 0, \"half_edge\": 1, \"a\": 0.5, \"b\": 0}]").unwrap();
        assert_eq!((scene.geometry[0].frame, scene.geometry[0].vertex), (Frame::Sector, None));
    }

    #[test]
    fn faults_deep_in_the_document_have_their_place() {
        let cases = [
            (",\n \"sharp\": [0,\n 4]", (3, 2), "half-edge 4 does not exist in the input mesh"),
            (",\n\"colour\": [{\"level\": 0, \"half_edge\": 36, \"colour\": [0,0,0]}]", (2, 38), "half-edge 36"),
            (",\n\"colour\": [{\"level\": 0, \"half_edge\": 3, \"colour\": [0,0,0,2]}]", (2, 58), "alpha 2"),
            (",\n\"colour\": [{\"level\": 21, \"half_edge\": 3, \"colour\": [0,0,0]}]", (2, 22), "level 21"),
            (",\n\"handles\": [{\"half_edge\": 8, \"at\": [0,0]}]", (2, 27), "half-edge 8"),
            (",\n\"face_points\": [{\"half_edge\": 4, \"at\": [0,0]}]", (2, 31), "half-edge 4"),
            (",\n\"vertex_colours\": [[0,0,0]]", (2, 19), "1 colours for 4 vertices"),
            (",\n\"corner_colours\": []", (2, 19), "0 colours for 4 half-edges"),
            (",\n\"vertices\": []", (1, 28), "built-in mesh brings its own"),
            (",\n\"nmae\": \"x\"", (2, 6), "unknown field `nmae`"),
            (",\n\"name\": 3", (2, 9), "invalid type"),
            (",\n\"technique\": \"ferguson\", \"knots\": 1", (2, 14), "technique \"ferguson\" is not available"),
            (",\n\"name\": \"a\" \"b\"", (2, 13), "expected"),
        ];
        for (members, place, what) in cases {
            let fault = quad(members).unwrap_err();
            assert!(fault.what.contains(what), "{members}: {fault:?}");
            assert_eq!((fault.line, fault.column), place, "{members}: {fault:?}");
        }
    }

    #[test]
    fn listed_meshes_are_checked() {
        let cases = [
            ("\"vertices\": [[0,0],[1,0],[0,1]], \"faces\": [[0,1,2],\n[0,1]]", (2, 1), "three corners"),
            ("\"vertices\": [[0,0],[1,0],[0,1]], \"faces\": [\n[0,1,3]]", (2, 6), "vertex 3 does not exist"),
            ("\"vertices\": [], \"faces\": []", (1, 42), "no face"),
            ("\"vertices\": [[0,0]]", (1, 1), "no \"faces\""),
            ("\"faces\": [[0,0,0]]", (1, 1), "no \"vertices\""),
        ];
        for (members, place, what) in cases {
            let fault = read(format!("{{\"gradtess\": 1, {members}}}").as_bytes()).unwrap_err();
            assert!(fault.what.contains(what), "{members}: {fault:?}");
            assert_eq!((fault.line, fault.column), place, "{members}: {fault:?}");
        }
    }

    #[test]
    fn other_versions_are_named_before_their_unknown_keys() {
        for text in ["{\"gradtess\": 2}", "{\"new\": {}, \"gradtess\": 2, \"faces\": 7}", "{\"gradtess\": \"1\"}"] {
            assert!(read(text.as_bytes()).unwrap_err().what.contains("version"), "{text}");
        }
        assert!(read(b"{\"builtin\": \"quad\"}").unwrap_err().what.contains("missing field `gradtess`"));
    }

    #[test]
    fn the_same_place_twice_is_a_fault() {
        let twice = |key: &str, entry: &str| quad(&format!(", \"{key}\": [{entry}, {entry}]")).unwrap_err().what;
        assert!(twice("handles", "{\"half_edge\": 1, \"at\": [0, 0]}").contains("twice"));
        assert!(twice("colour", "{\"level\": 1, \"half_edge\": 1, \"colour\": [0, 0, 0]}").contains("twice"));
        assert!(twice("geometry", "{\"level\": 1, \"half_edge\": 1, \"a\": 0, \"b\": 0}").contains("twice"));
    }
}
