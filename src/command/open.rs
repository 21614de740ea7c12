//! From a file name to refined levels and patches, with errors that name file and line.

use super::ferguson::open::Ferguson;
use super::pattern::open::Pattern;
use super::surface::open::Surface;
use super::{Failure, Global, ModeFlag, PatchesFlag, Refining, RulesFlag};
use crate::mesh::{self, HalfEdgeMesh, MeshError};
use crate::patch::build::build;
use crate::patch::points::Irregular;
use crate::patch::remap::Transitions;
use crate::patch::PatchTable;
use crate::refine::edits::EditError;
use crate::refine::{refine, refine_uncascaded, Mode, Options, RefineError, Refinement, Rules};
use crate::scene::{read_bounded, technique, Scene, SceneError, Technique};
use std::path::Path;
use std::time::Instant;

/// A scene of any technique, ready for a command: one variant a technique. Commands match on it in their `run`.
pub enum Subject {
    /// ZHHK22.
    Subdivision(Box<Loaded>),
    /// BLHK18.
    Ferguson(Box<Ferguson>),
    /// ZBK23.
    Surface(Box<Surface>),
    /// BS05.
    Pattern(Box<Pattern>),
}

impl Subject {
    /// Reads a scene of whatever technique its content says, and builds its half-edges.
    pub fn open(file: &str, global: &Global) -> Result<Subject, Failure> {
        let bytes = read_bounded(Path::new(file))?;
        match technique(&bytes) {
            Technique::Ferguson => Ok(Subject::Ferguson(Box::new(Ferguson::load(file, &bytes, global)?))),
            Technique::Surface => Ok(Subject::Surface(Box::new(Surface::load(file, &bytes, global)?))),
            Technique::Pattern => Ok(Subject::Pattern(Box::new(Pattern::load(file, &bytes, global)?))),
            // Its reader refuses what is none of it.
            Technique::Subdivision => Ok(Subject::Subdivision(Box::new(load_bytes(file, &bytes, global)?))),
        }
    }

    /// The technique.
    pub fn technique(&self) -> Technique {
        match self {
            Subject::Subdivision(_) => Technique::Subdivision,
            Subject::Ferguson(_) => Technique::Ferguson,
            Subject::Surface(_) => Technique::Surface,
            Subject::Pattern(_) => Technique::Pattern,
        }
    }

    /// What a command says that does not go with this technique; `file` as the user named it.
    pub fn refused(&self, file: &str) -> Failure {
        let name = self.technique().name();
        Failure::input(format_args!(
            "{file}: this command does not go with scenes of technique {name}; give another scene"
        ))
    }
}

/// A scene whose polygons are a manifold.
pub struct Loaded {
    /// As the user named it.
    pub file: String,
    /// The scene.
    pub scene: Scene,
    /// Its mesh.
    pub mesh: HalfEdgeMesh,
}

/// What refinement and patch building made of a scene, and how long that took.
pub struct Patched {
    /// Levels.
    pub refinement: Refinement,
    /// Patches; those of transition faces as constellations.
    pub table: PatchTable,
    /// How transition faces are drawn.
    pub transitions: Transitions,
    /// Wall time of refinement, ms.
    pub refine_ms: f64,
    /// Wall time of the patch table, ms.
    pub patch_ms: f64,
}

fn load_bytes(file: &str, bytes: &[u8], global: &Global) -> Result<Loaded, Failure> {
    let scene = Scene::parse(bytes, file)?;
    let mesh = mesh::build(&scene.mesh).map_err(|e| mesh_failure(file, &scene, &e))?;
    for note in mesh::shape_notes(&mesh) {
        global.warn(format_args!("{file}: {note}"));
    }
    Ok(Loaded { file: file.to_owned(), scene, mesh })
}

fn mesh_failure(file: &str, scene: &Scene, e: &MeshError) -> Failure {
    let line = e.face().and_then(|f| scene.mesh.face_line.get(f as usize)).copied().unwrap_or(1);
    at_line(file, line, e, "correct the polygons")
}

/// A failure of later rooms at a line of the scene; `e` says what, and after a semicolon what to do.
pub fn at_line(file: &str, line: u32, e: &impl std::fmt::Display, fix: &str) -> Failure {
    let text = e.to_string();
    let (what, fix) = text.split_once("; ").unwrap_or((&text, fix));
    SceneError::content(file, line as usize, 1, what, fix).into()
}

