//! Reader of the JSON form.

use super::document::{DisplacementEntry, Document, EvaluatorEntry, FieldEntry};
use super::{complete, fan, height, obj, PatternScene, LEVEL};
use crate::pattern::displace::{HeightMap, Noise, Sine};
use crate::pattern::{lattice::MAX_LEVEL, Displacement, Evaluator, NormalField, PatternError, Tag};
use crate::scene::error::{quoted, Fault};
use crate::scene::json_document::document;
use crate::scene::json_position::{element_lines, place, Step};
use crate::scene::{read_bounded, SceneError};
use glam::{DVec2, DVec3, DVec4};
use std::path::Path;
use Step::{Index, Key};

/// Largest coordinate: single precision squares it.
const LARGEST: f64 = 1e9;

/// Reads a whole scene; `folder` is where it stands.
pub(super) fn read(bytes: &[u8], file: &str, folder: &Path) -> Result<PatternScene, SceneError> {
    let (text, document) = document::<Document>(bytes, |d| d.gradtess).map_err(|fault| fault.in_file(file))?;
    let reader = Reader { text, d: &document };
    let mut scene = PatternScene { name: document.name.clone(), level: LEVEL, ..PatternScene::default() };
    let mut lines = Vec::new();
    match &document.mesh {
        Some(name) => {
            let path = folder.join(name);
            let shown = path.display().to_string();
            let raw = obj::read(&read_bounded(&path)?).map_err(|fault| fault.in_file(&shown))?;
            raw.into_scene(&mut scene);
        }
        None => lines = reader.mesh(&mut scene).map_err(|fault| fault.in_file(file))?,
    }
    let rest = |scene: &mut PatternScene| {
        reader.settings(scene)?;
        reader.tags(scene)?;
        scene.evaluator = match document.evaluator {
            Some(EvaluatorEntry::Linear) => Evaluator::Linear,
            Some(EvaluatorEntry::St) => Evaluator::St,
            None if !scene.mesh.tags.is_empty() => Evaluator::St,
            Some(EvaluatorEntry::Pn) | None => Evaluator::Pn,
        };
        let fallback = place(text, &[Key(if document.mesh.is_some() { "mesh" } else { "faces" })]).0 as u32;
        complete(scene, |t| (lines.get(t as usize).copied().unwrap_or(fallback) as usize, 1))
    };
    rest(&mut scene).map_err(|fault| fault.in_file(file))?;
    scene.displacement = reader.displacement(file, folder)?;
    Ok(scene)
}

struct Reader<'a> {
    text: &'a str,
    d: &'a Document,
}

