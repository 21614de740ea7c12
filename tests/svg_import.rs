//! SVG mesh gradients: every rule of the syntax in a small file of its own.

use glam::{DVec2, DVec4};
use gradtess::ferguson::Mesh;
use gradtess::scene::ferguson::parse;
use gradtess::scene::svg::{grids, write};

mod models;
mod mutate;

fn read(body: &str) -> (Mesh, Vec<String>) {
    let text = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 200 100\">{body}</svg>");
    parse(text.as_bytes(), "t.svg").unwrap_or_else(|e| panic!("{e}\n{body}"))
}

/// The error's text after the file's name.
fn refusal(body: &str) -> String {
    parse(body.as_bytes(), "t").map(|_| panic!("this was read: {body}")).unwrap_err().to_string()
}

const SQUARE: &str = "<meshrow><meshpatch><stop path='l 1,0' stop-color='red'/><stop path='l 0,1' stop-color='lime'/>\
                      <stop path='l -1,0' stop-color='blue'/><stop path='l 0,-1' stop-color='white'/></meshpatch></meshrow>";

fn corners(mesh: &Mesh, p: u32) -> [[f64; 2]; 4] {
    let net = mesh.geometry(p);
    [0, 3, 15, 12].map(|slot| net[slot].to_array())
}

fn colours(mesh: &Mesh, p: u32) -> [[f64; 4]; 4] {
    let net = mesh.colours(p);
    [0, 3, 15, 12].map(|slot| net[slot].to_array())
}

/// Inner points at A, B, C, D of the Coons patch: ISO 32000-1, 8.7.4.5.8, with p(row, column).
fn coons(net: &[DVec2; 16]) -> [DVec2; 4] {
    let p = |r: usize, c: usize| net[4 * r + c];
    let inner = |r0: usize, c0: usize| {
        // Seen from the corner (r0, c0), which is 0 or 3 in either direction.
        let at = |r: usize, c: usize| p(if r0 == 0 { r } else { 3 - r }, if c0 == 0 { c } else { 3 - c });
        (-4.0 * at(0, 0) + 6.0 * (at(0, 1) + at(1, 0)) - 2.0 * (at(0, 3) + at(3, 0)) + 3.0 * (at(3, 1) + at(1, 3))
            - at(3, 3))
            / 9.0
    };
    [inner(0, 0), inner(0, 3), inner(3, 3), inner(3, 0)]
}

#[test]
fn corners_run_from_the_upper_left_and_colours_belong_to_where_a_side_begins() {
    let (mesh, notes) =
        read(&format!("<meshgradient gradientUnits='userSpaceOnUse' x='3' y='4'>{SQUARE}</meshgradient>"));
    assert_eq!(corners(&mesh, 0), [[3.0, -4.0], [4.0, -4.0], [4.0, -5.0], [3.0, -5.0]]);
    let rgb = colours(&mesh, 0).map(|c| [c[0], c[1], c[2]]);
    assert_eq!(rgb, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]]);
    assert!(notes.len() == 1 && notes[0].contains("fills no shape"), "{notes:?}");
}

