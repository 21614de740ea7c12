//! The whole refined mesh in a vertex buffer: the paper's rival, made on the CPU.

use super::PatternScene;
use crate::gpu::memory::bytes_of;
use crate::pattern::evaluate::evaluate;

/// The whole refined mesh: position, normal and colour of each vertex, and indices.
pub(super) fn refined(scene: &PatternScene) -> (Vec<u8>, Vec<u32>) {
    let each = scene.pattern.weights.len() as u32;
    let mut vertices: Vec<[f32; 12]> = Vec::with_capacity(scene.controls.len() * each as usize);
    let mut indices = Vec::with_capacity(scene.controls.len() * scene.pattern.indices.len());
    for (t, control) in (0..).zip(scene.controls) {
        for w in &scene.pattern.weights {
            let point = evaluate(control, scene.evaluator, scene.displacement, w.map(f64::from));
            let (p, n, c) = (point.position.as_vec3(), point.normal.as_vec3(), point.colour.as_vec4());
            vertices.push([p.x, p.y, p.z, 1.0, n.x, n.y, n.z, 0.0, c.x, c.y, c.z, c.w]);
        }
        indices.extend(scene.pattern.indices.iter().map(|i| t * each + i));
    }
    (bytes_of(&vertices).to_vec(), indices)
}
