//! The one cast from f64 to f32: what the GPU gets of a patch table.

use super::{ControlPoint, PatchTable};
use crate::threads;

/// A patch table in the GPU's precision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedTable {
    /// Control points, 32 bytes each: two vec4.
    pub control: Vec<[f32; 8]>,
    /// Index arrays of all ranges, as in [`PatchTable::indices`].
    pub indices: Vec<u32>,
}

/// Rounds every channel of one control point, as [`pack`].
#[inline]
pub fn pack_point(point: &ControlPoint) -> [f32; 8] {
    point.map(|x| x as f32 + 0.0)
}

/// Rounds every channel to the nearest f32. Negative zero becomes zero, so that equal numbers are equal bits.
pub fn pack(table: &PatchTable) -> PackedTable {
    let mut packed = PackedTable::default();
    repack(table, &mut packed);
    packed
}

/// The same in memory that was used before, for the reason of [`super::build::rebuild`].
pub fn repack(table: &PatchTable, packed: &mut PackedTable) {
    threads::crew(table.faces.len(), || {
        threads::replace(&mut packed.control, &table.control, |p| pack_point(&p));
        threads::replace(&mut packed.indices, &table.indices, |i| i);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_zero_becomes_zero() {
        let table = PatchTable { control: vec![[-0.0; 8]], ..PatchTable::default() };
        assert_eq!(pack(&table).control[0].map(f32::to_bits), [0; 8]);
    }
}
