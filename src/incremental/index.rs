//! What a rebuild does not keep: the way back from a vertex, a face or an edit to what stands where.

use super::colour::{uncount, Group};
use super::memory::{extend_to, fit_all, of, of_map, roomy, zeros};
use super::plan::Plan;
use super::slots::Slots;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::patch::PatchTable;
use crate::refine::edits::{resolve, resolve_paint, Move};
use crate::refine::meetings::Birth;
use crate::refine::{around_polygons, fate, Mode, Refinement, Rules};
use crate::scene::{Handle, Scene};
use crate::subdiv::edit::{frame, LocalMove};
use crate::subdiv::gather::Around;
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::{Level, CUT};
use std::collections::HashMap;

/// A geometry edit at its place in a level.
#[derive(Clone, Copy)]
pub(super) struct PlacedMove {
    /// Where; its coordinates are those of the scene's entry.
    pub local: LocalMove,
    /// Entry of [`Scene::geometry`].
    pub entry: u32,
    /// The vertex it moves and the two that its frame points to.
    pub vertices: [u32; 3],
}

/// Where a painted sector has its colour from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// Entry of [`Scene::colours`].
    Edit(u32),
    /// Entry of [`Scene::corner_colours`].
    Corner(u32),
}

/// Inverse indices of one level, and scratch that is clean between updates.
#[derive(Clone)]
pub(super) struct LevelIndex {
    pub around: Around,
    /// Half-edge one level up that each face grew from; empty at level 0.
    pub parent: Vec<u32>,
    /// Entry of each face in the table's faces, or [`NONE`].
    pub drawn: Vec<u32>,
    /// Geometry edits of the level in the order in which they are added.
    pub moves: Vec<PlacedMove>,
    /// Numbers of those that went.
    pub free_moves: Vec<u32>,
    /// Moves of a vertex, and moves whose frame reads it.
    pub moved: HashMap<u32, Vec<u32>>,
    pub read: HashMap<u32, Vec<u32>>,
    /// Colour edits of each vertex, and numbers of those that went.
    pub groups: Vec<Group>,
    pub free_groups: Vec<u32>,
    /// How many groups make a half-edge sharp; of no half-edge that none does.
    pub chained: HashMap<u32, u32>,
    /// Group that spreads over each vertex, or [`NONE`]. Empty without colour edits.
    pub painted: Vec<u32>,
    /// How many causes of the plan ask for each face to be refined ([`super::asked`]); empty until the plan is edited.
    pub asked: Vec<u32>,
    /// Numbers of faces and of values (vertices and tints) that are not there any more.
    pub free_faces: Vec<u32>,
    pub free_values: Vec<u32>,
    /// Scratch, by vertex.
    pub vertex_mark: Vec<u32>,
    /// Scratch, by face.
    pub face_mark: Vec<u32>,
}

impl LevelIndex {
    fn new(level: &Level, parent: Vec<u32>, drawn: Vec<u32>) -> LevelIndex {
        LevelIndex {
            around: Around::new(level),
            parent,
            drawn,
            moves: Vec::new(),
            free_moves: Vec::new(),
            moved: HashMap::new(),
            read: HashMap::new(),
            groups: Vec::new(),
            free_groups: Vec::new(),
            chained: HashMap::new(),
            painted: Vec::new(),
            asked: Vec::new(),
            free_faces: Vec::new(),
            free_values: Vec::new(),
            vertex_mark: zeros(level.vertices()),
            face_mark: zeros(level.faces()),
        }
    }
}

