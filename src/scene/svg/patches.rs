//! Rows of patches: what each stop says and what it leaves to its neighbours.

use super::paint::stop_colour;
use super::shape::length;
use super::xml::{shown, Element};
use crate::ferguson::blend::Blend;
use crate::ferguson::mesh::{twist_of, Jet, Mesh};
use crate::patch::space::Interpolation;
use crate::scene::error::Fault;
use glam::{DAffine2, DVec2, DVec4};

/// Largest coordinate of a scene.
const LARGEST: f64 = 1e9;

/// A gradient as a grid, in the coordinates of the drawing or of a scene.
#[derive(Clone)]
pub(super) struct Grid {
    rows: usize,
    columns: usize,
    /// (rows + 1) lines of columns + 1 points.
    points: Vec<DVec2>,
    /// Inner Bezier points of the edges along rows, left to right: (rows + 1) lines of columns.
    across: Vec<[DVec2; 2]>,
    /// Inner Bezier points of the edges along columns, top to bottom: rows lines of columns + 1.
    down: Vec<[DVec2; 2]>,
    /// Of each patch: inner Bezier points at the corners TL, TR, BR, BL where the file gives them.
    tensor: Vec<Option<[DVec2; 4]>>,
    /// Of each patch: colours with derivatives at TL, TR, BR, BL; u to the right, v down.
    jets: Vec<[Jet; 4]>,
}

impl Grid {
    pub fn patches(&self) -> usize {
        self.rows * self.columns
    }

    fn point(&self, row: usize, column: usize) -> usize {
        row * (self.columns + 1) + column
    }

    /// The grid under an affine map.
    pub fn mapped(&self, map: DAffine2) -> Grid {
        let to = |p: DVec2| map.transform_point2(p);
        Grid {
            points: self.points.iter().map(|&p| to(p)).collect(),
            across: self.across.iter().map(|e| e.map(to)).collect(),
            down: self.down.iter().map(|e| e.map(to)).collect(),
            tensor: self.tensor.iter().map(|t| t.map(|t| t.map(to))).collect(),
            ..self.clone()
        }
    }

    /// The grid with its alpha times `opacity`; premultiplied colours with it.
    pub fn fainter(mut self, opacity: f64, premultiplied: bool) -> Grid {
        let colour = if premultiplied { opacity } else { 1.0 };
        let factor = DVec4::new(colour, colour, colour, opacity);
        for jet in self.jets.iter_mut().flatten() {
            for value in [&mut jet.value, &mut jet.du, &mut jet.dv, &mut jet.duv] {
                *value *= factor;
            }
        }
        self
    }

    /// Whether all coordinates can be worked with.
    pub fn is_moderate(&self) -> bool {
        let fine = |p: &DVec2| p.is_finite() && p.abs().max_element() <= LARGEST;
        self.points.iter().all(fine)
            && self.across.iter().chain(&self.down).flatten().all(fine)
            && self.tensor.iter().flatten().flatten().all(fine)
    }

    /// Bezier net of a patch: the Coons patch of its edges unless the file gives the inner points.
    fn net(&self, row: usize, column: usize) -> [DVec2; 16] {
        let p = |r, c| self.points[self.point(r, c)];
        let (top, bottom) = (self.across[row * self.columns + column], self.across[(row + 1) * self.columns + column]);
        let (left, right) =
            (self.down[row * (self.columns + 1) + column], self.down[row * (self.columns + 1) + column + 1]);
        let mut n = [DVec2::ZERO; 16];
        (n[0], n[3], n[12], n[15]) = (p(row, column), p(row, column + 1), p(row + 1, column), p(row + 1, column + 1));
        (n[1], n[2], n[13], n[14]) = (top[0], top[1], bottom[0], bottom[1]);
        (n[4], n[8], n[7], n[11]) = (left[0], left[1], right[0], right[1]);
        let inner = self.tensor[row * self.columns + column].unwrap_or_else(|| coons(&n));
        (n[5], n[6], n[10], n[9]) = (inner[0], inner[1], inner[2], inner[3]);
        n
    }
}

/// Inner points at A, B, C, D of the Coons patch of a net's boundary.
pub(super) fn coons(n: &[DVec2; 16]) -> [DVec2; 4] {
    // Of each corner: itself, its two neighbours on the sides, the two corners next to it, the points opposite to the
    // neighbours, the far corner.
    const AT: [[usize; 8]; 4] = [
        [0, 1, 4, 3, 12, 7, 13, 15],
        [3, 2, 7, 0, 15, 4, 14, 12],
        [15, 14, 11, 12, 3, 8, 2, 0],
        [12, 13, 8, 15, 0, 11, 1, 3],
    ];
    AT.map(|[p, along, down, a, b, far_down, far_along, far]| {
        (n[p] * -4.0 + (n[along] + n[down]) * 6.0 - (n[a] + n[b]) * 2.0 + (n[far_down] + n[far_along]) * 3.0 - n[far])
            / 9.0
    })
}

