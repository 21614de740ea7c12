//! Hierarchical subdivision gradient meshes, drawn by hardware tessellation on Vulkan.
//!
//! A gradient mesh is a set of polygons with colours that vary smoothly over curved faces. This crate takes one of any
//! manifold topology, with edits on several levels of subdivision (ZHHK22), refines it only where an edit or an irregular
//! vertex asks for it, turns what is left into bicubic and Gregory patches, and lets the tessellator draw those. Every
//! stage can be looked at, timed and compared with the exact limit surface.
//!
//! # The flow of data
//!
//! One way, plain data between the rooms. [`patch::PatchTable`] is the one seam: nothing left of it names Vulkan, nothing
//! right of it knows half-edges.
//!
//! ```text
//!  file                    polygons,              which faces at       control points,       tessellator
//!  .json .obj              half-edges             which level          index lists           .png, times
//!    |                         |                      |                     |                     |
//!    v                         v                      v                     v                     v
//!  scene ----------------->  mesh ----------------> refine ------------> patch ---------------->  gpu
//!  Scene: polygons,          HalfEdgeMesh             |   Refinement:      |  PatchTable           |  Picture
//!  colours, edits              |                      |   Level per M^l,   |                       |
//!                              +----> subdiv <--------+   fate per face    +-----> check           image
//!                                     T, C, limits,                        CPU evaluator,
//!                                     names of M^l                         exact limit, cracks
//! ```
//!
//! | room | holds |
//! |---|---|
//! | [`scene`] | what the user hands in; the readers and writers of every format, SVG included |
//! | [`mesh`] | polygons as half-edges, and every way in which they can fail to be a manifold |
//! | [`subdiv`] | the ternary step, Catmull-Clark, edits, limit points, and the numbering of every M^l |
//! | [`refine`](mod@refine) | which faces are affected, and the meshes of the levels |
//! | [`ferguson`] | locally refinable gradient meshes (BLHK18): curves and patches with T-sections, exact splits, edits |
//! | [`patch`] | control points, transition parts, the CPU evaluator, the cast to single precision |
//! | [`incremental`] | what an edit touches: values of kept levels, control points of kept patches |
//! | [`pattern`] | generic mesh refinement (BS05): refinement patterns, curved PN and scalar tagged triangles, displacement |
//! | [`camera`] | eyes for scenes in space |
//! | [`gpu`] | devices, pipelines, pictures, times, read-back; the only room with `unsafe` |
//! | [`check`] | the limit by a road of its own; errors of pictures, folds, cracks |
//! | [`threads`] | work in pieces for several cores, in an order that their number does not change |
//! | [`timing`] | frame timings as plain data: protocol, statistics, the files of a run |
//! | [`vector`] | patches as PDF pages |
//! | [`image`] | PNG files and their comparison |
//! | [`mod@edit`] | an editor's operations without a window: handles, limit editing, influence, folds, undo, journal |
//! | [`app`] | the editor's window; the only room that knows egui |
//! | [`command`] | the command line |
//! | [`surface`] | ZBK23: levels of surfaces in space, their normals and blend weights |
//! | [`repro`] | the papers' tables and figures, made by running commands |
//!
//! # Conventions
//!
//! * **Plane.** x right, y up, as in the models of the paper. Pixels count from the top left.
//! * **Orientation.** Either is accepted and kept, because edits name half-edges; "counter-clockwise" in the code is
//!   combinatorial. Faces of different orientation in one component are an error.
//! * **Half-edges.** Interior ones come first, face by face, and the k-th half-edge of a face *ends* in its k-th vertex;
//!   boundary ones have the greatest numbers (App. A). Files and reports use the numbers of App. A; inside, a half-edge
//!   goes by its *slot*, in which the children of face `h` are `4 h` to `4 h + 3`. [`subdiv::index_map`] translates and
//!   has the picture.
//! * **Levels.** M^0 is the mesh after the ternary step, M^l the one after l steps of Catmull-Clark.
//! * **Patches.** Corners A, B, C, D, the domain and the order of the 16 and 20 control points are drawn once, in
//!   [`patch`], and hold for the CPU and for GLSL.
//! * **Colour.** Kept as the file gives it (sRGB, straight alpha) and interpolated in that space as the paper does;
//!   clamped at output only. A vertex has one colour in each sector between sharp edges.
//! * **Precision.** Geometry is `f64`. The one cast to `f32` is [`patch::pack`].
//! * **Sums** that two neighbours both need run in an order that both share, so that seams have the same bits.
//!
//! # Papers
//!
//! Code and messages cite papers by these keys (bare, because rustdoc reads brackets as links).
//!
//! | key | paper |
//! |---|---|
//! | ZHHK22 | J. Zhou, G. J. Hettinga, S. Houwink, J. Kosinka: Feature-Adaptive and Hierarchical Subdivision Gradient Meshes. Computer Graphics Forum 41(1), 2022 |
//! | BLHK18 | P. J. Barendrecht, M. Luinstra, J. Hogervorst, J. Kosinka: Locally refinable gradient meshes supporting branching and sharp colour transitions. The Visual Computer 34, 2018 |
//! | ZBK23 | J. Zhou, J. Boonstra, J. Kosinka: Subdivision Shading for Catmull-Clark and Loop Subdivision Surfaces with Semi-Sharp Creases. Computers 12(4), 2023 |
//! | BS05 | T. Boubekeur, C. Schlick: Generic Mesh Refinement on GPU. Graphics Hardware 2005 |
//! | LKSD17 | H. Lieng, J. Kosinka, J. Shen, N. A. Dodgson: A Colour Interpolation Scheme for Topologically Unrestricted Gradient Meshes. Computer Graphics Forum 36, 2017 |
//! | VK18 | T. W. Verstraaten, J. Kosinka: Local and Hierarchical Refinement for Subdivision Gradient Meshes. Computer Graphics Forum 37, 2018 |
//! | NLMD12 | M. Nießner, C. Loop, M. Meyer, T. DeRose: Feature-Adaptive GPU Rendering of Catmull-Clark Subdivision Surfaces. ACM Transactions on Graphics 31(1), 2012 |
//! | LSNC09 | C. Loop, S. Schaefer, T. Ni, I. Castaño: Approximating Subdivision Surfaces with Gregory Patches for Hardware Tessellation. ACM Transactions on Graphics 28(5), 2009 ("ACC2") |
//! | LS08 | C. Loop, S. Schaefer: Approximating Catmull-Clark Subdivision Surfaces with Bicubic Patches. ACM Transactions on Graphics 27(1), 2008 ("ACC1") |
//! | DKT98 | T. DeRose, M. Kass, T. Truong: Subdivision Surfaces in Character Animation. SIGGRAPH 1998 |
//! | GD01 | J. E. Gain, N. A. Dodgson: Preventing Self-Intersection under Free-Form Deformation. IEEE Transactions on Visualization and Computer Graphics 7(4), 2001 |
//! | DV21 | J. Dupuy, K. Vanhoey: A Halfedge Refinement Rule for Parallel Catmull-Clark Subdivision. High-Performance Graphics 2021 |
//!
//! # ZHHK22, piece by piece
//!
//! A dash says that the piece is not done here, or not yet.
//!
//! | in the paper | here |
//! |---|---|
//! | 3.1 mesh data structure | [`mesh::HalfEdgeMesh`]; gradient vectors are [`scene::Handle`]; extraordinary vertices are [`subdiv::level::vertex_bits::EXTRAORDINARY`] |
//! | 3.2 ternary step, Fig. 2 | [`subdiv::ternary::ternary`] |
//! | 3.3 M^l = C^l T M, eq. (1) | [`fn@refine::refine`] with [`refine::Mode::Global`]; one step is [`subdiv::catmull_clark::refine`]; `gradtess mesh` |
//! | 3.3 edits in local frames, Fig. 3 | [`scene::GeometryEdit`], [`subdiv::edit::move_vertices`]; the coordinates of a given step: [`subdiv::edit::sector_coordinates`] |
//! | 3.3 angle and length, eq. (2) | [`subdiv::edit::Anchor::Boundary`] |
//! | 3.3 vertices whose colour may be edited | [`subdiv::index_map::IndexMap::is_colour_vertex`] |
//! | 3.4 feature-adaptive subdivision; factor t / 2^l | [`patch::tess::TessRule::Base`]; its other rules are [`patch::tess::TessRule::Fixed`] and [`patch::tess::TessRule::Pixels`] |
//! | 3.4 transition patches, Fig. 4 | [`patch::transition`]; `repro --only zhhk22-fig4`; their rival, one pipeline with remapped edges: [`patch::remap`], `--transitions remap`, `repro --only remap` |
//! | 4.1 which faces are drawn at which level, Fig. 5 | [`refine::fate`], [`refine::Refinement`]; `repro --only fig5` |
//! | 4.2 edited faces, Fig. 6 | [`refine::forest::plan`]; `scenes/unit/geometry_level_2.json`, `colour_level_2.json`; `repro --only zhhk22-fig6` |
//! | 4.2 submeshes and padding | [`subdiv::catmull_clark`], which makes the inner half of the ring only |
//! | 4.2 irregular faces, Fig. 7 | [`refine::forest::plan`]; `repro --only fig7` |
//! | 4.2 cascading, Fig. 8 | [`refine::forest::plan`] (rules gradtess); level by level in [`fn@refine::refine`] (rules authors). The ×200 picture: [`check::error_map`]; without: [`refine::refine_uncascaded`]; `repro --only fig8` |
//! | 4.3 patches: bicubic, Gregory, transition | [`patch::build`](mod@patch::build), [`patch::points`], [`patch::Kind`] |
//! | 4.4 sharp transitions and darts, Fig. 9 | [`subdiv::edit::paint`], [`subdiv::level::Level::colour_border`], [`subdiv::fan::colour_fan`]; `scenes/unit/sharp_dart.json`; `repro --only zhhk22-fig9` |
//! | 5.1 editing, brushes, region of influence, Fig. 10 | [`app`], [`mod@edit::brush`], [`mod@edit::influence`]; `gradtess edit` |
//! | 5.2 limit points are what is dragged | [`mod@edit::drag`], which also sees finer edits; [`subdiv::limit::control_for_limit`] |
//! | 5.2 self-intersection prevention, Fig. 11 | [`mod@edit::folds`] by [`check::folds`]; [`mesh::shape_notes`] warns of faces that are not convex (7.1); `repro --only fig11` |
//! | 6 Table 1 | `gradtess stats`; `tests/paper_models.rs`; `repro --only zhhk22-table1` |
//! | 6 difference from the limit in the RGB cube | [`check::picture_error`], [`check::limit_picture`]; `gradtess check`, `render --show error`; [`check::exact::ExactFace`]; `gradtess sample --exact` |
//! | 6 Fig. 1: the cherry | a cherry of our own, `scenes/cherry.json` |
//! | 6 Figs. 12 to 17: leek, pin, ball, butterfly, sunglasses, pear | 13 to 16: `repro --only zhhk22-fig13` and so on, the published models by `--models`, else scenes of our own; 12, 17: - the models are not published |
//! | 6 Fig. 18 | `scenes/triangle.json`, `quad.json`, `pentagon.json`, `hexagon.json`; `repro --only zhhk22-fig18` |
//! | 6 Fig. 19 | `scenes/unit/sharp_three_meet.json`, `sharp_two_meet.json`; `repro --only fig19` |
//! | 6 Figs. 20, 21: frame times | [`timing`], `gradtess bench`; `repro --only fig20,fig21` |
//! | 6 fixed tessellation factors | [`patch::tess`]; against screen-space ones at equal error: `repro --only pixels` |
//! | 7 irregular faces affected down to some level | [`refine::Mode::Adaptive`]'s `isolate`, [`refine::isolation`]; error against patches: `repro --only isolate` |
//! | 7 Fig. 22: bicubic against Gregory | [`patch::points::Irregular`], `--patches bicubic`; `repro --only fig22` |
//! | 7.2 local updates of the buffers, several cores | [`incremental`], [`gpu::Gpu::update_points`], [`gpu::Gpu::update_parts`], `bench --drag`, `repro --only drag`; [`threads`] |
//! | App. A index mapping, Fig. A.1 | [`subdiv::index_map`]; two errata below |
//! | App. B limit, (B.1), Fig. B.1 | [`subdiv::limit::limit`] |
//! | App. B inverse, (B.2) | [`subdiv::limit::control_for_limit`] |
//!
//! # ZBK23, piece by piece
//!
//! | in the paper | here |
//! |---|---|
//! | 2.1 rules at (semi-)sharp edges, Fig. 1 | [`surface::stencil`]; fractional sharpness by DKT98 |
//! | 2.2 subdivided normals N_S, linear averaging | [`surface::normal::refine_normals`] |
//! | 2.3 blending, eq. (1); control weights | [`surface::shade::shade`], [`surface::weight::Initial`] |
//! | 3.1 variants A and B, Fig. 3; 3.3 darts, Fig. 5 | [`surface::weight::Variant`], [`surface::weight::Darts`] |
//! | 3.2 semi-sharp vertices, Fig. 4 | [`surface::weight::control_weights`] |
//! | 3.4 regions, normals at sharp vertices, Fig. 6 | [`surface::region::Wedges`], [`surface::normal::given_normals`] |
//! | 3.5 `fs` and `as` lines | [`scene::surface`]; edited in [`app`] |
//! | 5 normals only where they count: 832 and 2304 of Spot's 46,850 | [`surface::normal::needed`], [`surface::weight::needing`]; `gradtess stats --level 4` |
//!
//! `repro --only zbk23` makes Figs. 1 to 6 and 8 to 13.
//!
//! Beyond the paper, [`surface::patches`] draws the limit of surfaces of both schemes with N_B at every vertex that the
//! tessellator makes (`render --tess 16`, `--scheme loop --tess 16`), refined by [`surface::adaptive`] (NLMD12); `gradtess bench`
//! compares both. Departures from the authors' tool, each with its reason, are listed in [`surface`].
//!
//! # BLHK18, piece by piece
//!
//! | in the paper | here |
//! |---|---|
//! | 3.1 curves, Hermite and Bezier form, eqs. (1) to (3) | [`ferguson::hermite`] |
//! | 3.1 Ferguson and Hermite patches, eq. (4), Fig. 5 | [`ferguson::Mesh::geometry`], [`ferguson::Mesh::colours`]; twists are kept |
//! | 3.2 colour blending, Fig. 4 | [`ferguson::blend`]; `"blend"` of a scene |
//! | 3.2 Fig. 6: other packages | our side: `g1` and bilinear; `repro` |
//! | 4 exact refinement, eq. (5), Figs. 7, 8, 9 | [`ferguson::split`], at any parameter; [`ferguson::merge`] takes splits back |
//! | 5.1 C^1 editing, T-sections, chain reactions, Fig. 10 | [`ferguson::edit`], [`ferguson::inherit`]; `scenes/ferguson/sections.json` |
//! | 5.2 C^0 editing, Fig. 11 | [`ferguson::inherit::Continuity::C0`] |
//! | 6.1 augmented half-edges, levels, shared handles, Fig. 12 | [`ferguson::mesh`] |
//! | 6.2 adaptive tessellation, even factors along T-sections, Fig. 13 | [`ferguson::fit`], [`patch::stitched`]; `check --zooms` |
//! | 6.2 virtual subdivision | [`ferguson::Mesh::fit`] |
//! | 7.1 branching, loops, holes, radial meshes, Fig. 15 | [`ferguson::Mesh::from_quads`]; `scenes/ferguson/branching.json`, `radial.json` |
//! | 7.2 sharp colours, Figs. 2, 16, 17 | [`ferguson::Mesh::set_sector_colour`]; `scenes/ferguson/sharp_colours.json`, `still_life.json` |
//! | 8 Table 1 | [`ferguson::traditional`]; `gradtess stats`, `bench --mode both` |
//! | 8 real-time editing | [`ferguson::live`]: an edit costs what it touches |
//! | 8 SVG 2, PDF | [`scene::svg`], [`vector`] |
//! | App. A colour spaces, Fig. 18 | [`patch::space`], and Oklab; per sample on the GPU; `scenes/ferguson/colour_spaces.json` |
//! | 5 a panel to edit these meshes in | [`app`], [`mod@edit::gradient`]; `gradtess edit` |
//!
//! Departures: a T-section whose sides are coloured by hand keeps its colour (sharp), so every sector has a flag whether it
//! inherits. Splits need not be dyadic; where they are not, segments along a curve differ in length. Where chains of
//! T-sections close in a circle, which only splits at any parameter can make, updates go round until nothing changes.
//! Components lie over one another in the order of the file.
//!
//! # BS05, piece by piece
//!
//! | in the paper | here |
//! |---|---|
//! | 3.2 refinement pattern, Fig. 2 | [`pattern::RefinementPattern`]; Fig. 7's 4,225 and 16,641 vertices are its grid |
//! | 3.2 tessellation with a height field | [`pattern::displace::HeightMap`] |
//! | 4 procedural displacement, Fig. 4 | [`pattern::displace`]; `scenes/pattern/sphere.json`, `ocean.json` |
//! | 4 Fig. 6 | `scenes/pattern/character.json` |
//! | 3.2 one draw a triangle, attributes as uniforms | [`gpu::PatternMethod::Draws`]; its successors and rivals are the other methods |
//! | 3.3 levels of detail, Fig. 3; 6 adaptive and geomorphic ones | [`pattern::detail`]; `--lod mesh`, `--lod triangle` |
//! | 5 Fig. 7 | `gradtess bench --grid fig7` |
//! | App. A curved PN triangles | [`pattern::Control`], [`pattern::evaluate`](mod@pattern::evaluate); both factors of the normals: [`pattern::NormalField`] |
//! | App. B scalar tagged meshes | [`pattern::Tag`], [`pattern::Control`]; which side of a crease an edge takes is said there |
//!
//! # Where this departs from the paper
//!
//! * **Two sets of rules.** [`refine::Rules::Authors`] is the authors' tool to the letter and reproduces its patches.
//!   [`refine::Rules::Gradtess`], the default, lets neighbours differ by one level at most, confines a colour edit to the
//!   sectors that it can change ([`refine::forest`]), and draws a face by bicubics only where its colours are bicubic.
//! * **Bezier form.** The paper hands 16 B-spline points of a regular patch to the control shader, which turns them into
//!   Bezier form. Here the CPU does that, because a seam between levels is watertight only if both sides evaluate the
//!   same numbers: a corner is made once for each limit vertex whatever the levels around it, an edge's inner points are
//!   lent to the coarser transition face across it, and both are shared by index ([`patch::points`]).
//! * **`c1` in Gregory face points** weighs the patch corner, as in LSNC09 eq. 6; the authors' tool weighs the control
//!   vertex. Rules authors does as the tool.
//! * **Edge points at extraordinary boundary vertices** are exact (rules gradtess).
//! * **Face points of T** are bilinear in the corner, the two edge *midpoints* and the centroid; 3.2 says neighbours.
//! * **App. A** numbers edge points by `n_v + min(I(e), I(twin))`, which leaves gaps and meets the numbers of the face
//!   points. They are numbered by edge here. Its "d = 0 for e_1" should read e_0, and `d^(n-1) = floor(d^n / 4)` should
//!   read `i^(n-1) = floor(i^n / 4)`.
#![deny(unsafe_code)]

pub mod app;
pub mod camera;
pub mod check;
pub mod command;
pub mod edit;
pub mod ferguson;
pub mod gpu;
pub mod image;
pub mod incremental;
pub mod mesh;
pub mod patch;
pub mod pattern;
pub mod refine;
pub mod repro;
pub mod scene;
pub mod subdiv;
pub mod surface;
pub mod threads;
pub mod timing;
pub mod vector;
