//! Reader of OBJ surfaces.

use super::sharp::Lists;
use super::{Crease, SurfaceScene};
use crate::scene::error::{quoted, Fault};
use crate::scene::CornerRule;
use glam::DVec3;

/// One field of a line and its column, from 1.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    pub text: &'a str,
    pub place: (usize, usize),
}

/// The fields of a line between blanks, up to a comment.
pub(super) fn fields(line: &str, number: usize) -> impl Iterator<Item = Field<'_>> {
    line.split_ascii_whitespace().take_while(|text| !text.starts_with('#')).map(move |text| {
        let byte = text.as_ptr() as usize - line.as_ptr() as usize;
        Field { text, place: (number, line[..byte].chars().count() + 1) }
    })
}

/// A finite number.
pub(super) fn real(field: Field, what: &str) -> Result<f64, Fault> {
    match field.text.parse::<f64>() {
        // Far below what sums of squares overflow at, far above any model.
        Ok(x) if x.abs() <= 1e30 => Ok(x),
        Ok(_) => {
            let what = format!("{what} {} is not a number of moderate size", quoted(field.text));
            Err(Fault::new(field.place, what, "give one between -1e30 and 1e30"))
        }
        Err(_) => {
            let what = format!("{what} {} is not a number", quoted(field.text));
            Err(Fault::new(field.place, what, "give a decimal number such as 0.5"))
        }
    }
}

/// A sharpness: 0 or more, `inf` allowed.
pub(super) fn sharpness(field: Field) -> Result<f64, Fault> {
    match field.text.parse::<f64>() {
        Ok(s) if s >= 0.0 => Ok(s),
        Ok(_) => {
            let what = format!("sharpness {} is below 0", quoted(field.text));
            Err(Fault::new(field.place, what, "give 0 (smooth), a number above it, or inf"))
        }
        Err(_) => {
            let what = format!("sharpness {} is not a number", quoted(field.text));
            Err(Fault::new(field.place, what, "give 0 (smooth), a number above it, or inf; comments start with #"))
        }
    }
}

/// Reads a whole surface.
pub(super) fn read(bytes: &[u8]) -> Result<SurfaceScene, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader::default();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let mut rest = fields(line, number);
        let Some(first) = rest.next() else { continue };
        let rest: Vec<Field> = rest.collect();
        match first.text {
            "v" => {
                let p = triple(first, &rest, "v X Y Z")?;
                reader.scene.positions.push(p);
                reader.scene.vertex_line.push(number as u32);
            }
            "vn" => reader.normals.push(triple(first, &rest, "vn X Y Z")?),
            "f" => reader.face(first, &rest)?,
            "fs" | "as" => reader.lists.line(first, &rest)?,
            "OFF" => reader.zero_based = rest.first().is_some_and(|f| f.text == "0"),
            "t" => reader.tag(&rest)?,
            _ => {}
        }
    }
    reader.finish(&text)
}

fn triple(first: Field, rest: &[Field], form: &str) -> Result<DVec3, Fault> {
    let [x, y, z, ..] = rest else {
        let what = format!("{} of three numbers is missing", ["x", "y", "z"][rest.len()]);
        return Err(Fault::new(rest.last().unwrap_or(&first).place, what, format!("write `{form}`")));
    };
    Ok(DVec3::new(real(*x, "x")?, real(*y, "y")?, real(*z, "z")?))
}

#[derive(Default)]
struct Reader {
    scene: SurfaceScene,
    normals: Vec<DVec3>,
    /// Number of the normal at each corner, from 1; 0: none. With its place for messages.
    corner_normal: Vec<i64>,
    lists: Lists,
    zero_based: bool,
    corners: Vec<(i64, f64, (usize, usize))>,
    creases: Vec<([i64; 2], f64, (usize, usize))>,
}

