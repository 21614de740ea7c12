//! `gradtess sample` of a pattern scene: points of every coarse triangle.

use super::flags::evaluator_name;
use super::open::controls;
use crate::command::{print, print_json, Failure, Global};
use crate::pattern::evaluate::evaluate;
use crate::scene::pattern::PatternScene;
use serde::Serialize;

/// Most samples that one run makes; they are held in memory.
const MOST: u64 = 4_000_000;

#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    scene: &'a str,
    technique: &'static str,
    evaluator: &'static str,
    samples: Vec<Row>,
}

/// u and v are the weights of the second and third corner.
#[derive(Serialize)]
struct Row {
    face: usize,
    u: f64,
    v: f64,
    position: [f64; 3],
    normal: [f64; 3],
    colour: [f64; 4],
    uv: [f64; 2],
}

/// Evaluates `n` points along each side of every triangle, and those between.
pub fn run(scene: &PatternScene, n: u32, global: &Global) -> Result<(), Failure> {
    let each = u64::from(n) * (u64::from(n) + 1) / 2;
    let all = each * scene.mesh.triangles.len() as u64;
    if all > MOST {
        return Err(Failure::input(format_args!("{all} samples are too many; at most {MOST}, choose a smaller --n")));
    }
    let mut weights = Vec::new();
    let side = n - 1;
    for (i, j) in (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let part = |k: u32| if side == 0 { 1.0 / 3.0 } else { f64::from(k) / f64::from(side) };
        weights.push([part(side - i), part(i - j), part(j)]);
    }
    let mut samples = Vec::new();
    for (face, control) in controls(scene).iter().enumerate() {
        for &w in &weights {
            let point = evaluate(control, scene.evaluator, &scene.displacement, w);
            samples.push(Row {
                face,
                u: w[1],
                v: w[2],
                position: point.position.to_array(),
                normal: point.normal.to_array(),
                colour: point.colour.to_array(),
                uv: point.uv.to_array(),
            });
        }
    }
    if global.json {
        return print_json(&Report {
            schema: "gradtess.pattern_sample/1",
            scene: &scene.name,
            technique: "pattern",
            evaluator: evaluator_name(scene.evaluator),
            samples,
        });
    }
    let mut out = String::from("face\tu\tv\tx\ty\tz\tnx\tny\tnz\tr\tg\tb\ta\ts\tt\n");
    for row in &samples {
        let numbers = [row.u, row.v].into_iter().chain(row.position).chain(row.normal).chain(row.colour).chain(row.uv);
        out += &row.face.to_string();
        numbers.for_each(|x| out += &format!("\t{x}"));
        out.push('\n');
    }
    print(&out);
    Ok(())
}
