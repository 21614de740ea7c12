//! Flags that say what picture to draw.

use super::{silent, Failure, Refining, TransitionsFlag};
use crate::camera::{Camera, Projection};
use crate::gpu::{Format, Frame, Gpu, Show};
use crate::image::Picture;
use crate::patch::eval::{side_points, sides};
use crate::patch::remap::Transitions;
use crate::patch::solid::Segments;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use clap::Args;
use glam::DVec3;
use std::path::Path;

/// What part of a scene is drawn, how large and how finely: the same flags for every command that draws.
#[derive(Args, Clone, Debug)]
pub struct PictureFlags {
    /// Pixels across and down [default: 1024x1024, of check 512x512]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Model rectangle X0,Y0,X1,Y1 that fills the picture; the whole scene and two pixels unless given
    #[arg(long, value_parser = view, allow_hyphen_values = true)]
    pub view: Option<[f64; 4]>,
    #[command(flatten)]
    pub camera: CameraFlags,
    #[command(flatten)]
    pub tess: Tess,
    /// How transition faces of gradient meshes are drawn
    #[arg(long, value_enum, default_value = "constellations")]
    transitions: TransitionsFlag,
    #[command(flatten)]
    pub refining: Refining,
}

impl PictureFlags {
    /// The frame of a scene in the plane by these flags: one sample a pixel, nothing under the surface. `size`: unless
    /// given.
    ///
    /// # Errors
    /// There are camera flags, or the coordinates are beyond what can be drawn.
    pub fn frame(&self, table: &PatchTable, size: [u32; 2]) -> Result<Frame, Failure> {
        self.camera.refuse()?;
        let size = self.size.unwrap_or(size);
        let view = match self.view {
            Some(view) => view,
            None => fit(bounds(table).unwrap_or([0.0, 0.0, 1.0, 1.0]), size)?,
        };
        Ok(Frame {
            width: size[0],
            height: size[1],
            view,
            tess: self.tess.rule(),
            show: Show::Surface,
            background: None,
            samples: 1,
            format: Format::Rgba8,
            statistics: false,
        })
    }
}

impl PictureFlags {
    /// How transition faces are drawn.
    pub fn transitions(&self) -> Transitions {
        self.transitions.into()
    }

    /// Refuses what only subdivision gradient meshes take.
    pub fn refuse_transitions(&self) -> Result<(), Failure> {
        match self.transitions() {
            Transitions::Constellations => Ok(()),
            _ => Err(Failure::input("--transitions goes with scenes of technique subdivision")),
        }
    }

    /// Segments of patches in space, where `--tess` or `--tess-base` asks for patches.
    pub fn segments(&self) -> Result<Option<Segments>, Failure> {
        let whole = |name: &str, t: f32| match (1.0..=64.0).contains(&t) && t.fract() == 0.0 {
            true => Ok(t as u32),
            false => Err(Failure::input(format_args!("{name} {t} is no whole number from 1 to 64"))),
        };
        match (self.tess.fixed, self.tess.base) {
            (Some(t), _) => Ok(Some(Segments::Fixed(whole("--tess", t)?))),
            (None, Some(t)) => Ok(Some(Segments::Base(whole("--tess-base", t)?))),
            (None, None) => Ok(None),
        }
    }

    /// Refuses flags that surfaces in space do not take.
    pub fn refuse_flat(&self) -> Result<(), Failure> {
        if self.view.is_some() {
            return Err(Failure::input("--view goes with scenes in the plane; use --orbit or --eye here"));
        }
        if self.tess.pixels.is_some() {
            return Err(Failure::input("--pixels goes with gradient meshes; use --tess or --tess-base here"));
        }
        Ok(())
    }