/// Inverse indices of a refined scene and its patches. See [`Index::new`].
#[derive(Clone)]
pub struct Index {
    pub(super) levels: Vec<LevelIndex>,
    /// Where each edited point of M^0 goes: its entry in the handles or (true) in the face points.
    pub(super) placed: HashMap<u32, (bool, u32)>,
    /// Point of M^0 of each entry that holds.
    pub(super) point_of: HashMap<(bool, u32), u32>,
    /// Half-edges that leave each input vertex.
    pub(super) input: Around,
    /// Level of each geometry edit that is applied, and its place among the level's moves.
    pub(super) move_of: HashMap<u32, (u32, u32)>,
    /// Level and group of each colour edit that is applied.
    pub(super) group_of: HashMap<u32, (u32, u32)>,
    /// Entries of [`Scene::colours`] of each vertex, ascending; of no vertex that has none.
    pub(super) entries: HashMap<Birth, Vec<u32>>,
    /// How many tags each input edge has, by the lesser half-edge; of no edge that has none.
    pub(super) tags: HashMap<u32, u32>,
    /// Vertices of M^0 around faces that are no quads.
    pub(super) around_polygons: Vec<bool>,
    /// The table's patches and points.
    pub(super) slots: Slots,
    /// The plan by its causes, once it was edited.
    pub(super) plan: Option<Box<Plan>>,
    /// Last number used to mark scratch.
    pub(super) epoch: u32,
}

impl Index {
    /// Indices for a refined scene and the table that was built of it. Time and memory linear in the levels. Room that
    /// building left in both is given back, as one table and its levels are kept from now on.
    ///
    /// # Panics
    /// If the refinement is not that of the scene.
    pub fn new(scene: &Scene, mesh: &HalfEdgeMesh, refinement: &mut Refinement, table: &mut PatchTable) -> Index {
        fit_all(refinement, table);
        let mut drawn = 0;
        let mut levels: Vec<LevelIndex> = Vec::new();
        for (l, (level, fates)) in refinement.levels.iter().zip(&refinement.fates).enumerate() {
            let above = l.checked_sub(1).map(|l| &refinement.levels[l]);
            let mut parent = zeros(above.map_or(0, |_| level.faces()));
            for (h, &c) in above.iter().flat_map(|a| a.child.iter().enumerate()) {
                if c < CUT {
                    parent[c as usize] = h as u32;
                }
            }
            let numbers = fates.iter().enumerate().map(|(f, &fate)| {
                if fate & fate::DRAWN != 0 && level.valence(f as u32) == 4 {
                    drawn += 1;
                    drawn - 1
                } else {
                    NONE
                }
            });
            levels.push(LevelIndex::new(level, parent, roomy(numbers)));
        }
        assert_eq!(drawn as usize, table.faces.len(), "the table belongs to the refinement");
        let numbers: Vec<u32> =
            levels.iter().flat_map(|l| (0..).zip(&l.drawn).filter(|d| *d.1 != NONE).map(|d| d.0)).collect();
        let slots = Slots::new(table, levels.len(), &numbers);
        let input = Level { origin: mesh.origin.clone(), bits: vec![0; mesh.positions.len()], ..Level::default() };
        let mut index = Index {
            levels,
            placed: HashMap::new(),
            point_of: HashMap::new(),
            input: Around::new(&input),
            move_of: HashMap::new(),
            group_of: HashMap::new(),
            entries: HashMap::new(),
            tags: HashMap::new(),
            around_polygons: around_polygons(&refinement.levels[0]),
            slots,
            plan: None,
            epoch: 0,
        };
        index.place_points(scene, mesh);
        index.place_moves(scene, mesh, refinement);
        scene.sharp.iter().for_each(|&h| index.count_tag(mesh, h, true));
        index.place_paints(scene, mesh, refinement);
        index
    }

    /// A further level without faces.
    pub(super) fn push_level(&mut self, level: &Level) {
        self.levels.push(LevelIndex::new(level, Vec::new(), Vec::new()));
    }

    pub(super) fn place_points(&mut self, scene: &Scene, mesh: &HalfEdgeMesh) {
        self.placed.clear();
        // Where two name one point, the later one holds.
        for (in_face, handles) in [(false, &scene.handles), (true, &scene.face_points)] {
            for (handle, i) in handles.iter().zip(0..) {
                let point = point_of(mesh, handle, in_face).expect("the scene was refined");
                self.placed.insert(point, (in_face, i));
            }
        }
        self.point_of = self.placed.iter().map(|(&point, &entry)| (entry, point)).collect();
    }