/// Numbers of a path after its command.
fn numbers(text: &str, stop: &Element, data: &str) -> Result<Vec<f64>, Fault> {
    let mut all = Vec::new();
    for number in svgtypes::NumberListParser::from(data) {
        let number =
            number.map_err(|_| stop.fault(text, format!("the path {} is malformed", shown(data)), "give numbers"))?;
        if !number.is_finite() || number.abs() > LARGEST {
            return Err(stop.fault(text, "a number of the path is too large", "scale the drawing to moderate numbers"));
        }
        all.push(number);
        if all.len() > 6 {
            break;
        }
    }
    Ok(all)
}

/// The three points after `from` of a stop's edge; where the path may leave out its end, `end` stands in for it.
fn edge(text: &str, stop: &Element, from: DVec2, end: Option<DVec2>) -> Result<[DVec2; 3], Fault> {
    let fix = "give one c, C, l or L command";
    let Some(path) = stop.get("path") else {
        return Err(stop.fault(text, "the stop has no path", fix));
    };
    let path = path.trim();
    let command = path.chars().next().unwrap_or(' ');
    let data = numbers(text, stop, path.get(command.len_utf8()..).unwrap_or(""))?;
    let base = if command.is_ascii_lowercase() { from } else { DVec2::ZERO };
    let at = |i: usize| base + DVec2::new(data[i], data[i + 1]);
    match (command, data.len(), end) {
        ('c' | 'C', 6, None) => Ok([at(0), at(2), at(4)]),
        ('c' | 'C', 6 | 4, Some(end)) => Ok([at(0), at(2), end]),
        ('l' | 'L', 2, None) => Ok(line(from, at(0))),
        ('l' | 'L', 2 | 0, Some(end)) => Ok(line(from, end)),
        // The end of a closed patch, and nothing else.
        ('z' | 'Z', 0, Some(end)) => Ok(line(from, end)),
        ('c' | 'C' | 'l' | 'L', n, _) => {
            Err(stop.fault(text, format!("the path {} has {n} numbers", shown(path)), "give 6 after c, 2 after l"))
        }
        _ => Err(stop.fault(text, format!("the path {} is none of an edge", shown(path)), fix)),
    }
}

fn line(from: DVec2, to: DVec2) -> [DVec2; 3] {
    [from + (to - from) / 3.0, to - (to - from) / 3.0, to]
}

/// Reads the rows of a gradient; `with` finds the element that an attribute comes from.
pub(super) fn read<'a>(text: &str, gradient: &'a Element, with: impl Fn(&str) -> &'a Element) -> Result<Grid, Fault> {
    let rows: Vec<&Element> = gradient.children.iter().filter(|c| c.name == "meshrow").collect();
    let patches = |row: &'_ Element| row.children.iter().filter(|c| c.name == "meshpatch").count();
    let columns = patches(rows[0]);
    if columns == 0 {
        return Err(rows[0].fault(text, "the row has no patch", "give it <meshpatch> elements"));
    }
    let bicubic = match with("type").get("type") {
        None | Some("bilinear" | "coons") => false,
        Some("bicubic") => true,
        Some(other) => {
            return Err(gradient.fault(text, format!("type {} is unknown", shown(other)), "use bilinear or bicubic"));
        }
    };
    let count = rows.len();
    let nothing = [DVec2::ZERO; 2];
    let mut grid = Grid {
        rows: count,
        columns,
        points: vec![DVec2::ZERO; (count + 1) * (columns + 1)],
        across: vec![nothing; (count + 1) * columns],
        down: vec![nothing; count * (columns + 1)],
        tensor: vec![None; count * columns],
        jets: Vec::new(),
    };
    let mut colours = vec![DVec4::ZERO; grid.points.len()];
    let mut given: Vec<Option<[Jet; 4]>> = Vec::new();
    grid.points[0] = DVec2::new(length(text, with("x"), "x")?, length(text, with("y"), "y")?);
    for (r, row) in rows.iter().enumerate() {
        if patches(row) != columns {
            let what = format!("this row has {} patches, the first has {columns}", patches(row));
            return Err(row.fault(text, what, "give every row as many patches as the first"));
        }
        for (c, patch) in row.children.iter().filter(|e| e.name == "meshpatch").enumerate() {
            read_patch(text, patch, &mut grid, &mut colours, [r, c])?;
            given.push(jets(text, patch)?);
        }
    }
    grid.jets = if bicubic { smooth(&grid, &colours) } else { bilinear(&grid, &colours) };
    for (jets, given) in grid.jets.iter_mut().zip(given) {
        *jets = given.unwrap_or(*jets);
    }
    Ok(grid)
}