impl Reader {
    fn face(&mut self, first: Field, rest: &[Field]) -> Result<(), Fault> {
        if rest.len() < 3 {
            let what = format!("a face has at least three corners, this one has {}", rest.len());
            return Err(Fault::new(first.place, what, "write `f V1 V2 V3 ...` or remove the line"));
        }
        let scene = &mut self.scene;
        if scene.face_start.is_empty() {
            scene.face_start.push(0);
        }
        for field in rest {
            let mut parts = field.text.split('/');
            let number = parts.next().unwrap_or_default();
            let wrong = || {
                let what = format!("{} is not a vertex number", quoted(field.text));
                let fix = "vertices count from 1 in the order of the `v` lines, or back from -1";
                Fault::new(field.place, what, fix)
            };
            let n: i64 = number.parse().map_err(|_| wrong())?;
            // From 0; a vertex that comes later in the file is allowed and checked at the end.
            let n = match n {
                n if n < 0 => scene.positions.len() as i64 + n,
                n if self.zero_based => n,
                n => n - 1,
            };
            scene.corners.push(u32::try_from(n).map_err(|_| wrong())?);
            let normal = match parts.nth(1).filter(|text| !text.is_empty()).map(str::parse::<i64>) {
                Some(Ok(n)) if n < 0 => self.normals.len() as i64 + n + 1,
                Some(Ok(n)) => n + i64::from(self.zero_based),
                _ => 0,
            };
            self.corner_normal.push(normal);
        }
        let end = u32::try_from(scene.corners.len())
            .map_err(|_| Fault::new(first.place, "the mesh has too many face corners", "split the model"))?;
        scene.face_start.push(end);
        scene.face_line.push(first.place.0 as u32);
        Ok(())
    }

    /// `t NAME INTS/FLOATS/STRINGS ...`, vertices from 0, as in the shapes of OpenSubdiv.
    fn tag(&mut self, rest: &[Field]) -> Result<(), Fault> {
        let [name, counts, values @ ..] = rest else { return Ok(()) };
        if !matches!(name.text, "crease" | "corner" | "interpolateboundary") {
            return Ok(());
        }
        let wrong = |what: String| {
            let fix = "write `t crease 2/1/0 V1 V2 S` or `t corner 1/1/0 V S`, vertices from 0";
            Err(Fault::new(counts.place, what, fix))
        };
        let mut sizes = counts.text.split('/').map(str::parse::<usize>);
        let (Some(Ok(ints)), Some(Ok(floats))) = (sizes.next(), sizes.next()) else {
            return wrong(format!("{} are not the numbers of integers, reals and words", quoted(counts.text)));
        };
        if ints.checked_add(floats).is_none_or(|n| n > values.len()) {
            return wrong(format!("the tag announces {ints} integers and {floats} reals and has {}", values.len()));
        }
        let whole = |f: &Field| {
            f.text.parse::<i64>().map_err(|_| {
                let what = format!("{} is not a whole number", quoted(f.text));
                Fault::new(f.place, what, "vertices of tags count from 0")
            })
        };
        let at: Vec<i64> = values[..ints].iter().map(whole).collect::<Result<_, _>>()?;
        if name.text == "interpolateboundary" {
            self.scene.boundary_corners = match at.first() {
                Some(1) => Some(CornerRule::Sharp),
                Some(2) => Some(CornerRule::Smooth),
                _ => None,
            };
            return Ok(());
        }
        let values = &values[ints..ints + floats];
        let (things, least) = if name.text == "crease" { (ints.saturating_sub(1), 2) } else { (ints, 1) };
        if ints < least || floats == 0 || (floats != 1 && floats != things) {
            return wrong(format!("a {} of {ints} vertices cannot have {floats} numbers", name.text));
        }
        for i in 0..things {
            let s = sharpness(values[if floats == 1 { 0 } else { i }])?;
            if name.text == "crease" {
                self.creases.push(([at[i], at[i + 1]], s, name.place));
            } else {
                self.corners.push((at[i], s, name.place));
            }
        }
        Ok(())
    }