    fn place_moves(&mut self, scene: &Scene, mesh: &HalfEdgeMesh, refinement: &Refinement) {
        let edits = resolve(scene, &IndexMap::new(mesh)).expect("the scene was refined");
        // The same order as that of the resolved edits.
        let mut entries: Vec<u32> = (0..scene.geometry.len() as u32).collect();
        entries.sort_by_key(|&i| scene.geometry[i as usize].level);
        for (m, entry) in edits.moves.iter().zip(entries) {
            self.place_move(m, entry, refinement);
        }
    }

    /// Puts a geometry edit in its place; its level and the vertex that it moves, `None` where its level is not refined.
    pub(super) fn place_move(&mut self, m: &Move, entry: u32, refinement: &Refinement) -> Option<(u32, u32)> {
        let half_edge = local(refinement, m.level, m.slot)?;
        let local = LocalMove { half_edge, anchor: m.anchor, a: m.a, b: m.b };
        let level = &refinement.levels[m.level as usize];
        let (spoke, end1, end2) = frame(level, &local);
        let vertices = [level.origin[spoke as usize], end1, end2];
        let own = &mut self.levels[m.level as usize];
        let placed = PlacedMove { local, entry, vertices };
        let number = own.free_moves.pop().unwrap_or_else(|| {
            own.moves.push(placed);
            own.moves.len() as u32 - 1
        });
        own.moves[number as usize] = placed;
        // Where several move one vertex, steps are added in the order of the scene.
        let moves = &own.moves;
        let moved = own.moved.entry(vertices[0]).or_default();
        let place = moved.partition_point(|&n| moves[n as usize].entry < entry);
        moved.insert(place, number);
        for v in vertices {
            own.read.entry(v).or_default().push(number);
        }
        self.move_of.insert(entry, (m.level, number));
        Some((m.level, vertices[0]))
    }

    /// Takes a geometry edit from its place; its level and the vertex that it moved.
    pub(super) fn displace_move(&mut self, entry: u32) -> Option<(u32, u32)> {
        let (l, number) = self.move_of.remove(&entry)?;
        let own = &mut self.levels[l as usize];
        let m = &mut own.moves[number as usize];
        m.entry = NONE;
        own.free_moves.push(number);
        let vertices = m.vertices;
        for (i, v) in [0, 1, 2, 3].map(|i: usize| (i, vertices[i.saturating_sub(1)])) {
            let map = if i == 0 { &mut own.moved } else { &mut own.read };
            if let Some(list) = map.get_mut(&v) {
                list.retain(|&n| n != number);
                if list.is_empty() {
                    map.remove(&v);
                }
            }
        }
        Some((l, vertices[0]))
    }

    /// One tag more or less of an input edge; one of the boundary has no effect.
    pub(super) fn count_tag(&mut self, mesh: &HalfEdgeMesh, h: u32, more: bool) {
        let twin = mesh.twin[h as usize];
        match (twin != NONE, more) {
            (true, true) => *self.tags.entry(h.min(twin)).or_insert(0) += 1,
            (true, false) => uncount(&mut self.tags, h.min(twin)),
            _ => {}
        }
    }