    /// Refuses flags that only scenes in the plane take.
    pub fn refuse_plane(&self) -> Result<(), Failure> {
        self.refuse_transitions()?;
        if self.view.is_some() {
            return Err(Failure::input("--view goes with scenes in the plane; use --orbit or --eye here"));
        }
        if self.tess.base.is_some() || self.tess.pixels.is_some() {
            return Err(Failure::input("--tess-base and --pixels go with gradient meshes; use --tess here"));
        }
        Ok(())
    }
}

/// Tessellation, by one of three rules.
#[derive(Args, Clone, Debug)]
#[group(multiple = false)]
pub struct Tess {
    /// Tessellation level of every patch, 1 to 64 [default: 16]
    #[arg(long = "tess", value_name = "T")]
    fixed: Option<f32>,
    /// Tessellation level T / 2^l of the patches of level l
    #[arg(long = "tess-base", value_name = "T")]
    base: Option<f32>,
    /// As many segments as make an edge's pieces P pixels long
    #[arg(long = "pixels", value_name = "P")]
    pixels: Option<f32>,
}

impl Tess {
    /// The rule asked for.
    pub fn rule(&self) -> TessRule {
        match (self.fixed, self.base, self.pixels) {
            (Some(t), _, _) => TessRule::Fixed(t),
            (_, Some(t), _) => TessRule::Base(t),
            (_, _, Some(p)) => TessRule::Pixels(p),
            _ => TessRule::Fixed(16.0),
        }
    }
}

/// Where a scene in space is seen from. Scenes in the plane take `--view` instead.
#[derive(Args, Clone, Debug, Default)]
pub struct CameraFlags {
    /// Look at the scene's middle from YAW degrees to the right and PITCH degrees above, as near as shows it whole [default: 30,20]
    #[arg(long, value_name = "YAW,PITCH", value_parser = pair, allow_hyphen_values = true, conflicts_with = "eye")]
    orbit: Option<[f64; 2]>,
    /// Distance from the point looked at, model units
    #[arg(long, value_name = "D", conflicts_with = "eye")]
    distance: Option<f64>,
    /// Eye
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Point looked at from --eye; the scene's middle unless given
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, requires = "eye")]
    target: Option<DVec3>,
    /// Upwards from --eye [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, requires = "eye")]
    up: Option<DVec3>,
    /// Projection [default: perspective]
    #[arg(long, value_enum)]
    projection: Option<ProjectionFlag>,
    /// Vertical angle of view of a perspective projection, degrees [default: 30]
    #[arg(long, value_name = "DEGREES")]
    fov: Option<f64>,
}

/// How depth becomes size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ProjectionFlag {
    /// Farther is smaller.
    Perspective,
    /// Depth does not matter.
    Orthographic,
}