fn read_patch(
    text: &str,
    patch: &Element,
    grid: &mut Grid,
    colours: &mut [DVec4],
    [r, c]: [usize; 2],
) -> Result<(), Fault> {
    let stops: Vec<&Element> = patch.children.iter().filter(|s| s.name == "stop").collect();
    // Top, right, bottom, left; of these, the ones that no neighbour has given already.
    let sides: Vec<usize> =
        [r == 0, true, true, c == 0].iter().enumerate().filter(|(_, &own)| own).map(|(i, _)| i).collect();
    if stops.len() != sides.len() {
        let what = format!("the patch has {} stops where {} are needed", stops.len(), sides.len());
        let fix = "give 4 stops to the first patch, 3 to others of the first row and column, 2 to the rest";
        return Err(patch.fault(text, what, fix));
    }
    let corner = [grid.point(r, c), grid.point(r, c + 1), grid.point(r + 1, c + 1), grid.point(r + 1, c)];
    for (order, (&side, stop)) in sides.iter().zip(&stops).enumerate() {
        let (from, to) = (corner[side], corner[(side + 1) & 3]);
        // Where the last edge ends is known.
        let end = (order + 1 == sides.len()).then(|| grid.points[to]);
        let [a, b, at] = edge(text, stop, grid.points[from], end)?;
        grid.points[to] = at;
        let columns = grid.columns;
        match side {
            0 => grid.across[r * columns + c] = [a, b],
            1 => grid.down[r * (columns + 1) + c + 1] = [a, b],
            2 => grid.across[(r + 1) * columns + c] = [b, a],
            _ => grid.down[r * (columns + 1) + c] = [b, a],
        }
        // The first stop of every patch but the first begins in a corner that has its colour already.
        if order > 0 || (r, c) == (0, 0) {
            colours[from] = stop_colour(text, stop)?;
        }
    }
    if let Some(value) = patch.get("tensor") {
        let data: Vec<f64> = svgtypes::NumberListParser::from(value).take(9).filter_map(Result::ok).collect();
        if data.len() != 8 || data.iter().any(|x| !x.is_finite()) {
            let what = format!("tensor {} has not eight numbers", shown(value));
            return Err(patch.fault(text, what, "give four points as offsets from the corners"));
        }
        let offset = |i: usize| DVec2::new(data[2 * i], data[2 * i + 1]);
        grid.tensor[r * grid.columns + c] = Some([0, 1, 2, 3].map(|i| grid.points[corner[i]] + offset(i)));
    }
    Ok(())
}

/// Colour jets as our own writer puts them beside the stops: 64 numbers.
fn jets(text: &str, patch: &Element) -> Result<Option<[Jet; 4]>, Fault> {
    let Some(value) = patch.get("jets") else { return Ok(None) };
    let data: Vec<f64> = svgtypes::NumberListParser::from(value).take(65).filter_map(Result::ok).collect();
    if data.len() != 64 || data.iter().any(|x| !x.is_finite() || x.abs() > LARGEST) {
        return Err(patch.fault(
            text,
            "the jets are not 64 ordinary numbers",
            "remove the attribute: the stops say enough",
        ));
    }
    let at = |i: usize| DVec4::new(data[i], data[i + 1], data[i + 2], data[i + 3]);
    Ok(Some([0, 1, 2, 3].map(|i| Jet {
        value: at(16 * i),
        du: at(16 * i + 4),
        dv: at(16 * i + 8),
        duv: at(16 * i + 12),
    })))
}

fn corners(grid: &Grid, colours: &[DVec4], i: usize) -> [DVec4; 4] {
    let (r, c) = (i / grid.columns, i % grid.columns);
    [grid.point(r, c), grid.point(r, c + 1), grid.point(r + 1, c + 1), grid.point(r + 1, c)].map(|p| colours[p])
}

/// Bilinear colour as jets.
fn bilinear(grid: &Grid, colours: &[DVec4]) -> Vec<[Jet; 4]> {
    let jets = |i: usize| {
        let q = corners(grid, colours, i);
        let twist = q[0] - q[1] + q[2] - q[3];
        std::array::from_fn(|k| {
            let du = if k < 2 { q[1] - q[0] } else { q[2] - q[3] };
            let dv = if k == 1 || k == 2 { q[2] - q[1] } else { q[3] - q[0] };
            Jet { value: q[k], du, dv, duv: twist }
        })
    };
    (0..grid.patches()).map(jets).collect()
}