#[test]
fn neighbours_lend_sides_and_colours() {
    let (mesh, _) = read(
        "<meshGradient gradientUnits='userSpaceOnUse'>
         <meshRow><meshPatch><stop path='c 1,1 2,1 3,0' stop-color='#111111'/><stop path='L3,3' stop-color='#222222'/>
         <stop path='C2 3 1 3 0 3' stop-color='#333333'/><stop path='c0,-1 0,-2' stop-color='#444444'/></meshPatch>
         <meshPatch><stop path='l3 0' stop-color='#ff0000'/><stop path='l0 3' style='stop-color:#555555;stop-opacity:.5'/>
         <stop path='c-1 0-2 0' stop-color='#666666'/></meshPatch></meshRow>
         <meshRow><meshPatch><stop path='l 0 3' stop-color='#00ff00'/><stop path='l -3 0' stop-color='#777777'/>
         <stop path='l' stop-color='#888888'/></meshPatch>
         <meshPatch><stop path='l 0 3'/><stop path='l' stop-color='#999999'/></meshPatch></meshRow></meshGradient>",
    );
    let digit = |k: u32| colours(&mesh, k).map(|c| (c[0] * 15.0).round() as u32);
    assert_eq!([0, 1, 2, 3].map(digit), [[1, 2, 3, 4], [2, 5, 6, 3], [4, 3, 7, 8], [3, 6, 9, 7]]);
    assert_eq!(colours(&mesh, 1)[1][3], 0.5);
    let [a, b, c] = [0, 1, 3].map(|p| mesh.geometry(p));
    assert_eq!((a[1], a[7], a[8]), (DVec2::new(1.0, -1.0), DVec2::new(3.0, -1.0), DVec2::new(0.0, -2.0)));
    assert_eq!(([b[0], b[4], b[8], b[12]], b[13]), ([a[3], a[7], a[11], a[15]], DVec2::new(4.0, -3.0)));
    assert_eq!((c[0], c[15], c[12]), (b[12], DVec2::new(6.0, -6.0), DVec2::new(3.0, -6.0)));
    for p in 0..4 {
        let net = mesh.geometry(p);
        // Kept as twists, hence not bit for bit.
        assert!(coons(&net).iter().zip([5, 6, 10, 9]).all(|(at, k)| (*at - net[k]).length() < 1e-14));
        // Of the plain gradient the colours are bilinear.
        let mean = colours(&mesh, p).iter().fold(DVec4::ZERO, |sum, c| sum + DVec4::from(*c)) / 4.0;
        assert!((mesh.evaluate(p, 0.5, 0.5).1 - mean).abs().max_element() < 1e-15);
    }
}

#[test]
fn transforms_boxes_units_and_templates() {
    // A box of 20 x 10 at (10, 20), moved by (100, 0); the mesh's own transform doubles it in fractions of the box.
    let (mesh, notes) = read(&format!(
        "<defs><mesh id='a' x='.5' type='bicubic'>{SQUARE}</mesh>
         <meshgradient id='b' xlink:href='#a' gradientTransform='scale(2)'/>
         <meshgradient id='c' href='#a' transform='scale(2)' gradientUnits='userSpaceOnUse' y='25' x='1in'/>
         <meshgradient id='d' href='#c' x='0' y='0'/></defs>
         <g transform='translate(100)'><rect x='10' y='20' width='20' height='10' style='fill:url(#b) red'/></g>
         <g fill='url(\"#c\")'><circle r='1'/></g><rect width='1' height='1' fill='url(#d)'/>"
    ));
    assert_eq!((corners(&mesh, 0)[0], corners(&mesh, 0)[2]), ([130.0, -20.0], [170.0, -40.0]));
    assert_eq!(corners(&mesh, 1)[0], [192.0, -50.0]);
    assert_eq!((corners(&mesh, 2)[0], corners(&mesh, 2)[2]), ([0.0, 0.0], [2.0, -2.0]));
    assert!(!notes.iter().any(|note| note.contains("no rows")), "{notes:?}");
}

