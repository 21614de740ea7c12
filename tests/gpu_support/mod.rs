//! Shared by the GPU tests: a device under validation, and synthetic patch tables.
#![allow(dead_code)] // each test file uses its own part

use gradtess::gpu::{Canary, EvaluatedPoint, Format, Frame, Gpu, GpuOptions, Show};
use gradtess::patch::tess::TessRule;
use gradtess::patch::transition::{parts_of, Side, PARTS};
use gradtess::patch::{eval, ControlPoint, DrawRange, Kind, PatchTable};

/// Both kinds of faces.
pub const KINDS: [Kind; 2] = [Kind::Bicubic, Kind::Gregory];

/// Opens the device (`GRADTESS_DEVICE`, or the default one) under validation, runs the test, and fails if the
/// validation layer had anything to say.
pub fn with_gpu(test: impl FnOnce(&Gpu)) {
    let device = std::env::var("GRADTESS_DEVICE").ok();
    let gpu = Gpu::new(&GpuOptions { device, validate: true }).expect("a Vulkan device and the validation layer");
    let heard = gpu.canary(Canary::ZeroSizeBuffer).expect("a canary");
    assert!(!heard.is_empty(), "the validation layer does not listen");
    test(&gpu);
    let messages = gpu.messages();
    assert!(messages.is_empty(), "validation: {messages:#?}");
}

/// A frame of `size` pixels square over the unit square, with nothing special.
pub fn frame(size: u32) -> Frame {
    Frame {
        width: size,
        height: size,
        view: [0.0, 0.0, 1.0, 1.0],
        tess: TessRule::Fixed(8.0),
        show: Show::Surface,
        background: None,
        samples: 1,
        format: Format::Rgba8,
        statistics: false,
    }
}

/// Deterministic numbers in [0, 1).
pub struct Random(u64);

impl Random {
    /// A sequence of its own for each seed.
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// The next number.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A control point near (x, y) with colours in [0, 1].
    pub fn point(&mut self, x: f64, y: f64, spread: f64) -> ControlPoint {
        let mut p = std::array::from_fn(|_| self.next());
        p[0] = x + spread * (p[0] - 0.5);
        p[1] = y + spread * (p[1] - 0.5);
        f32_exact(p)
    }
}

/// The point as the GPU gets it.
pub fn f32_exact(p: ControlPoint) -> ControlPoint {
    p.map(|x| f64::from(x as f32))
}

/// The 16 or 20 points of a face over the rectangle (x, y) to (x + w, y + h), moved at random by `spread`.
pub fn random_face(kind: Kind, random: &mut Random, [x, y, w, h]: [f64; 4], spread: f64) -> Vec<ControlPoint> {
    let grid = |i: usize| (x + w * (i % 4) as f64 / 3.0, y + h * (i / 4) as f64 / 3.0);
    (0..kind.points())
        .map(|i| {
            let (px, py) = grid([5, 6, 10, 9].get(i.wrapping_sub(16)).copied().unwrap_or(i));
            random.point(px, py, spread)
        })
        .collect()
}

/// Half of a cubic by de Casteljau: the first (`second` false) or second, four points in the cubic's direction.
pub fn half_of(cubic: [ControlPoint; 4], second: bool) -> [ControlPoint; 4] {
    let mid = |a: ControlPoint, b: ControlPoint| -> ControlPoint { std::array::from_fn(|c| 0.5 * (a[c] + b[c])) };
    let [p0, p1, p2, p3] = cubic;
    let (a, b, c) = (mid(p0, p1), mid(p1, p2), mid(p2, p3));
    let (d, e) = (mid(a, b), mid(b, c));
    let m = mid(d, e);
    if second {
        [m, e, c, p3]
    } else {
        [p0, a, d, m]
    }
}

/// Adds points to a table and finds equal ones again, as the real builder shares them.
#[derive(Default)]
pub struct Builder {
    /// The table so far.
    pub table: PatchTable,
}

impl Builder {
    /// Index of a point, which is rounded to f32 and shared with an equal one.
    pub fn point(&mut self, p: ControlPoint) -> u32 {
        let p = f32_exact(p);
        let found = self.table.control.iter().position(|q| q.map(f64::to_bits) == p.map(f64::to_bits));
        found.unwrap_or_else(|| {
            self.table.control.push(p);
            self.table.control.len() - 1
        }) as u32
    }

    /// Adds a whole patch as a range of its own, or to the last range when that is of the same sort.
    pub fn whole(&mut self, kind: Kind, level: u32, points: &[ControlPoint]) {
        let indices: Vec<u32> = points[..kind.points()].iter().map(|&p| self.point(p)).collect();
        self.patch(kind, None, level, &indices);
    }