impl CameraFlags {
    /// Refuses camera flags for a scene in the plane.
    pub fn refuse(&self) -> Result<(), Failure> {
        let given = [
            ("--orbit", self.orbit.is_some()),
            ("--distance", self.distance.is_some()),
            ("--eye", self.eye.is_some()),
            ("--projection", self.projection.is_some()),
            ("--fov", self.fov.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(Failure::input(format_args!("{name} goes with scenes in space; use --view here"))),
            None => Ok(()),
        }
    }

    /// Refuses camera flags where the views are random.
    pub fn refuse_any(&self) -> Result<(), Failure> {
        self.refuse().map_err(|_| Failure::input("cracks are looked for from random sides; leave out camera flags"))
    }

    /// The camera asked for. `bounds`: least and greatest corner of the scene; `size`: pixels.
    pub fn camera(&self, bounds: [DVec3; 2], size: [u32; 2]) -> Result<Camera, Failure> {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let fov = self.fov.unwrap_or(30.0);
        if !(fov > 0.0 && fov < 180.0) {
            return Err(Failure::input(format_args!("--fov {fov} is no angle of view; give one between 0 and 180")));
        }
        if self.distance.is_some_and(|d| !(d > 0.0 && d.is_finite())) {
            return Err(Failure::input("--distance must be above 0"));
        }
        let projection = match self.projection.unwrap_or(ProjectionFlag::Perspective) {
            ProjectionFlag::Orthographic if self.fov.is_some() => {
                return Err(Failure::input("--fov goes with --projection perspective"))
            }
            ProjectionFlag::Perspective => Projection::Perspective { fov },
            ProjectionFlag::Orthographic => Projection::Orthographic { height: 1.0 },
        };
        let Some(eye) = self.eye else {
            let [yaw, pitch] = self.orbit.unwrap_or([30.0, 20.0]);
            let camera = Camera::orbit(bounds, yaw, pitch, projection, aspect);
            return Ok(self.distance.map_or(camera, |d| camera.at_distance(d)));
        };
        let target = self.target.unwrap_or((bounds[0] + bounds[1]) * 0.5);
        let up = self.up.unwrap_or(DVec3::Y);
        let back = eye - target;
        if up.cross(back).length() <= 1e-9 * up.length() * back.length() {
            return Err(Failure::input("--eye, --target and --up do not make a view: it looks along --up or nowhere"));
        }
        let mut camera = Camera { eye, target, up, projection };
        if let Projection::Orthographic { .. } = projection {
            let radius = 0.5 * (bounds[1] - bounds[0]).length();
            camera.projection = Projection::Orthographic { height: 2.0 * radius / aspect.min(1.0) };
        }
        Ok(camera)
    }
}

/// Parses two finite numbers.
pub fn pair(text: &str) -> Result<[f64; 2], String> {
    numbers(text).ok_or_else(|| "give two numbers such as 30,20".to_string())
}

/// Parses three finite numbers.
pub fn triple(text: &str) -> Result<DVec3, String> {
    numbers(text).map(DVec3::from_array).ok_or_else(|| "give three numbers such as 0,1,0".to_string())
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Vec<f64> = text.split(',').map_while(|t| t.trim().parse().ok()).collect();
    let all = numbers.len() == text.split(',').count() && numbers.iter().all(|x: &f64| x.abs() <= 1e30);
    <[f64; N]>::try_from(numbers).ok().filter(|_| all)
}

/// Parses `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "give a width and a height in pixels, such as 1024x768".to_string();
    let (w, h) = text.split_once('x').ok_or_else(wrong)?;
    let [w, h]: [u32; 2] = [w.parse().map_err(|_| wrong())?, h.parse().map_err(|_| wrong())?];
    match (1..=65536).contains(&w) && (1..=65536).contains(&h) {
        true => Ok([w, h]),
        false => Err("width and height go from 1 to 65536".to_string()),
    }
}

/// Parses `X0,Y0,X1,Y1`.
pub fn view(text: &str) -> Result<[f64; 4], String> {
    let numbers: Vec<f64> = text.split(',').map_while(|t| t.trim().parse().ok()).collect();
    match <[f64; 4]>::try_from(numbers) {
        Ok(v) if v.iter().all(|x| x.is_finite()) && v[2] > v[0] && v[3] > v[1] => Ok(v),
        _ => Err("give X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1".to_string()),
    }
}

/// Parses `none` or `#rrggbb`.
pub fn background(text: &str) -> Result<Option<[f32; 4]>, String> {
    if text == "none" {
        return Ok(None);
    }
    let wrong = || "give 'none' or a colour such as #ffffff".to_string();
    let hex = text.strip_prefix('#').filter(|h| h.len() == 6 && h.is_ascii()).ok_or_else(wrong)?;
    let byte =
        |i: usize| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).map(|b| f32::from(b) / 255.0).map_err(|_| wrong());
    Ok(Some([byte(0)?, byte(1)?, byte(2)?, 1.0]))
}

