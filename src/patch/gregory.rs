//! Face points of Gregory patches: `f+` and `f-` of LSNC09 3.3 with the boundary forms of the authors' tool.

use super::points::{colour_of, control, position_of, Points};
use super::ControlPoint;
use crate::refine::Rules;
use crate::subdiv::fan::Linear;
use crate::subdiv::level::{Level, Value};
use crate::subdiv::limit::cosine;

/// Everything that one face point depends on, for positions or colours.
pub(crate) struct Edge<V> {
    /// Control vertex at the corner.
    pub v: V,
    /// What `c1` weighs: the patch corner by LSNC09 eq. 6; the authors' tool has the control vertex there, which
    /// differs next to extraordinary vertices.
    pub corner: V,
    /// Bezier points of the edge, near the corner and far.
    pub near: V,
    pub far: V,
    /// Neighbour of `v` off the edge in this face.
    pub own: V,
    /// The same in the face across the edge; `None` at a border.
    pub other: Option<V>,
    /// Far end of the edge.
    pub end: V,
    /// Centroids of this face and the one across.
    pub centre: V,
    pub across: V,
    /// Valences at `v` and at the far end.
    pub valence: [f64; 2],
}

/// `f+` or `f-`.
pub(crate) fn face_point<V: Linear>(e: &Edge<V>) -> V {
    const D: f64 = 3.0; // quads
    let [c0, c1] = e.valence.map(|n| cosine(2, n as usize));
    let r = match e.other {
        // Half the neighbours' difference is that of the edge midpoints towards them.
        Some(other) => (e.own - other) * (0.5 / 3.0) + (e.centre - e.across) * (2.0 / 3.0),
        None => (e.own - e.v) * (1.0 / 3.0) + (e.centre - (e.v + e.end) * 0.5) * (4.0 / 3.0),
    };
    (e.corner * c1 + e.near * (D - 2.0 * c0 - c1) + e.far * (2.0 * c0) + r) * (1.0 / D)
}

/// Means of a face's corners and of those of the faces across its edges, by local edge; across a border the face's own.
pub(super) struct Centroids {
    own: Value,
    across: [Value; 4],
}

/// Centroids around quad `f`.
pub(super) fn centroids(level: &Level, f: u32) -> Centroids {
    let mean = |f: u32| {
        let sum = level.of_face(f).fold(Value::default(), |sum, g| sum + level.at(g));
        sum * (1.0 / f64::from(level.valence(f)))
    };
    let own = mean(f);
    let first = level.first(f);
    Centroids { own, across: [0, 1, 2, 3].map(|i| level.across(first + i).map_or(own, |t| mean(level.face_of(t)))) }
}

/// `f+` (along the edge of `h`) or, with `reverse`, `f-` (along the edge before) of the corner at the origin of
/// `h`. `bezier` are the corner, near and far points of that edge, `valence` the Gregory valences (position,
/// colour) at the corner and at the edge's far end.
pub(super) fn face_points(
    points: &Points,
    h: u32,
    reverse: bool,
    bezier: [&ControlPoint; 3],
    valence: [[f64; 2]; 2],
    centroids: &Centroids,
) -> ControlPoint {
    let level = points.account.level;
    let control_vertex = points.account.style.rules == Rules::Authors;
    let edge = if reverse { level.prev(h) } else { h };
    let own = if reverse { level.next(h) } else { level.prev(h) };
    let end = if reverse { edge } else { level.next(h) };
    let twin = level.across(edge);
    // Neighbour of the vertex in the face across: one edge on from where the twin starts, or where it came from.
    let beyond = twin.map(|t| if reverse { level.prev(t) } else { level.next(level.next(t)) });
    let across = centroids.across[(edge - level.first(level.face_of(edge))) as usize];

    let position = face_point(&Edge {
        v: level.position(h),
        corner: if control_vertex { level.position(h) } else { position_of(bezier[0]) },
        near: position_of(bezier[1]),
        far: position_of(bezier[2]),
        own: level.position(own),
        other: beyond.map(|g| level.position(g)),
        end: level.position(end),
        centre: centroids.own.p,
        across: across.p,
        valence: [valence[0][0], valence[1][0]],
    });
    let colour = face_point(&Edge {
        v: level.corner_colour(h),
        corner: if control_vertex { level.corner_colour(h) } else { colour_of(bezier[0]) },
        near: colour_of(bezier[1]),
        far: colour_of(bezier[2]),
        own: level.corner_colour(own),
        other: beyond.filter(|_| !level.colour_border(edge)).map(|g| level.corner_colour(g)),
        end: level.corner_colour(end),
        centre: centroids.own.c,
        across: across.c,
        valence: [valence[0][1], valence[1][1]],
    });
    control(Value { p: position, c: colour })
}
