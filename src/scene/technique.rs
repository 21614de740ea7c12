//! Which technique a file is of, told by its content and never by its name.

use serde::Deserialize;

/// A technique, as scenes and the command line name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technique {
    /// ZHHK22: hierarchical subdivision gradient meshes.
    Subdivision,
    /// BLHK18: locally refinable gradient meshes; SVG mesh gradients come here.
    Ferguson,
    /// ZBK23: subdivision surfaces with subdivision shading.
    Surface,
    /// BS05: generic mesh refinement.
    Pattern,
}

impl Technique {
    /// The name in `"technique": "..."`.
    pub const fn name(self) -> &'static str {
        match self {
            Technique::Subdivision => "subdivision",
            Technique::Ferguson => "ferguson",
            Technique::Surface => "surface",
            Technique::Pattern => "pattern",
        }
    }
}

/// The technique of the scene in `bytes`. JSON says it (`subdivision` where it does not); SVG is `ferguson`; of OBJ
/// files, those with `ve` or `ce` lines are `subdivision`, those with `fs`, `as`, `vn`, `t crease` or `t corner` lines
/// or a third coordinate other than 0 are `surface`. What is no scene at all is left to the reader of `subdivision`, which says so.
pub fn technique(bytes: &[u8]) -> Technique {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match bytes.iter().copied().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => of_json(bytes),
        Some(b'<') => Technique::Ferguson,
        Some(_) if !bytes.contains(&0) => of_obj(bytes),
        _ => Technique::Subdivision,
    }
}

fn of_json(bytes: &[u8]) -> Technique {
    #[derive(Deserialize)]
    struct Head {
        technique: Option<serde_json::Value>,
    }
    let named = serde_json::from_slice::<Head>(bytes).ok().and_then(|head| head.technique);
    [Technique::Ferguson, Technique::Surface, Technique::Pattern]
        .into_iter()
        .find(|t| named.as_ref().and_then(|name| name.as_str()) == Some(t.name()))
        .unwrap_or(Technique::Subdivision)
}

fn of_obj(bytes: &[u8]) -> Technique {
    let mut solid = false;
    for line in bytes.split(|&b| b == b'\n') {
        let mut fields = line.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty());
        match fields.next() {
            Some(b"ve" | b"ce") => return Technique::Subdivision,
            Some(b"st") => return Technique::Pattern,
            Some(b"fs" | b"as" | b"vn") => solid = true,
            Some(b"t") => solid |= matches!(fields.next(), Some(b"crease" | b"corner")),
            Some(b"v") if !solid => {
                let z = fields.nth(2).and_then(|z| std::str::from_utf8(z).ok()?.parse::<f64>().ok());
                solid = z.is_some_and(|z| z != 0.0);
            }
            _ => {}
        }
    }
    if solid {
        Technique::Surface
    } else {
        Technique::Subdivision
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_tells() {
        use Technique::*;
        let cases: [(&[u8], Technique); 12] = [
            (b" {\"gradtess\": 1}", Subdivision),
            (b"{\"technique\": \"pattern\", \"x\": [1]}", Pattern),
            (b"{\"technique\": \"weaving\"}", Subdivision),
            (b"{\"technique\": \"surface\"", Subdivision),
            (b"\xEF\xBB\xBF<svg/>", Ferguson),
            (b"v 0 0 0\nf 1 2 3\n", Subdivision),
            (b"v 0 0 1\r\nv 1 0 0\r\nf 1 2 3\r\n", Surface),
            (b"v 0 0 1\nce 0 0 1 1 1\n", Subdivision),
            (b"v 0 0\nfs 0 1 0\n", Surface),
            (b"v 0 0\nt crease 2/1/0 0 1 2\n", Surface),
            (b"v 0 0\nt cloth\n", Subdivision),
            (b"", Subdivision),
        ];
        for (bytes, expected) in cases {
            assert_eq!(technique(bytes), expected, "{:?}", String::from_utf8_lossy(bytes));
        }
    }
}