    fn place_paints(&mut self, scene: &Scene, mesh: &HalfEdgeMesh, refinement: &Refinement) {
        let map = IndexMap::new(mesh);
        let mut paints: Vec<(u32, Birth, Slot, Source)> = Vec::new();
        let mut painted = vec![false; scene.corner_colours.len()];
        for (i, e) in scene.colours.iter().enumerate() {
            let p = resolve_paint(i, e, &map).expect("the scene was refined");
            self.entries.entry(p.vertex).or_default().push(i as u32);
            paints.push((p.level, p.vertex, p.slot, Source::Edit(i as u32)));
            if p.level == 0 && !painted.is_empty() {
                painted[(p.slot >> 3) as usize] = true;
            }
        }
        for (h, _) in painted.iter().enumerate().filter(|&(_, &edited)| !edited) {
            let slot = 8 * h as u64;
            paints.push((0, map.birth(0, slot), slot, Source::Corner(h as u32)));
        }
        paints.sort_by_key(|p| (p.0, p.1));
        for same in paints.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let l = same[0].0;
            let sectors = same.iter().map(|p| (p.2, p.3)).collect();
            let Some((_, g)) = self.place_group(l, sectors, refinement) else { continue };
            let chain = self.chain_of(scene, mesh, &refinement.levels, l as usize, g);
            let own = &mut self.levels[l as usize];
            chain.iter().for_each(|&h| *own.chained.entry(h).or_insert(0) += 1);
            own.groups[g as usize].chain = chain;
        }
    }

    /// Puts the colour edits of one vertex at one level in their place; level and group. `None`: the level is not refined
    /// there.
    pub(super) fn place_group(
        &mut self,
        l: u32,
        sectors: Vec<(Slot, Source)>,
        refinement: &Refinement,
    ) -> Option<(u32, u32)> {
        let mut paints = Vec::with_capacity(sectors.len());
        for (slot, source) in sectors {
            paints.push((local(refinement, l, slot)?, source));
        }
        let first = paints.first()?.0;
        let level = &refinement.levels[l as usize];
        let v = level.origin[first as usize];
        let own = &mut self.levels[l as usize];
        extend_to(&mut own.painted, level.value.len(), NONE);
        let group = own.free_groups.pop().unwrap_or_else(|| {
            own.groups.push(Group::default());
            own.groups.len() as u32 - 1
        });
        for &h in own.around.of(v) {
            for v in one_ring(level, h) {
                own.painted[v as usize] = group;
            }
        }
        for (_, source) in &paints {
            if let Source::Edit(i) = source {
                self.group_of.insert(*i, (l, group));
            }
        }
        own.groups[group as usize] = Group { paints, chain: Vec::new() };
        Some((l, group))
    }

    /// Takes the colour edits of the vertex that a slot leaves from their place, if it has any at that level: the vertices
    /// that they coloured or whose edges they made sharp.
    pub(super) fn displace_group(&mut self, l: u32, slot: Slot, refinement: &Refinement) -> Option<Vec<u32>> {
        let h = local(refinement, l, slot)?;
        let level = &refinement.levels[l as usize];
        let v = level.origin[h as usize];
        let own = &mut self.levels[l as usize];
        let group = own.painted.get(v as usize).copied().filter(|&g| g != NONE)?;
        let Group { paints, chain } = std::mem::take(&mut own.groups[group as usize]);
        own.free_groups.push(group);
        for (_, source) in &paints {
            if let Source::Edit(i) = source {
                self.group_of.remove(i);
            }
        }
        let mut vertices: Vec<u32> = own.around.of(v).iter().flat_map(|&h| one_ring(level, h)).collect();
        vertices.iter().for_each(|&v| own.painted[v as usize] = NONE);
        for &h in &chain {
            uncount(&mut own.chained, h);
            vertices.push(level.origin[h as usize]);
        }
        Some(vertices)
    }

    /// Entries of the scene's colour edits from `from` on move by `by` places.
    pub(super) fn renumber_colours(&mut self, from: u32, by: i64) {
        if by == 0 {
            return;
        }
        let moved = |i: u32| if i >= from { (i64::from(i) + by) as u32 } else { i };
        self.group_of = self.group_of.iter().map(|(&entry, &place)| (moved(entry), place)).collect();
        let groups = self.levels.iter_mut().flat_map(|own| &mut own.groups);
        for source in groups.flat_map(|group| &mut group.paints).map(|p| &mut p.1) {
            if let Source::Edit(i) = source {
                *i = moved(*i);
            }
        }
    }

    /// Entries of the scene's geometry edits from `from` on, of which there are some, move by `by` places.
    pub(super) fn renumber(&mut self, from: u32, by: i64) {
        if by == 0 {
            return;
        }
        self.move_of.clear();
        for (own, l) in self.levels.iter_mut().zip(0..) {
            for (m, number) in own.moves.iter_mut().zip(0..).filter(|m| m.0.entry != NONE) {
                if m.entry >= from {
                    m.entry = (i64::from(m.entry) + by) as u32;
                }
                self.move_of.insert(m.entry, (l, number));
            }
        }
    }

    /// Whether a vertex of a level is not there any more.
    pub(super) fn has_left(&self, l: usize, v: u32) -> bool {
        self.levels[l].around.of(v).is_empty()
    }

    /// Whether edits have left more room in the table than there are patches.
    pub fn is_fragmented(&self, table: &PatchTable) -> bool {
        self.slots.is_fragmented(table)
    }

    /// Whether more than an eighth of the table is room that edits left: worth a fresh one when there is time for it.
    pub fn is_loose(&self, table: &PatchTable) -> bool {
        self.slots.is_loose(table)
    }

    /// The ways back from a scene's edits to its patches, and what tells which faces edits asked for: all that a first edit
    /// would make. Linear in the levels.
    pub fn ready(
        scene: &Scene,
        mesh: &HalfEdgeMesh,
        refinement: &mut Refinement,
        table: &mut PatchTable,
        mode: Mode,
    ) -> Index {
        let mut index = Index::new(scene, mesh, refinement, table);
        if let (Mode::Adaptive { isolate }, Rules::Gradtess) = (mode, refinement.rules) {
            index.make_plan(scene, mesh, refinement, isolate);
            index.count_stars(scene, mesh);
        }
        index
    }

    /// Control points of the table that are drawn with.
    pub fn points(&self) -> usize {
        self.slots.points()
    }

    /// Number that no scratch holds yet.
    pub(super) fn next_epoch(&mut self) -> u32 {
        if self.epoch == u32::MAX {
            for level in &mut self.levels {
                level.vertex_mark.fill(0);
                level.face_mark.fill(0);
            }
            self.epoch = 0;
        }
        self.epoch += 1;
        self.epoch
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let level = |l: &LevelIndex| {
            let lists = [&l.parent, &l.drawn, &l.painted, &l.vertex_mark, &l.face_mark, &l.asked];
            let free = [&l.free_faces, &l.free_values, &l.free_groups];
            let groups: usize = l.groups.iter().map(|g| of(&g.paints) + of(&g.chain)).sum();
            let edits = [&l.moved, &l.read];
            let lists_of_edits = edits.iter().flat_map(|map| map.values()).map(of).sum::<usize>();
            l.around.bytes()
                + lists.into_iter().chain(free).map(of).sum::<usize>()
                + edits.into_iter().map(of_map).sum::<usize>()
                + lists_of_edits
                + of(&l.groups)
                + groups
                + of_map(&l.chained)
                + of(&l.moves)
        };
        self.input.bytes()
            + self.levels.iter().map(level).sum::<usize>()
            + self.slots.bytes()
            + of_map(&self.placed)
            + of_map(&self.point_of)
            + of_map(&self.move_of)
            + of_map(&self.group_of)
            + of_map(&self.entries)
            + self.entries.values().map(of).sum::<usize>()
            + of_map(&self.tags)
            + of(&self.around_polygons)
            + self.plan.as_ref().map_or(0, |plan| plan.bytes())
    }
}

/// The vertices that a colour at the sector of `h` goes to.
fn one_ring(level: &Level, h: u32) -> [u32; 4] {
    let a = level.next(h);
    [h, a, level.next(a), level.prev(h)].map(|g| level.origin[g as usize])
}

/// Vertex of M^0 that a handle places, `None` where there is no such half-edge.
pub(super) fn point_of(mesh: &HalfEdgeMesh, handle: &Handle, in_face: bool) -> Option<u32> {
    let edges = mesh.half_edges() + mesh.boundary_edges();
    let (first, count) = if in_face { (mesh.vertices() + edges, mesh.half_edges()) } else { (mesh.vertices(), edges) };
    (handle.half_edge < count).then(|| first + handle.half_edge)
}

/// Half-edge of a slot in its level, `None` where the face is not there.
fn local(refinement: &Refinement, level: u32, slot: Slot) -> Option<u32> {
    let mut h = (slot >> (2 * level)) as u32;
    for l in 0..level {
        let child = *refinement.levels.get(l as usize)?.child.get(h as usize)?;
        if child >= CUT {
            return None;
        }
        h = 4 * child + (slot >> (2 * (level - l - 1)) & 3) as u32;
    }
    refinement.levels.get(level as usize).map(|_| h)
}