/// Smallest rectangle around the patches' edges: x0, y0, x1, y1; `None` without patches.
pub fn bounds(table: &PatchTable) -> Option<[f64; 4]> {
    let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for range in &table.ranges {
        for patch in
            table.indices[range.first as usize..][..range.count as usize * range.stride()].chunks(range.stride())
        {
            for i in 0..sides(range.part) {
                let Some(q) = side_points(range.kind, range.part, i) else { continue };
                for axis in 0..2 {
                    let [low, high] = extent(q.map(|s| table.control[patch[s] as usize][axis]));
                    b[axis] = b[axis].min(low);
                    b[axis + 2] = b[axis + 2].max(high);
                }
            }
        }
    }
    (b[0] <= b[2]).then_some(b)
}

/// Least and greatest value of a cubic on [0, 1].
fn extent(p: [f64; 4]) -> [f64; 2] {
    let (mut low, mut high) = (p[0].min(p[3]), p[0].max(p[3]));
    // The derivative over three: a t^2 + b t + c.
    let (d0, d1, d2) = (p[1] - p[0], p[2] - p[1], p[3] - p[2]);
    let (a, b, c) = (d0 - 2.0 * d1 + d2, 2.0 * (d1 - d0), d0);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    // Both forms: one of them is stable whatever the size of a.
    let q = -0.5 * (b + root.copysign(b));
    for t in [q / a, c / q] {
        if t > 0.0 && t < 1.0 {
            let s = 1.0 - t;
            let x = s * s * s * p[0] + 3.0 * s * s * t * p[1] + 3.0 * s * t * t * p[2] + t * t * t * p[3];
            (low, high) = (low.min(x), high.max(x));
        }
    }
    [low, high]
}

/// The view that shows `bounds` whole, undistorted and centred, two pixels from the nearest border.
pub fn fit(bounds: [f64; 4], [w, h]: [u32; 2]) -> Result<[f64; 4], Failure> {
    let [x0, y0, x1, y1] = bounds;
    let across = |pixels: u32| f64::from(pixels.saturating_sub(4).max(1));
    let mut unit = ((x1 - x0) / across(w)).max((y1 - y0) / across(h));
    if unit == 0.0 {
        unit = 1.0;
    }
    let (cx, cy) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let (dx, dy) = (0.5 * unit * f64::from(w), 0.5 * unit * f64::from(h));
    let view = [cx - dx, cy - dy, cx + dx, cy + dy];
    if view.iter().all(|x| x.is_finite()) && view[0] < view[2] && view[1] < view[3] {
        Ok(view)
    } else {
        Err(Failure::input(
            "the scene's coordinates are too large or too close together to draw; scale them to moderate numbers",
        ))
    }
}

/// Writes a picture with what made it, unless the validation layer has something to say of it.
pub fn deliver(picture: &Picture, output: &Path, gpu: &Gpu) -> Result<(), Failure> {
    silent(gpu)?;
    let software = concat!("gradtess ", env!("CARGO_PKG_VERSION"));
    Ok(picture.write_png(output, &[("Software", software), ("Comment", &gpu.device().driver)])?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_bulges_between_its_ends() {
        let [low, high] = extent([0.0, 1.0, 1.0, 0.0]);
        assert_eq!((low, high), (0.0, 0.75));
        assert_eq!(extent([0.0, 1.0, 2.0, 3.0]), [0.0, 3.0]);
        let s = extent([0.0, 4.0, -3.0, 1.0]);
        assert!(s[0] < 0.0 && s[1] > 1.0);
    }

    #[test]
    fn flags_are_read_or_refused() {
        assert_eq!(size("64x32"), Ok([64, 32]));
        assert!(size("0x5").is_err() && size("5").is_err() && size("99999999x1").is_err());
        assert_eq!(view("0,0,1,2"), Ok([0.0, 0.0, 1.0, 2.0]));
        assert!(view("0,0,0,2").is_err() && view("0,0,1").is_err() && view("0,0,nan,1").is_err());
        assert_eq!(background("#ff0000"), Ok(Some([1.0, 0.0, 0.0, 1.0])));
        assert!(background("#ff00").is_err() && background("red").is_err() && background("#ée12").is_err());
    }
}
