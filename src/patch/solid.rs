//! What is drawn of a scene in space: vertices of two vec4 and lists of triangles, lines or patches that share them.

use super::stencil::PackedStencils;
use glam::DVec3;

/// What a part's indices mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Primitive {
    /// Three corners, counter-clockwise from the front.
    Triangles,
    /// Two ends.
    Lines,
    /// 16 points of a bicubic patch, as in [`super`]; the second vec4 is the subdivided normal.
    Bicubic,
    /// 20 points of a Gregory patch.
    Gregory,
    /// 32 points of a bicubic patch with finer neighbours: its 16, the two inner points of the first half, the middle and
    /// the two inner points of the second half of up to three sides, and one whose x has bit i set where side i has them.
    Transition,
    /// 15 points of a quartic triangle, as in [`super::quartic`].
    Quartic,
    /// 18 points of a Gregory triangle.
    QuarticGregory,
    /// 30 points of a quartic triangle with finer neighbours: its 15, the three inner points of the first half, the middle
    /// and the three inner points of the second half of up to two sides, and one whose x has bit i set where side i has them.
    QuarticTransition,
}

impl Primitive {
    /// Indices of one.
    pub const fn points(self) -> usize {
        match self {
            Primitive::Triangles => 3,
            Primitive::Lines => 2,
            Primitive::Bicubic => 16,
            Primitive::Gregory => 20,
            Primitive::Transition => 32,
            Primitive::Quartic => 15,
            Primitive::QuarticGregory => 18,
            Primitive::QuarticTransition => 30,
        }
    }
}

impl Primitive {
    /// Whether the tessellator draws it.
    pub const fn is_patch(self) -> bool {
        !matches!(self, Primitive::Triangles | Primitive::Lines)
    }

    /// Whether its sides may have finer neighbours.
    pub const fn is_transition(self) -> bool {
        matches!(self, Primitive::Transition | Primitive::QuarticTransition)
    }
}

/// A run of primitives of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Kind.
    pub primitive: Primitive,
    /// First index.
    pub first: u32,
    /// Primitives.
    pub count: u32,
    /// Level of patches.
    pub level: u32,
}

/// Segments that the tessellator makes of a patch's sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Segments {
    /// As many on every level, 1 to 64.
    Fixed(u32),
    /// That many on level 0, half as many on each further level, but at least 1.
    Base(u32),
}

impl Segments {
    /// Of a patch of `level`. A side whose neighbour is finer has twice those of the next level.
    pub fn at(self, level: u32) -> u32 {
        match self {
            Segments::Fixed(n) => n,
            Segments::Base(n) => n.checked_shr(level).unwrap_or(0).max(1),
        }
    }
}

/// A scene in space, relative to [`SolidTable::centre`] so that `f32` resolves it wherever it lies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolidTable {
    /// x, y, z, blend weight; then the normal, or a colour, and one unused.
    pub vertices: Vec<[f32; 8]>,
    /// What the device makes of the vertices, if they are not drawn themselves.
    pub stencils: Option<PackedStencils>,
    /// Indices of all parts: of vertices, or of the points that `stencils` makes of them.
    pub indices: Vec<u32>,
    /// Drawn in this order.
    pub parts: Vec<Part>,
    /// What was taken from every position.
    pub centre: DVec3,
    /// Least and greatest corner of the scene, model units (not relative).
    pub bounds: [DVec3; 2],
}

impl SolidTable {
    /// An empty table for a scene within `bounds`.
    pub fn new(bounds: [DVec3; 2]) -> SolidTable {
        SolidTable { centre: (bounds[0] + bounds[1]) * 0.5, bounds, ..SolidTable::default() }
    }

    /// Adds a vertex and returns its number.
    pub fn vertex(&mut self, position: DVec3, weight: f64, vector: DVec3) -> u32 {
        self.vertices.push(SolidTable::packed(self.centre, position, weight, vector));
        self.vertices.len() as u32 - 1
    }

    /// A vertex of a table with that centre.
    #[inline]
    pub fn packed(centre: DVec3, position: DVec3, weight: f64, vector: DVec3) -> [f32; 8] {
        let (p, v) = ((position - centre).as_vec3(), vector.as_vec3());
        [p.x, p.y, p.z, weight as f32, v.x, v.y, v.z, 0.0]
    }

    /// Adds a part of all indices that no part has yet.
    pub fn part(&mut self, primitive: Primitive) {
        self.part_of_level(primitive, 0);
    }

    /// The same with patches of `level`.
    pub fn part_of_level(&mut self, primitive: Primitive, level: u32) {
        let first = self.parts.iter().map(|p| p.first + p.count * p.primitive.points() as u32).max().unwrap_or(0);
        let count = (self.indices.len() as u32 - first) / primitive.points() as u32;
        self.parts.push(Part { primitive, first, count, level });
    }

    /// What indices count: the vertices, or the points that the stencils make.
    pub fn points(&self) -> usize {
        self.stencils.as_ref().map_or(self.vertices.len(), |stencils| stencils.points.len())
    }

    /// Bytes on the device while it draws. What points are made of is there only until they are.
    pub fn bytes(&self) -> u64 {
        (self.points() * size_of::<[f32; 8]>() + size_of_val(self.indices.as_slice())) as u64
    }
}
