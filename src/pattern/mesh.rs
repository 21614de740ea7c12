//! The coarse mesh: triangles with the attributes that BS05 calls A_T.

use super::PatternError;
use glam::{DVec2, DVec3, DVec4};
use std::collections::HashMap;

/// Scalar tags of a vertex (BS05 App. B).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tag {
    /// theta: 0 as a PN triangle, 1 flat towards this vertex; -10 to 10.
    pub tension: f64,
    /// sigma: 0 smooth, 1 as sharp as the deviation says; 0 to 1.
    pub sharpness: f64,
    /// beta: leans the crease curve along the deviation; -10 to 10.
    pub bias: f64,
    /// Delta: what parts the two normals of a crease through this vertex, one is N + sigma Delta and the other
    /// N - sigma Delta; null where there is no crease.
    pub deviation: DVec3,
}

impl Tag {
    /// No tag at all.
    pub const NEUTRAL: Tag = Tag { tension: 0.0, sharpness: 0.0, bias: 0.0, deviation: DVec3::ZERO };

    /// Whether a crease passes through the vertex.
    pub fn is_crease(&self) -> bool {
        self.deviation != DVec3::ZERO
    }

    /// Refuses numbers that make no sense; `vertex` is for the message.
    ///
    /// # Errors
    /// [`PatternError::Tag`].
    pub fn check(&self, vertex: u32) -> Result<(), PatternError> {
        let wrong = |what, value, range| Err(PatternError::Tag { vertex, what, value, range });
        if !(-10.0..=10.0).contains(&self.tension) {
            return wrong("tension", self.tension, "-10 to 10");
        }
        if !(0.0..=1.0).contains(&self.sharpness) {
            return wrong("sharpness", self.sharpness, "0 to 1");
        }
        if !(-10.0..=10.0).contains(&self.bias) {
            return wrong("bias", self.bias, "-10 to 10");
        }
        let long = self.deviation.length();
        if long.is_nan() || long > 1e3 {
            return wrong("deviation's length", long, "0 to 1000");
        }
        Ok(())
    }
}

/// A coarse mesh of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoarseMesh {
    /// Position of each vertex.
    pub positions: Vec<DVec3>,
    /// Unit normal of each vertex.
    pub normals: Vec<DVec3>,
    /// Colour of each vertex, sRGB, straight alpha.
    pub colours: Vec<DVec4>,
    /// Texture coordinates of each vertex.
    pub uv: Vec<DVec2>,
    /// Tag of each vertex; empty where nothing is tagged.
    pub tags: Vec<Tag>,
    /// Vertices of each triangle, from 0.
    pub triangles: Vec<[u32; 3]>,
}

impl CoarseMesh {
    /// Tag of a vertex.
    pub fn tag(&self, vertex: u32) -> Tag {
        self.tags.get(vertex as usize).copied().unwrap_or(Tag::NEUTRAL)
    }

    /// Gives unit length to the normals, and computes those that are null: the sum of the normals of all triangles around
    /// the position, weighted by area. Returns how many were computed, and the vertices where that gave nothing (they get
    /// +z).
    pub fn complete_normals(&mut self) -> (usize, Vec<u32>) {
        self.normals.resize(self.positions.len(), DVec3::ZERO);
        let key = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut sums: HashMap<[u64; 3], DVec3> = HashMap::new();
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            for p in [a, b, c] {
                *sums.entry(key(p)).or_default() += (b - a).cross(c - a);
            }
        }
        let (mut computed, mut lost) = (0, Vec::new());
        for (v, n) in self.normals.iter_mut().enumerate() {
            *n = match n.try_normalize() {
                Some(n) => n,
                None => {
                    computed += 1;
                    let sum = sums.get(&key(self.positions[v])).copied().unwrap_or_default();
                    // Tiny triangles have tiny products; scaled first, they still have a direction.
                    (sum / sum.abs().max_element().max(f64::MIN_POSITIVE)).try_normalize().unwrap_or_else(|| {
                        lost.push(v as u32);
                        DVec3::Z
                    })
                }
            };
        }
        (computed, lost)
    }

    /// Triangles without area.
    pub fn flat_triangles(&self) -> Vec<u32> {
        let flat = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (b - a).cross(c - a).length() <= 1e-14 * longest * longest
        };
        (0..).zip(&self.triangles).filter(|(_, t)| flat(t)).map(|(i, _)| i).collect()
    }

    /// Whether the tags keep to the restrictions of BS05 App. B: at most two deviations a triangle, numbers in range.
    ///
    /// # Errors
    /// The first vertex that does not.
    pub fn check_tags(&self) -> Result<(), PatternError> {
        for (v, tag) in (0..).zip(&self.tags) {
            tag.check(v)?;
        }
        for (triangle, t) in (0..).zip(&self.triangles) {
            if t.iter().all(|&v| self.tag(v).is_crease()) {
                return Err(PatternError::ThreeDeviations { vertex: t[2], triangle, others: [t[0], t[1]] });
            }
        }
        Ok(())
    }

    /// Positions that have more than one normal: curved triangles part there.
    pub fn split_positions(&self) -> usize {
        let mut seen: HashMap<[u64; 3], Option<DVec3>> = HashMap::new();
        for (p, n) in self.positions.iter().zip(&self.normals) {
            let key = (*p + DVec3::ZERO).to_array().map(f64::to_bits);
            seen.entry(key).and_modify(|first| *first = first.filter(|first| first == n)).or_insert(Some(*n));
        }
        seen.values().filter(|n| n.is_none()).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> CoarseMesh {
        CoarseMesh {
            positions: vec![
                DVec3::ONE,
                DVec3::new(1.0, -1.0, -1.0),
                DVec3::new(-1.0, 1.0, -1.0),
                DVec3::new(-1.0, -1.0, 1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
            ..CoarseMesh::default()
        }
    }

    #[test]
    fn missing_normals_point_away_from_the_middle() {
        let mut mesh = tetrahedron();
        mesh.normals = vec![DVec3::X * 2.0];
        assert_eq!(mesh.complete_normals(), (3, vec![]));
        assert_eq!(mesh.normals[0], DVec3::X);
        for v in 1..4 {
            assert!((mesh.normals[v] - mesh.positions[v].normalize()).length() < 1e-15);
        }
    }

    #[test]
    fn triangles_without_area_are_found() {
        let mut mesh = tetrahedron();
        mesh.positions.push(DVec3::ONE * 3.0);
        mesh.triangles.extend([[0, 0, 1], [0, 4, 4]]);
        assert_eq!(mesh.flat_triangles(), [4, 5]);
        mesh.complete_normals();
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    }

    #[test]
    fn tags_that_break_the_restrictions_name_the_vertex() {
        let mut mesh = tetrahedron();
        let crease = Tag { sharpness: 1.0, deviation: DVec3::X, ..Tag::NEUTRAL };
        mesh.tags = vec![crease, crease, Tag::NEUTRAL, crease];
        assert_eq!(mesh.check_tags(), Err(PatternError::ThreeDeviations { vertex: 1, triangle: 1, others: [0, 3] }));
        mesh.tags[3] = Tag { tension: f64::NAN, ..Tag::NEUTRAL };
        assert!(matches!(mesh.check_tags(), Err(PatternError::Tag { vertex: 3, what: "tension", .. })));
    }
}