fn refine_failure(loaded: &Loaded, e: &RefineError) -> Failure {
    let lines = &loaded.scene.edit_lines;
    let (list, index) = match e {
        RefineError::Edit(EditError::NoSuchHalfEdge { what, index, .. } | EditError::TooDeep { what, index, .. }) => {
            (if *what == "colour" { &lines.colours } else { &lines.geometry }, *index)
        }
        RefineError::Edit(EditError::NotOnBoundary { index, .. }) => (&lines.geometry, *index),
        RefineError::Edit(EditError::NotAColourVertex { index, .. }) => (&lines.colours, *index),
        RefineError::TooLarge { .. } | RefineError::TooDeep { .. } => return Failure::input(e),
    };
    at_line(&loaded.file, list.get(index).copied().unwrap_or(1), e, "correct the edit")
}

/// Nanoseconds as milliseconds; divided, so that six decimals are printed and no more.
pub fn milliseconds(ns: u128) -> f64 {
    ns as f64 / 1e6
}

/// Rule set of a flag.
pub fn rules(flag: RulesFlag) -> Rules {
    match flag {
        RulesFlag::Authors => Rules::Authors,
        RulesFlag::Gradtess => Rules::Gradtess,
    }
}

impl Loaded {
    /// Refines by explicit options.
    pub fn refine(&self, options: Options) -> Result<Refinement, Failure> {
        refine(&self.scene, &self.mesh, options).map_err(|e| refine_failure(self, &e))
    }

    /// Deepest edit level, at least 1 where M^0 has faces that no patch draws.
    pub fn global_level(&self) -> u32 {
        let edits = self.scene.geometry.iter().map(|e| e.level).chain(self.scene.colours.iter().map(|e| e.level));
        edits.max().unwrap_or(0).max(u32::from(self.has_polygons()))
    }

    fn has_polygons(&self) -> bool {
        (0..self.mesh.faces()).any(|f| self.mesh.valence(f) != 4)
    }

    /// Refinement options of the flags.
    pub fn options(&self, flags: &Refining) -> Result<Options, Failure> {
        let mode = match flags.mode {
            ModeFlag::Adaptive if flags.level.is_some() => {
                return Err(Failure::input(
                    "--level goes with --mode global; adaptive refinement ends where the edits do",
                ))
            }
            ModeFlag::Adaptive => Mode::Adaptive { isolate: flags.isolate },
            ModeFlag::Global => {
                let level = flags.level.unwrap_or_else(|| self.global_level());
                if level == 0 && self.has_polygons() {
                    return Err(Failure::input(
                        "level 0 has faces that are no quads, which no patch draws; use --level 1 or more",
                    ));
                }
                Mode::Global(level)
            }
        };
        if flags.isolate > 0 && (flags.rules == RulesFlag::Authors || flags.mode == ModeFlag::Global) {
            return Err(Failure::input("--isolate goes with --rules gradtess and --mode adaptive"));
        }
        if flags.no_cascade && (flags.rules == RulesFlag::Gradtess || flags.mode == ModeFlag::Global) {
            return Err(Failure::input("--no-cascade goes with --rules authors and --mode adaptive"));
        }
        if flags.isolate > crate::refine::edits::MAX_LEVEL {
            return Err(Failure::input(format_args!(
                "--isolate {} is too deep; at most {}",
                flags.isolate,
                crate::refine::edits::MAX_LEVEL
            )));
        }
        Ok(Options { rules: rules(flags.rules), mode })
    }

    /// Refines and builds patches as the flags say.
    pub fn patches(&self, flags: &Refining) -> Result<Patched, Failure> {
        let options = self.options(flags)?;
        let start = Instant::now();
        let refinement = match flags.no_cascade {
            false => self.refine(options)?,
            true => refine_uncascaded(&self.scene, &self.mesh).map_err(|e| refine_failure(self, &e))?,
        };
        let refined = Instant::now();
        let irregular = match flags.patches {
            PatchesFlag::Gregory => Irregular::Gregory,
            PatchesFlag::Bicubic => Irregular::Bicubic,
        };
        let table = build(&refinement, irregular);
        let built = Instant::now();
        Ok(Patched {
            refinement,
            table,
            transitions: Transitions::default(),
            refine_ms: milliseconds((refined - start).as_nanos()),
            patch_ms: milliseconds((built - refined).as_nanos()),
        })
    }
}

impl Loaded {
    /// Whether all edits fit the mesh.
    pub fn refine_check(&self) -> Result<(), Failure> {
        let map = crate::subdiv::index_map::IndexMap::new(&self.mesh);
        match crate::refine::edits::resolve(&self.scene, &map) {
            Ok(_) => Ok(()),
            Err(e) => Err(refine_failure(self, &e.into())),
        }
    }
}