#[test]
fn style_sheets_opacities_and_hidden_shapes() {
    let unstyled = SQUARE.replace("stop-color='red'", "class='first'");
    assert_ne!(unstyled, SQUARE);
    let (mesh, notes) = read(&format!(
        "<style>.first {{ stop-color: #0f08; }} .half, g:hover {{ opacity: 50% }}</style>
         <style><![CDATA[#b {{ fill: url(#a) !important; fill-opacity: .5 }}]]></style>
         <meshgradient id='a' gradientUnits='userSpaceOnUse'>{unstyled}</meshgradient>
         <g class='half'><rect width='1' height='1' fill='url(#a)'/><rect id='b' style='fill:red'/></g>
         <g display='none'><rect width='1' height='1' fill='url(#a)'/></g>"
    ));
    assert_eq!(mesh.live().count(), 2, "the hidden one is not drawn");
    let half = 136.0 / 255.0 * 0.5;
    let near = |c: [f64; 4], d: [f64; 4]| (DVec4::from(c) - DVec4::from(d)).abs().max_element() < 1e-12;
    assert!(near(colours(&mesh, 0)[0], [0.0, 1.0, 0.0, half]), "{:?}", colours(&mesh, 0)[0]);
    assert!(near(colours(&mesh, 1)[0], [0.0, 1.0, 0.0, half * 0.5]), "{:?}", colours(&mesh, 1)[0]);
    assert!(notes.iter().any(|note| note.starts_with("1 selector")), "{notes:?}");
}

#[test]
fn inner_points_of_inkscape_are_offsets_from_their_corners() {
    let square = SQUARE.replace("<meshpatch>", "<meshpatch tensor='.1,.2 -.3,.4 -.5,-.6 .7,-.8'>");
    let body = format!("<meshgradient gradientUnits='userSpaceOnUse' transform='scale(10)'>{square}</meshgradient>");
    let g = read(&body).0.geometry(0);
    let expected = [[1.0, -2.0], [7.0, -4.0], [5.0, -4.0], [7.0, -2.0]];
    assert!([5, 6, 10, 9].iter().zip(expected).all(|(&k, at)| (g[k] - DVec2::from(at)).length() < 1e-14), "{g:?}");
}

/// The rule for smooth colours, on a line of three patches of lengths 1, 1 and 2 with grey levels 0, 0.2, 1, 0.5.
#[test]
fn bicubic_colours_are_monotone_cubics_along_the_lines() {
    let body = SQUARE.replace("red", "#000").replace("white", "#000").replace("lime", "rgb(20%,20%,20%)");
    let body = body.replace("blue", "rgb(20%,20%,20%)").replace(
        "</meshpatch>",
        "</meshpatch><meshpatch><stop path='l1 0'/><stop path='l0 1' stop-color='#fff'/><stop path='l' stop-color='#fff'/>\
         </meshpatch><meshpatch><stop path='l2 0'/><stop path='l0 1' stop-color='rgb(50%,50%,50%)'/>\
         <stop path='l' stop-color='rgb(50%,50%,50%)'/></meshpatch>",
    );
    let (mesh, _) = read(&format!("<mesh gradientUnits='userSpaceOnUse' type='bicubic'>{body}</mesh>"));
    // Secants 0.2, 0.8, -0.25: 0.5 inside, 0 at the extremum, 2 * 0.2 - 0.5 and 2 * -0.25 - 0 at the ends.
    let slopes = [(0, 0.0, -0.1), (0, 1.0, 0.5), (1, 0.0, 0.5), (1, 1.0, 0.0), (2, 0.0, 0.0), (2, 1.0, -0.5)];
    for (p, u, slope) in slopes {
        let h = 1e-6;
        let at = |u: f64| mesh.evaluate(p, u, 0.3);
        let (a, b) = if u == 0.0 { (at(0.0), at(h)) } else { (at(1.0 - h), at(1.0)) };
        let found = (b.1.x - a.1.x) / (b.0.x - a.0.x);
        assert!((found - slope).abs() < 1e-4, "{p} {u}: {found} not {slope}");
    }
}

#[test]
fn what_is_written_reads_back() {
    let twisted = SQUARE.replace("<meshpatch>", "<meshpatch tensor='.1,.2 -.3,.4 -.5,-.6 .7,-.8'>");
    let two = SQUARE.replace(
        "</meshpatch>",
        "</meshpatch><meshpatch><stop path='c.3.1.6-.1 1 0'/><stop path='l0 1' stop-color='rgb(12.3%,4.5%,6%)' \
         stop-opacity='.25'/><stop path='l-1 0' stop-color='#123456'/></meshpatch>",
    );
    for (kind, body) in [("bilinear", &twisted), ("bilinear", &two), ("bicubic", &two)] {
        for turn in [0, 30] {
            let text =
                format!("<mesh gradientUnits='userSpaceOnUse' type='{kind}' transform='rotate({turn})'>{body}</mesh>");
            same_again(&read(&text).0);
        }
    }
}

/// Scenes that have the form of grids, and the drawings made by others.
#[test]
fn scenes_and_drawings_read_back_equal() {
    let mut folders = vec![std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ferguson")];
    folders.extend(models::folder("svg", "drawings out and in again"));
    for folder in folders {
        let mut written = 0;
        for path in std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()) {
            if path.extension().is_none_or(|e| e != "json" && e != "svg") {
                continue;
            }
            let name = path.display().to_string();
            let (mesh, _) = parse(&std::fs::read(&path).unwrap(), &name).unwrap_or_else(|e| panic!("{e}"));
            if grids(&mesh).is_some() {
                println!("{name}");
                same_again(&mesh);
                written += 1;
            }
        }
        assert!(written > 0, "{}", folder.display());
    }
}

/// Writes a mesh of grids and compares what is read back.
fn same_again(mesh: &Mesh) {
    let found = grids(mesh).expect("grids");
    let text = write(mesh, Some(&found), b"", [-2.0, -2.0, 2.0, 2.0]);
    let (again, _) = parse(text.as_bytes(), "again").unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(mesh.live().count(), again.live().count());
    for (p, q) in mesh.live().zip(again.live()) {
        let (a, b) = (mesh.geometry(p), again.geometry(q));
        let (c, d) = (mesh.colours(p), again.colours(q));
        for k in 0..16 {
            assert!((a[k] - b[k]).abs().max_element() <= 1e-6 && (c[k] - d[k]).abs().max_element() <= 1e-6, "{p} {k}");
        }
    }
}

#[test]
fn faults_name_their_place_and_what_to_do() {
    let mesh = |body: &str| format!("<svg>\n<meshgradient>{body}</meshgradient></svg>");
    let stop = "<stop path='l1 0'/>";
    let cases = [
        (String::new(), ""),
        ("<svg>".into(), "the file ends inside"),
        ("<svg></g>".into(), "XML"),
        ("<svg/>".into(), "no mesh gradient"),
        (mesh(""), "has rows"),
        (mesh("<meshrow/>"), "t:2:15: the row has no patch"),
        (
            mesh(&format!("<meshrow><meshpatch>{stop}{stop}</meshpatch></meshrow>")),
            "t:2:24: the patch has 2 stops where 4",
        ),
        (mesh(&format!("{SQUARE}<meshrow/>")), "row has 0 patches"),
        (mesh(&SQUARE.replace("l 0,1", "l NaN,1")), "malformed"),
        (mesh(&SQUARE.replace("l 0,1", "l 1e99,1")), "too large"),
        (mesh(&SQUARE.replace("l 0,1", "l 0,1 2,3")), "has 4 numbers"),
        (mesh(&SQUARE.replace("l 0,1", "l")), "has 0 numbers"),
        (mesh(&SQUARE.replace("l 0,1", "q 0,1 1,1")), "is none of an edge"),
        (mesh(&SQUARE.replace("lime", "limy")), "\"limy\" is no colour"),
        (mesh(&SQUARE.replace("lime", "&lime;")), "entit"),
        (mesh(SQUARE).replace("<meshgradient>", "<meshgradient x='3ell'>"), "is no length"),
        (mesh(SQUARE).replace("<meshgradient>", "<meshgradient x='3em'>"), "has a unit that is not known here"),
        (mesh(SQUARE).replace("<meshgradient>", "<meshgradient x='nan'>"), "is no length"),
        (mesh(SQUARE).replace("<meshgradient>", "<meshgradient transform='turn(3)'>"), "is no transform"),
        (mesh(SQUARE).replace("<meshgradient>", "<meshgradient type='cubic'>"), "type \"cubic\" is unknown"),
    ];
    for (text, expected) in cases {
        let message = refusal(&text);
        assert!(message.contains(expected) && message.contains("; "), "{message}\nnot {expected}\n{text}");
    }
}

#[test]
fn collapsed_patches_stay() {
    let point = SQUARE.replace("l 1,0", "l 0,0").replace("l -1,0", "l 0,0");
    let (mesh, _) = read(&format!("<mesh gradientUnits='userSpaceOnUse'>{point}</mesh>"));
    assert_eq!((mesh.live().count(), mesh.fault()), (1, None));
}

/// Hostile files end quickly, whatever they hold.
#[test]
fn nesting_entities_and_repetition_cost_nothing() {
    assert!(refusal(&"<g>".repeat(1_000_000)).contains("nested more than 256 deep"));
    let bomb = format!(
        "<!DOCTYPE svg [<!ENTITY a \"lol\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;\">]>\
         <svg><mesh x=\"&c;\">{SQUARE}</mesh></svg>"
    );
    assert!(refusal(&bomb).contains("entit"));
    let text = format!("<!DOCTYPE svg [<!ENTITY a \"lol\">]><svg>&a;<mesh>{SQUARE}</mesh>&a;</svg>");
    assert_eq!(parse(text.as_bytes(), "t").unwrap().0.live().count(), 1);
    let own = "<svg><mesh id='a' href='#b'/><mesh id='b' href='#a'/><rect width='1' height='1' fill='url(#a)'/></svg>";
    assert!(refusal(own).contains("has rows"));
    // An arc is not made into as many curves as its radius asks for: a path of these took minutes.
    let arc = "<path d='M0 0A1e300 1e300 0 0 1 1 1' fill='url(#m)'/>".to_owned();
    let arcs = format!("<path d='M0 0{}' fill='url(#m)'/>", "A1e8 1e8 0 0 1 0 1A1e8 2e8 7 1 1 1 1".repeat(20_000));
    for path in [arc, arcs] {
        assert!(
            parse(format!("<svg><mesh id='m'>{SQUARE}</mesh>{path}</svg>").as_bytes(), "t").is_ok() || path.len() < 99
        );
    }
}

/// Reads spoiled drawings: two seconds, or `GRADTESS_FUZZ_SECONDS`.
#[test]
fn spoiled_drawings_are_read_or_refused() {
    let twisted = SQUARE.replace("<meshpatch>", "<meshpatch tensor='.1,.2 -.3,.4 -.5,-.6 .7,-.8'>");
    let documents: Vec<Vec<u8>> = [
        format!(
            "<?xml version='1.0'?><!DOCTYPE svg [<!ENTITY a 'b'>]><svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 9 9'>\
             <defs><meshgradient id='a' x='1' y='2mm' type='bicubic' gradientTransform='rotate(3) translate(1)'>{SQUARE}\
             </meshgradient><mesh id='b' xlink:href='#a' gradientUnits='userSpaceOnUse'/></defs><g transform='scale(2)'>\
             <rect width='3' height='4' style='fill:url(#a)'/><path d='M0 0A1 2 3 0 1 4 5Q1 2 3 4S5 6 7 8z' fill='url(#b)'/>\
             </g></svg>"
        ),
        format!("<svg><mesh gradientUnits='userSpaceOnUse'>{twisted}</mesh></svg>"),
        format!(
            "<svg><style>@import 'x'; stop.c,#a g .d{{stop-color:red!important;fill:url(#a)}}/*b*/*{{opacity:.5}}</style>\
             <style><![CDATA[rect{{fill:url(#a);fill-opacity:50%;display:inline}}]]></style><g id='a' class='d c'>\
             <mesh id='a' gradientUnits='userSpaceOnUse'>{SQUARE}</mesh><rect class='d' width='1' height='2'/></g></svg>"
        ),
        "<svg><meshGradient><meshRow><meshPatch><stop path='c 1,1 2,1 3,0' stop-color='rgb(1%, 2%, 3%)'/><stop path='L3,3'/>\
         <stop path='C2 3 1 3 0 3' style='stop-color:#abc;stop-opacity:50%'/><stop path='c0,-1 0,-2'/></meshPatch><meshPatch>\
         <stop path='l3 0'/><stop path='l0 3'/><stop path='l'/></meshPatch></meshRow><meshRow><meshPatch><stop path='l0 3'/>\
         <stop path='l-3 0'/><stop path='l'/></meshPatch><meshPatch><stop path='l0 3'/><stop path='l'/></meshPatch></meshRow>\
         </meshGradient><circle r='3' fill='url(#a)'/></svg>"
            .to_owned(),
    ]
    .map(String::into_bytes)
    .into();
    mutate::survive("drawings", documents, |input| match parse(input, "fuzz") {
        // Not every spoiled drawing still is SVG.
        Ok((mesh, _)) => {
            assert!(mesh.fault().is_none() || mesh.live().count() == 0);
            if let (true, Some(found)) = (mesh.live().count() < 50, grids(&mesh)) {
                let text = write(&mesh, Some(&found), b"", [0.0, 0.0, 1.0, 1.0]);
                if let Err(e) = parse(text.as_bytes(), "again") {
                    // Names of coordinates near the limit may round beyond it.
                    assert!(e.to_string().contains("too large"), "{e}");
                }
            }
            true
        }
        Err(error) => {
            mutate::assert_clear(&error, input);
            false
        }
    });
}
