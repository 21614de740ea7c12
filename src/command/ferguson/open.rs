//! From the bytes of a gradient mesh to patches.

use crate::command::picture::{bounds, fit};
use crate::command::{Failure, Global, Refining};
use crate::ferguson::fit::Target;
use crate::ferguson::table::table;
use crate::ferguson::Mesh;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use crate::scene;

/// A gradient mesh as it was read.
pub struct Ferguson {
    /// The mesh.
    pub mesh: Mesh,
}

impl Ferguson {
    /// Reads JSON or SVG from the `bytes` of `file`; what was left out is warned of.
    pub fn load(file: &str, bytes: &[u8], global: &Global) -> Result<Ferguson, Failure> {
        let (mesh, notes) = scene::ferguson::parse(bytes, file)?;
        for note in notes {
            global.warn(format_args!("{file}: {note}"));
        }
        Ok(Ferguson { mesh })
    }

    /// The rectangle around the mesh.
    pub fn bounds(&self) -> [f64; 4] {
        bounds(&table(&self.mesh, &Target::default())).unwrap_or([0.0, 0.0, 1.0, 1.0])
    }

    /// The view that is asked for, or all of the mesh.
    pub fn view(&self, asked: Option<[f64; 4]>, size: [u32; 2]) -> Result<[f64; 4], Failure> {
        match asked {
            Some(view) => Ok(view),
            None => fit(self.bounds(), size),
        }
    }

    /// The mesh subdivided as a view needs it, and its patches.
    pub fn patches(&self, rule: TessRule, view: [f64; 4], size: [u32; 2]) -> (Mesh, PatchTable, Target) {
        let target = target(rule, view, size);
        let fitted = self.mesh.fit(&target);
        let table = table(&fitted, &target);
        (fitted, table, target)
    }
}

/// What a picture of `size` pixels that shows `view` needs.
pub fn target(rule: TessRule, view: [f64; 4], size: [u32; 2]) -> Target {
    let scale = [f64::from(size[0]) / (view[2] - view[0]), f64::from(size[1]) / (view[3] - view[1])];
    Target { rule, scale, view: Some(view) }
}

/// Flags of subdivision meshes have no meaning here.
pub fn refuse(refining: &Refining) -> Result<(), Failure> {
    if refining.is_default() {
        return Ok(());
    }
    Err(Failure::input("--mode, --rules, --patches, --level and --isolate go with subdivision scenes; leave them out"))
}

/// The tessellation rule, where it makes sense.
pub fn rule(rule: TessRule) -> Result<TessRule, Failure> {
    match rule {
        TessRule::Base(_) => Err(Failure::input("--tess-base goes with subdivision scenes; use --tess or --pixels")),
        rule => Ok(rule),
    }
}