/// Smooth colour: slopes along the lines of the grid by the draft's rule, mixed derivative 0; alpha stays bilinear.
fn smooth(grid: &Grid, colours: &[DVec4]) -> Vec<[Jet; 4]> {
    let line = |points: Vec<usize>| {
        let c: Vec<DVec4> = points.iter().map(|&p| colours[p]).collect();
        let d: Vec<f64> = points.windows(2).map(|w| (grid.points[w[1]] - grid.points[w[0]]).length()).collect();
        slopes(&c, &d)
    };
    let along: Vec<Vec<DVec4>> =
        (0..=grid.rows).map(|r| line((0..=grid.columns).map(|c| grid.point(r, c)).collect())).collect();
    let down: Vec<Vec<DVec4>> =
        (0..=grid.columns).map(|c| line((0..=grid.rows).map(|r| grid.point(r, c)).collect())).collect();
    let mut all = bilinear(grid, colours);
    for (i, jets) in all.iter_mut().enumerate() {
        let (r, c) = (i / grid.columns, i % grid.columns);
        for (k, jet) in jets.iter_mut().enumerate() {
            let (row, column) = (r + usize::from(k > 1), c + usize::from(k == 1 || k == 2));
            let chord = |a: usize, b: usize| (grid.points[b] - grid.points[a]).length();
            let width = chord(grid.point(row, c), grid.point(row, c + 1));
            let height = chord(grid.point(r, column), grid.point(r + 1, column));
            let rgb = |new: DVec4, old: DVec4| DVec4::new(new.x, new.y, new.z, old.w);
            jet.du = rgb(along[row][column] * width, jet.du);
            jet.dv = rgb(down[column][row] * height, jet.dv);
            jet.duv = rgb(DVec4::ZERO, jet.duv);
        }
    }
    all
}

/// Slopes of colours `c` at points `d` apart along a line: the mean of the two secants, 0 at an extremum or beside points
/// that coincide, not above three times either secant; at the ends, that of the parabola. One piece is straight.
fn slopes(c: &[DVec4], d: &[f64]) -> Vec<DVec4> {
    let secant = |k: usize| if d[k] > 0.0 { (c[k + 1] - c[k]) / d[k] } else { DVec4::ZERO };
    let n = d.len();
    let mut s = vec![DVec4::ZERO; n + 1];
    for k in 1..n {
        let (a, b) = (secant(k - 1), secant(k));
        for i in 0..4 {
            let rises = a[i] * b[i] > 0.0 && d[k - 1] > 0.0 && d[k] > 0.0;
            let most = 3.0 * a[i].abs().min(b[i].abs());
            s[k][i] = if rises { (0.5 * (a[i] + b[i])).clamp(-most, most) } else { 0.0 };
        }
    }
    if n == 1 {
        (s[0], s[1]) = (secant(0), secant(0));
    } else {
        (s[0], s[n]) = (secant(0) * 2.0 - s[1], secant(n - 1) * 2.0 - s[n - 1]);
    }
    s
}

/// One mesh of all grids.
pub(super) fn mesh(grids: &[Grid], colour: Interpolation, blend: Blend) -> Mesh {
    let (mut points, mut quads): (Vec<DVec2>, Vec<[u32; 4]>) = (Vec::new(), Vec::new());
    for grid in grids {
        let first = points.len();
        points.extend_from_slice(&grid.points);
        for i in 0..grid.patches() {
            let (r, c) = (i / grid.columns, i % grid.columns);
            let ring = [grid.point(r, c), grid.point(r, c + 1), grid.point(r + 1, c + 1), grid.point(r + 1, c)];
            quads.push(ring.map(|p| (first + p) as u32));
        }
    }
    // A grid names every point once and every edge in both directions, so this cannot fail.
    let mut mesh = Mesh::from_quads(&points, &quads, &[]).unwrap_or_default();
    (mesh.colour, mesh.blend) = (colour, blend);
    let mut p = 0;
    for grid in grids {
        for i in 0..grid.patches() {
            let net = grid.net(i / grid.columns, i % grid.columns);
            for (side, slots) in crate::patch::eval::FACE_EDGES.into_iter().enumerate() {
                let s = mesh.patches[p].sides[side];
                let (a, b) = (net[slots[1]], net[slots[2]]);
                mesh.curves[s.curve as usize].handles = if s.against { [b, a] } else { [a, b] };
            }
            for k in 0..4 {
                mesh.patches[p].corners[k].twist = twist_of(&net, k);
                mesh.patches[p].corners[k].colour = grid.jets[i][k];
            }
            p += 1;
        }
    }
    mesh.take_journal();
    mesh
}
