//! Whether two tables draw the same, whatever the order of their patches and points.

use gradtess::patch::{Face, Kind, PatchTable};
use std::collections::{BTreeMap, HashMap};

/// Every patch of every range: what draws it, and its control points.
fn patches(table: &PatchTable) -> Vec<(Kind, Option<u8>, u32, Vec<u64>)> {
    let mut all = Vec::new();
    for range in &table.ranges {
        let first = range.first as usize;
        for patch in table.indices[first..first + range.count as usize * range.stride()].chunks_exact(range.stride()) {
            let bits = patch.iter().flat_map(|&i| table.control[i as usize].map(f64::to_bits)).collect();
            all.push((range.kind, range.part, range.level, bits));
        }
    }
    all.sort_unstable();
    all
}

/// Faces with their own points, by level and name.
fn faces(table: &PatchTable) -> BTreeMap<(u32, u64), (Face, &[u32])> {
    let points = |f: &Face| &table.indices[f.first as usize..f.first as usize + f.kind.points()];
    table.faces.iter().map(|f| ((f.level, f.name), (Face { first: 0, ..*f }, points(f)))).collect()
}

/// The same patches bit for bit, and the same points shared in the same way.
pub fn assert_same(table: &PatchTable, other: &PatchTable, what: &str) {
    let (a, b) = (faces(table), faces(other));
    assert_eq!((a.len(), table.faces.len()), (b.len(), other.faces.len()), "{what}");
    let mut twin: [HashMap<u32, u32>; 2] = Default::default();
    for ((name, (face, points)), (other_name, (other_face, others))) in a.iter().zip(&b) {
        assert_eq!((name, face), (other_name, other_face), "{what}");
        for (&i, &j) in points.iter().zip(*others) {
            assert_eq!(*twin[0].entry(i).or_insert(j), j, "{what}: {name:?} shares a point");
            assert_eq!(*twin[1].entry(j).or_insert(i), i, "{what}: {name:?} shares no point");
        }
    }
    let (a, b) = (patches(table), patches(other));
    for (a, b) in a.iter().zip(&b) {
        assert!(a == b, "{what}: a patch of {:?} or {:?}", (a.0, a.1, a.2), (b.0, b.1, b.2));
    }
    assert_eq!(a.len(), b.len(), "{what}");
}