    /// Checks what only the whole file can tell.
    fn finish(mut self, text: &str) -> Result<SurfaceScene, Fault> {
        let scene = &mut self.scene;
        let vertices = scene.positions.len();
        if scene.face_line.is_empty() {
            return Err(Fault::new((1, 1), "the file has no face", "give `v X Y Z` and `f V1 V2 V3 ...` lines"));
        }
        if let Some(corner) = scene.corners.iter().position(|&v| v as usize >= vertices) {
            let face = scene.face_start.partition_point(|&start| start as usize <= corner) - 1;
            let number = scene.face_line[face] as usize;
            let line = text.lines().nth(number - 1).unwrap_or_default();
            let index = 1 + corner - scene.face_start[face] as usize;
            let place = fields(line, number).nth(index).map_or((number, 1), |f| f.place);
            let what = format!("vertex {} does not exist", u64::from(scene.corners[corner]) + 1);
            return Err(Fault::new(place, what, format!("there are {vertices} `v` lines, and numbers count from 1")));
        }
        scene.edge_sharpness = self.lists.resolve(&scene.face_start, &mut scene.notes);
        let vertex = |v: i64, place| match u32::try_from(v) {
            Ok(v) if (v as usize) < vertices => Ok(v),
            _ => {
                let fix = format!("there are {vertices}, and vertices of tags count from 0");
                Err(Fault::new(place, format!("vertex {v} of the tag does not exist"), fix))
            }
        };
        for (ends, sharpness, place) in self.creases {
            let ends = [vertex(ends[0], place)?, vertex(ends[1], place)?];
            scene.creases.push(Crease { ends, sharpness, line: place.0 as u32 });
        }
        for (v, sharpness, place) in self.corners {
            scene.corner_sharpness.resize(vertices, 0.0);
            scene.corner_sharpness[vertex(v, place)? as usize] = sharpness;
        }
        if self.corner_normal.iter().any(|&n| n != 0) {
            let given = self.normals;
            let at = |&n: &i64| usize::try_from(n - 1).ok().and_then(|n| given.get(n)).copied().unwrap_or_default();
            scene.normals = self.corner_normal.iter().map(at).collect();
        }
        Ok(self.scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\n";

    #[test]
    fn digits_start_at_the_edge_that_ends_in_the_last_vertex() {
        // The i-th entry belongs to the half-edge that ends in corner i - 1.
        let scene = read(format!("{QUAD}fs 1 2 3.5 inf # words\r\nf 1 2 3 4\n").as_bytes()).unwrap();
        assert_eq!(scene.edge_sharpness, [2.0, 3.5, f64::INFINITY, 1.0]);
        assert!(scene.notes.is_empty());
    }

    #[test]
    fn relative_numbers_normals_and_tags() {
        let text = "vn 0 0 1\nf -4//-1 -3//1 -2 -1\nt crease 3/2/0 0 1 2 0.5 7\nt corner 1/1/0 3 2\nt interpolateboundary 1/0/0 1\n";
        let scene = read(format!("{QUAD}{text}").as_bytes()).unwrap();
        assert_eq!(scene.corners, [0, 1, 2, 3]);
        assert_eq!((scene.normals[0], scene.normals[1], scene.normals[2]), (DVec3::Z, DVec3::Z, DVec3::ZERO));
        assert_eq!(scene.creases[1], Crease { ends: [1, 2], sharpness: 7.0, line: 7 });
        assert_eq!(scene.corner_sharpness, [0.0, 0.0, 0.0, 2.0]);
        assert_eq!(scene.boundary_corners, Some(CornerRule::Sharp));
    }

    #[test]
    fn faults_name_line_column_and_cure() {
        let cases = [
            ("f 1 2 5", (5, 7), "vertex 5 does not exist"),
            ("f 1 0 3", (5, 5), "\"0\" is not a vertex number"),
            ("f 1 -9 3", (5, 5), "\"-9\" is not a vertex number"),
            ("f 1 2", (5, 1), "three corners"),
            ("v 1 2", (5, 5), "z of three numbers"),
            ("v 1 2 nan", (5, 7), "moderate size"),
            ("v 1 2 x", (5, 7), "is not a number"),
            ("fs 1 -1 0", (5, 6), "below 0"),
            ("fs 1 ear 0", (5, 6), "sharpness \"ear\" is not a number"),
            ("as x 1", (5, 4), "not a number of faces"),
            ("t crease 2/1/0 0 1", (5, 10), "announces"),
            ("f 1 2 3\nt crease 2/1/0 0 9 1", (6, 3), "vertex 9 of the tag"),
            ("t corner 1/2/0 0 1 1", (5, 10), "cannot have 2 numbers"),
            ("", (1, 1), "no face"),
        ];
        for (line, place, what) in cases {
            let fault = read(format!("{QUAD}{line}\n").as_bytes()).unwrap_err();
            assert_eq!((fault.line, fault.column), place, "{line}: {fault:?}");
            assert!(fault.what.contains(what), "{line}: {fault:?}");
        }
    }
}