impl Reader<'_> {
    fn fault(&self, path: &[Step], what: impl std::fmt::Display, fix: impl std::fmt::Display) -> Fault {
        Fault::new(place(self.text, path), what, fix)
    }

    /// The mesh that stands in the scene; the line of each triangle.
    fn mesh(&self, scene: &mut PatternScene) -> Result<Vec<u32>, Fault> {
        let d = self.d;
        if d.faces.is_empty() {
            return Err(self.fault(
                &[Key("faces")],
                "the scene has no face",
                "give \"faces\", or \"mesh\": \"FILE.obj\"",
            ));
        }
        let moderate = |all: &[f64]| all.iter().all(|x| x.abs() <= LARGEST);
        let lists: [(&str, usize, Option<usize>); 4] = [
            ("positions", d.positions.len(), d.positions.iter().position(|p| !moderate(p))),
            ("normals", d.normals.len(), d.normals.iter().position(|p| !moderate(p))),
            ("uv", d.uv.len(), d.uv.iter().position(|p| !moderate(p))),
            ("colours", d.colours.len(), d.colours.iter().position(|c| !matches!(c.len(), 3 | 4) || !moderate(c))),
        ];
        for (key, count, wrong) in lists {
            if let Some(i) = wrong {
                let what = format!("this entry of {key} cannot be used");
                return Err(self.fault(
                    &[Key(key), Index(i)],
                    what,
                    "give moderate numbers; a colour has three or four",
                ));
            }
            if count != 0 && count != d.positions.len() {
                let what = format!("there are {count} {key} for {} positions", d.positions.len());
                return Err(self.fault(&[Key(key)], what, "give one for each position, or leave them out"));
            }
        }
        let mesh = &mut scene.mesh;
        mesh.positions = d.positions.iter().copied().map(DVec3::from).collect();
        mesh.normals = d.normals.iter().copied().map(DVec3::from).collect();
        mesh.uv = d.uv.iter().copied().map(DVec2::from).collect();
        let colour = |c: &Vec<f64>| DVec4::new(c[0], c[1], c[2], c.get(3).copied().unwrap_or(1.0));
        mesh.colours = d.colours.iter().map(colour).collect();
        let face_lines = element_lines(self.text, &[Key("faces")]);
        let (mut lines, mut polygons) = (Vec::new(), 0);
        for (f, face) in d.faces.iter().enumerate() {
            if face.len() < 3 {
                let what = format!("a face has at least three corners, this one has {}", face.len());
                return Err(self.fault(&[Key("faces"), Index(f)], what, "list three or more vertices, or remove it"));
            }
            if let Some(k) = face.iter().position(|&v| v as usize >= d.positions.len()) {
                let fix = format!("there are {}, and numbers count from 0", d.positions.len());
                let what = format!("vertex {} does not exist", face[k]);
                return Err(self.fault(&[Key("faces"), Index(f), Index(k)], what, fix));
            }
            polygons += usize::from(face.len() > 3);
            fan(face, |t| {
                mesh.triangles.push(t);
                lines.push(face_lines.get(f).copied().unwrap_or(1));
            });
        }
        if polygons > 0 {
            scene.notes.push(format!("{polygons} polygons were cut into triangles"));
        }
        Ok(lines)
    }

    fn settings(&self, scene: &mut PatternScene) -> Result<(), Fault> {
        if let Some(level) = self.d.level {
            if !(1..=MAX_LEVEL).contains(&level) {
                return Err(self.fault(&[Key("level")], format!("level {level} is out of range"), "give 1 to 128"));
            }
            scene.level = level;
        }
        scene.normal_field = match self.d.normal_field {
            None | Some(FieldEntry::Vlachos) => NormalField::Vlachos,
            Some(FieldEntry::Boubekeur) => NormalField::Boubekeur,
            Some(FieldEntry::Linear) => NormalField::Linear,
        };
        Ok(())
    }

    fn tags(&self, scene: &mut PatternScene) -> Result<(), Fault> {
        let vertices = scene.mesh.positions.len();
        let mut seen = vec![false; vertices];
        for (i, entry) in self.d.tags.iter().enumerate() {
            let path = [Key("tags"), Index(i)];
            let v = entry.vertex as usize;
            if v >= vertices {
                let what = format!("vertex {v} does not exist");
                return Err(self.fault(&path, what, format!("there are {vertices}, and numbers count from 0")));
            }
            let two = PatternError::TwoCreases { vertex: entry.vertex };
            let tag = Tag {
                tension: entry.tension,
                sharpness: entry.sharpness,
                bias: entry.bias,
                deviation: DVec3::from(entry.deviation),
            };
            let wrong = if std::mem::replace(&mut seen[v], true) { Err(two) } else { tag.check(entry.vertex) };
            wrong.map_err(|e| {
                let text = e.to_string();
                let (what, fix) = text.split_once("; ").unwrap_or((&text, "correct the tag"));
                self.fault(&path, what, fix)
            })?;
            scene.mesh.tags.resize(vertices, Tag::NEUTRAL);
            scene.mesh.tags[v] = tag;
        }
        Ok(())
    }

    fn displacement(&self, file: &str, folder: &Path) -> Result<Displacement, SceneError> {
        let Some(entry) = &self.d.displacement else { return Ok(Displacement::None) };
        let path = [Key("displacement")];
        let wrong = |what: &str, fix: &str| Err(self.fault(&path, what, fix).in_file(file));
        let moderate = |all: &[f64]| all.iter().all(|x| x.abs() <= 1e6);
        match entry {
            DisplacementEntry::Sine { amplitude, frequency } => {
                if !moderate(&[*amplitude, *frequency]) {
                    return wrong("amplitude or frequency is too large", "give numbers up to a million");
                }
                Ok(Displacement::Sine(Sine { amplitude: *amplitude, frequency: *frequency }))
            }
            DisplacementEntry::Noise { amplitude, frequency, octaves, gain, lacunarity, speed, time, seed } => {
                let base = Noise::default();
                let noise = Noise {
                    amplitude: *amplitude,
                    frequency: *frequency,
                    octaves: octaves.unwrap_or(base.octaves),
                    gain: gain.unwrap_or(base.gain),
                    lacunarity: lacunarity.unwrap_or(base.lacunarity),
                    speed: speed.unwrap_or(base.speed),
                    time: time.unwrap_or(base.time),
                    seed: seed.unwrap_or(base.seed),
                };
                if !(1..=16).contains(&noise.octaves) {
                    return wrong("octaves are out of range", "give 1 to 16");
                }
                if !moderate(&[noise.amplitude, noise.frequency, noise.speed, noise.time])
                    || !(0.0..=4.0).contains(&noise.gain)
                    || !(0.0..=4.0).contains(&noise.lacunarity)
                {
                    return wrong("a number of the noise is out of range", "gain and lacunarity go from 0 to 4");
                }
                Ok(Displacement::Noise(noise))
            }
            DisplacementEntry::Height { amplitude, file: name, middle } => {
                if !moderate(&[*amplitude, *middle]) {
                    return wrong("amplitude or middle is too large", "give numbers up to a million");
                }
                let bytes = read_bounded(&folder.join(name)).map_err(|e| {
                    let what = format!("the height map {} cannot be read ({e})", quoted(name));
                    self.fault(&path, what.replace("; ", ", "), "give the path of a PNG relative to the scene")
                        .in_file(file)
                })?;
                let (size, heights) = height::read(&bytes).map_err(|e| {
                    let what = format!("the height map {} is no PNG that can be used: {e}", quoted(name));
                    self.fault(&path, what, "give a PNG of 8 or 16 bits a channel").in_file(file)
                })?;
                Ok(Displacement::Height(HeightMap { size, heights, amplitude: *amplitude, middle: *middle }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(more: &str) -> Result<PatternScene, String> {
        let text = format!(
            "{{\"gradtess\": 1, \"technique\": \"pattern\",\n\"positions\": [[0,0,0],[1,0,0],[0,1,0],[1,1,0.5]],\n{more}}}"
        );
        PatternScene::parse(text.as_bytes(), "x.json").map_err(|e| e.to_string())
    }

    #[test]
    fn a_scene_is_completed_and_says_so() {
        let s = scene("\"faces\": [[0,1,3,2],\n[0,0,1]], \"displacement\": {\"kind\": \"noise\", \"amplitude\": 1, \"frequency\": 2}").unwrap();
        assert_eq!((s.mesh.triangles.len(), s.name.as_str(), s.level), (3, "x", 16));
        let all = s.notes.join("\n");
        for what in ["1 polygons were cut", "4 of 4 vertices have no normal", "the first is triangle 2 (line 4)"] {
            assert!(all.contains(what), "{all}");
        }
    }

    #[test]
    fn faults_name_what_where_and_how() {
        let faces = "\"faces\": [[0,1,2],\n[1,3,2]]";
        let cases = [
            ("\"faces\": []".to_owned(), "x.json:3:10: the scene has no face"),
            ("\"faces\": [[0,1]]".to_owned(), "x.json:3:11: a face has at least three"),
            ("\"faces\": [[0,1,7]]".to_owned(), "x.json:3:16: vertex 7 does not exist"),
            (format!("{faces}, \"level\": 129"), "level 129 is out of range"),
            (format!("{faces}, \"normals\": [[0,0,1]]"), "there are 1 normals for 4"),
            (format!("{faces}, \"colours\": [[1,1],[1,1],[1,1],[1,1]]"), "this entry of colours"),
            (format!("{faces}, \"tags\": [{{\"vertex\": 9}}]"), "vertex 9 does not exist"),
            (format!("{faces}, \"tags\": [{{\"vertex\": 2}}, {{\"vertex\": 2}}]"), "vertex 2 is tagged twice"),
            (format!("{faces}, \"tags\": [{{\"vertex\": 2, \"sharpness\": 3}}]"), "the sharpness 3 of vertex 2"),
            (
                format!("{faces}, \"tags\": [{}]", [1, 2, 3].map(|v| format!("{{\"vertex\": {v}, \"deviation\": [1,0,0]}}")).join(",")),
                "x.json:4:1: vertex 2 is the third with a deviation vector in triangle 1",
            ),
            (format!("{faces}, \"displacement\": {{\"kind\": \"height\", \"amplitude\": 1, \"file\": \"none.png\"}}"), "the height map \"none.png\" cannot be read"),
            (format!("{faces}, \"displacement\": {{\"kind\": \"noise\", \"amplitude\": 1, \"frequency\": 1, \"octaves\": 99}}"), "octaves"),
            (format!("{faces}, \"evaluator\": \"spline\""), "unknown variant"),
        ];
        for (more, what) in cases {
            let error = scene(&more).unwrap_err();
            assert!(error.contains(what), "{more}: {error}");
            assert!(error.contains("; ") && !error.contains('\n'), "{error}");
        }
    }
}