    /// Adds the parts of a transition face whose transition edges have been turned into standard position.
    pub fn transition(&mut self, kind: Kind, level: u32, points: &[ControlPoint], constellation: u8) {
        for number in parts_of(constellation) {
            let part = &PARTS[number];
            let mut indices: Vec<u32> = points[..kind.points()].iter().map(|&p| self.point(p)).collect();
            let corners: Vec<ControlPoint> =
                part.corners.iter().map(|&corner| corner_value(kind, points, corner)).collect();
            indices.extend(corners.iter().map(|&p| self.point(p)));
            let mut inner = [self.point([0.0; 8]); 4];
            let sides = if part.triangle { 3 } else { 4 };
            for i in 0..sides {
                if let Side::Half(pair) = part.sides[i] {
                    let cubic = half_edge(points, part.corners[i], part.corners[(i + 1) % sides]);
                    inner[2 * pair as usize] = self.point(cubic[1]);
                    inner[2 * pair as usize + 1] = self.point(cubic[2]);
                }
            }
            indices.extend(inner);
            self.patch(kind, Some(number as u8), level, &indices);
        }
    }

    fn patch(&mut self, kind: Kind, part: Option<u8>, level: u32, indices: &[u32]) {
        let first = self.table.indices.len() as u32;
        self.table.indices.extend(indices);
        match self.table.ranges.last_mut() {
            Some(range) if (range.kind, range.part, range.level) == (kind, part, level) => range.count += 1,
            _ => self.table.ranges.push(DrawRange { kind, part, level, first, count: 1 }),
        }
    }
}

/// Value of a face at a corner of a part (in halves of the domain). On the border: the midpoint of the edge's cubic by
/// de Casteljau, as the finer neighbour has it.
fn corner_value(kind: Kind, points: &[ControlPoint], corner: [u8; 2]) -> ControlPoint {
    let on_edge = match corner {
        [1, 0] => Some(0),
        [2, 1] => Some(1),
        [1, 2] => Some(2),
        [0, 1] => Some(3),
        _ => None,
    };
    match on_edge {
        Some(e) => half_of(eval::FACE_EDGES[e].map(|i| points[i]), false)[3],
        None => eval::face(kind, points, f64::from(corner[0]) / 2.0, f64::from(corner[1]) / 2.0),
    }
}

/// The half of a face's edge from one part corner to another.
pub fn half_edge(points: &[ControlPoint], from: [u8; 2], to: [u8; 2]) -> [ControlPoint; 4] {
    let along = |a: u8, b: u8| a == b && (a == 0 || a == 2);
    let edge = if along(from[1], to[1]) {
        if from[1] == 0 {
            0
        } else {
            2
        }
    } else if from[0] == 2 {
        1
    } else {
        3
    };
    let is_corner = |p: [u8; 2]| p[0] != 1 && p[1] != 1;
    // Counter-clockwise parts run along the face's edges in their own direction.
    half_of(eval::FACE_EDGES[edge].map(|i| points[i]), !is_corner(from))
}

/// Evaluated values along side `side` of one patch, from its corner to the next: level + 1 of them. `points` are those of
/// the patch.
///
/// # Panics
/// When one is missing, or the device gave two values to one vertex.
pub fn side_values(points: &[EvaluatedPoint], side: usize) -> Vec<[u32; 8]> {
    let part = points[0].part;
    let level = points[0].outer[side];
    let mut found: Vec<Option<[u32; 8]>> = vec![None; level as usize + 1];
    for point in points {
        let [x, y, z] = point.coord;
        let (distance, along) = if eval::sides(part) == 3 {
            [(z, y), (x, z), (y, x)][side]
        } else {
            [(y, x), (1.0 - x, y), (1.0 - y, 1.0 - x), (x, 1.0 - y)][side]
        };
        if distance < 1e-3 {
            let k = (along * level).round() as usize;
            let bits = point.value.map(f32::to_bits);
            assert!(found[k].is_none_or(|other| other == bits), "two values for one vertex of side {side}");
            found[k] = Some(bits);
        }
    }
    found
        .into_iter()
        .enumerate()
        .map(|(k, bits)| bits.unwrap_or_else(|| panic!("vertex {k} of {level} is missing on side {side}")))
        .collect()
}

/// Splits evaluated points, sorted as they come, by patch.
pub fn by_patch(points: &[EvaluatedPoint]) -> Vec<&[EvaluatedPoint]> {
    points.chunk_by(|a, b| (a.range, a.patch) == (b.range, b.patch)).collect()
}
