//! Levels against those of the authors' tool: positions, normals, weights.

mod models;

use flate2::read::GzDecoder;
use glam::DVec3;
use gradtess::mesh;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::normal::ControlNormals;
use gradtess::surface::refine::levels;
use gradtess::surface::shade::{shade, Geometric, Settings, Shaded};
use gradtess::surface::weight::{needing, Initial, Rules, Variant};
use serde::Deserialize;

#[derive(Deserialize)]
struct Reference {
    positions: Vec<DVec3>,
    blend_weight: Vec<f64>,
    wedge_vertex: Vec<usize>,
    n_geometry: Vec<DVec3>,
    n_subdivided: Vec<DVec3>,
}

/// What our level has and the tool's, vertex by vertex of ours.
struct Compared {
    level: Level,
    shaded: Shaded,
    reference: Reference,
    /// The tool's vertex of each of ours.
    theirs: Vec<usize>,
}

fn compare(model: &str, scheme: Scheme) -> Option<Compared> {
    let folder = models::folder("surface", model)?;
    let short = if scheme == Scheme::Loop { "loop" } else { "cc" };
    let packed = std::fs::read(folder.join(format!("ref/{model}_{short}_L3_B_dartsmooth_chained.json.gz"))).unwrap();
    let reference: Reference = serde_json::from_reader(GzDecoder::new(packed.as_slice())).unwrap();
    let file = folder.join(format!("{model}.obj"));
    let scene = SurfaceScene::parse(&std::fs::read(&file).unwrap(), model).unwrap();
    let mesh = mesh::build(&scene.polygons()).unwrap();
    let mut levels = levels(&scene, &mesh, scheme, 3).unwrap();
    // The tool: normals of the mesh, never those of the file.
    let settings = Settings {
        geometric: Geometric::Mesh,
        control: ControlNormals::Faces,
        everywhere: true,
        ..Settings::default()
    };
    let shaded = shade(&levels, &scene.normals, &settings);
    let level = levels.pop().unwrap();
    assert_eq!(level.vertices(), reference.positions.len());
    let nearest = |p: &DVec3| {
        let distance = |i: &usize| (reference.positions[*i] - *p).length();
        (0..reference.positions.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let theirs: Vec<usize> = level.position.iter().map(nearest).collect();
    Some(Compared { level, shaded, reference, theirs })
}

impl Compared {
    fn position(&self) -> f64 {
        let far = |(p, &i): (&DVec3, &usize)| (self.reference.positions[i] - *p).length();
        self.level.position.iter().zip(&self.theirs).map(far).fold(0.0, f64::max)
    }

    /// Degrees between each of our wedges and the nearest normal that the tool has at the vertex.
    fn angles(&self, ours: &[DVec3], theirs: &[DVec3]) -> Vec<f64> {
        let mut at = vec![Vec::new(); self.level.vertices()];
        for (&v, &n) in self.reference.wedge_vertex.iter().zip(theirs) {
            at[v].push(n);
        }
        let angle = |(w, &first): (usize, &u32)| {
            let v = self.level.origin[first as usize] as usize;
            let between = |n: &DVec3| n.angle_between(ours[w]).to_degrees();
            at[self.theirs[v]].iter().map(between).fold(f64::INFINITY, f64::min)
        };
        self.shaded.wedges.first.iter().enumerate().map(angle).collect()
    }

    fn weights(&self) -> Vec<f64> {
        let off = |(w, &i): (&f64, &usize)| (self.reference.blend_weight[i] - w).abs();
        self.shaded.weight.iter().zip(&self.theirs).map(off).collect()
    }
}

/// How many exceed `limit`, and the greatest.
fn above(values: &[f64], limit: f64) -> (usize, f64) {
    (values.iter().filter(|&&x| x > limit).count(), values.iter().copied().fold(0.0, f64::max))
}

/// All that both define alike: positions, N_L of the mesh.
fn same_geometry(c: &Compared) {
    assert!(c.position() < 1e-6, "{}", c.position());
    assert_eq!(c.shaded.wedges.len(), c.reference.wedge_vertex.len());
    let (_, turn) = above(&c.angles(&c.shaded.geometric, &c.reference.n_geometry), 0.0);
    assert!(turn < 1e-3, "N_L: {turn} degrees");
}

#[test]
fn letter_a_agrees_throughout() {
    let Some(c) = compare("ItaPaperGeom", Scheme::CatmullClark) else { return };
    same_geometry(&c);
    let (_, turn) = above(&c.angles(&c.shaded.subdivided, &c.reference.n_subdivided), 0.0);
    assert!(turn < 1e-3, "N_S: {turn} degrees");
    let (_, off) = above(&c.weights(), 0.0);
    assert!(off < 1e-6, "b: {off}");
}

#[test]
fn sharp_tetrahedron_agrees_but_for_weights_next_to_creases() {
    let Some(c) = compare("Tetrahedron4", Scheme::Loop) else { return };
    same_geometry(&c);
    let (_, turn) = above(&c.angles(&c.shaded.subdivided, &c.reference.n_subdivided), 0.0);
    assert!(turn < 1e-3, "N_S: {turn} degrees");
    // The tool's last stencil is the smooth one even on creases; the paper's Fig. 4 has zeros there, and so do we.
    let borders = c.level.count_edges(&c.level.border, |&b| b);
    for (v, off) in c.weights().into_iter().enumerate() {
        if borders[v] >= 2 {
            assert!(c.shaded.weight[v] == 0.0 && off < 0.0417, "{v}: {off}");
        } else {
            assert!(off < 1e-6, "{v}: {off}");
        }
    }
}

#[test]
fn decayed_crease_differs_where_the_tool_takes_one_side() {
    let Some(c) = compare("cube2", Scheme::CatmullClark) else { return };
    same_geometry(&c);
    let (_, off) = above(&c.weights(), 0.0);
    assert!(off < 1e-6, "b: {off}");
    // Sharpness 2 has decayed at level 3. The tool starts the smooth rule from one region's normal, we from their mean.
    let (many, most) = above(&c.angles(&c.shaded.subdivided, &c.reference.n_subdivided), 1e-3);
    assert!((200..260).contains(&many) && most < 45.0, "N_S: {many} of {}, {most} degrees", c.level.vertices());
}

#[test]
fn spot_needs_as_few_subdivided_normals_as_section_5_says() {
    let Some(folder) = models::folder("surface", "Spot2") else { return };
    let scene = SurfaceScene::parse(&std::fs::read(folder.join("Spot2.obj")).unwrap(), "Spot2").unwrap();
    let mesh = mesh::build(&scene.polygons()).unwrap();
    let levels = levels(&scene, &mesh, Scheme::CatmullClark, 4).unwrap();
    let last = &levels[4];
    assert_eq!((last.vertices(), last.faces()), (46850, 46848));
    let count = |initial, only| needing(last, Rules { initial, ..Rules::default() }, only);
    // The paper has the valences 3 and 5 only.
    let paper = |initial| count(initial, Some((3, false))) + count(initial, Some((5, false)));
    assert_eq!((paper(Initial::Inverse), paper(Initial::Ring)), (832, 2304));
    assert_eq!((count(Initial::Inverse, None), count(Initial::Ring, None)), (884, 2452));
    // Blending from level 1 on needs nearly all (the tool's count).
    let rules = Rules { variant: Variant::A, ..Rules::default() };
    let settings = Settings { rules, ..Settings::default() };
    let shaded = shade(&levels, &scene.normals, &settings);
    assert_eq!(shaded.blended_vertices(), 44737);
    // What is computed where it is needed is what is computed everywhere.
    let late = Settings { weights_from: 4, ..settings };
    let (few, all) = (shade(&levels, &[], &late), shade(&levels, &[], &Settings { everywhere: true, ..late }));
    let vertices: usize = levels[1..].iter().map(Level::vertices).sum();
    assert!(few.normals_computed * 8 < vertices);
    assert_eq!(few.blended, all.blended);
    assert_eq!(few.blended_vertices(), 2452);
}
