//! The part of a drawing that matters as a small tree. Nothing in it is expanded: an entity that is not one of XML's own
//! five is an error, whatever a document type declares, so a file cannot grow in memory.

use super::style::Declared;
use crate::scene::error::{quoted, Fault};
use crate::scene::json_position::line_column;
use quick_xml::events::{BytesStart, Event};
use quick_xml::Reader;

/// Largest drawing that is read, bytes.
const LARGEST: usize = 64 << 20;
/// Deepest nesting.
const DEEPEST: usize = 256;
/// Most elements that are kept.
const MOST: usize = 500_000;

/// Attributes that are read from any element; others are not kept.
const ATTRIBUTES: [&str; 38] = [
    "id",
    "class",
    "x",
    "y",
    "width",
    "height",
    "cx",
    "cy",
    "r",
    "rx",
    "ry",
    "d",
    "points",
    "transform",
    "gradientTransform",
    "gradientUnits",
    "type",
    "href",
    "path",
    "stop-color",
    "stop-opacity",
    "style",
    "fill",
    "fill-opacity",
    "opacity",
    "display",
    "tensor",
    "color",
    "x1",
    "y1",
    "x2",
    "y2",
    "viewBox",
    "space",
    "alpha",
    "blend",
    "jets",
    "colors",
];

/// An element.
#[derive(Debug, Default)]
pub(super) struct Element {
    /// Name without prefix, in lower case: the draft's spelling changed in case only.
    pub name: String,
    /// Attributes by name without prefix.
    pub attributes: Vec<(&'static str, String)>,
    /// Elements in it.
    pub children: Vec<Element>,
    /// What a style sheet says; of no other element the text is kept.
    pub text: String,
    /// What the style sheets declare for it, the strongest last.
    pub declared: Vec<Declared>,
    /// Byte offset in the text.
    pub at: usize,
}

impl Element {
    /// Value of an attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| *n == name).map(|(_, value)| value.as_str())
    }

    /// A property: of the `style` attribute, else of the style sheets, else the attribute of the same name; what is
    /// important in a sheet before all.
    pub fn property(&self, name: &str) -> Option<&str> {
        let of_sheets = |important: bool| {
            let mut strongest = self.declared.iter().rev();
            strongest.find(|d| d.name == name && d.important == important).map(|d| &*d.value)
        };
        let of_style = || {
            let declarations = self.get("style")?.rsplit(';').filter_map(|part| part.split_once(':'));
            let (_, value) = { declarations }.find(|(key, _)| key.trim() == name)?;
            Some(value.trim().trim_end_matches("!important").trim_end())
        };
        of_sheets(true).or_else(of_style).or_else(|| of_sheets(false)).or_else(|| self.get(name))
    }

    /// A fault at this element.
    pub fn fault(&self, text: &str, what: impl std::fmt::Display, fix: impl std::fmt::Display) -> Fault {
        Fault::new(line_column(text, self.at), what, fix)
    }
}

/// Reads a document.
pub(super) fn parse(text: &str) -> Result<Element, Fault> {
    let at = |offset: u64| line_column(text, text.floor_char_boundary_at(offset as usize));
    if text.len() > LARGEST {
        return Err(Fault::new(
            (1, 1),
            format!("the drawing is larger than {LARGEST} bytes"),
            "keep the gradients and remove the rest",
        ));
    }
    let mut reader = Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    let mut open: Vec<Element> = vec![Element::default()];
    let mut kept = 0;
    loop {
        let begin = reader.buffer_position();
        let event = reader.read_event();
        match event {
            Err(error) => {
                let what: String = format!("this is not well-formed XML: {error}").chars().take(300).collect();
                return Err(Fault::new(at(reader.error_position()), what, "correct the markup"));
            }
            Ok(Event::Start(start)) => {
                if open.len() > DEEPEST {
                    return Err(Fault::new(
                        at(begin),
                        format!("elements are nested more than {DEEPEST} deep"),
                        "flatten the drawing",
                    ));
                }
                kept += 1;
                if kept > MOST {
                    return Err(Fault::new(
                        at(begin),
                        format!("the drawing has more than {MOST} elements"),
                        "keep the gradients and remove the rest",
                    ));
                }
                let element =
                    element(&start, begin as usize).map_err(|(what, fix)| Fault::new(at(begin), what, fix))?;
                open.push(element);
            }
            Ok(Event::End(_)) => {
                if let Some(done) = open.pop() {
                    match open.last_mut() {
                        Some(parent) => parent.children.push(done),
                        None => open.push(done),
                    }
                }
            }
            Ok(Event::Text(part)) => say(&mut open, &part),
            Ok(Event::CData(part)) => say(&mut open, &part),
            Ok(Event::Eof) => break,
            Ok(_) => {}
        }
    }
    if open.len() != 1 {
        let inner = open.last().map_or("", |e| e.name.as_str());
        return Err(Fault::new(
            line_column(text, text.len()),
            format!("the file ends inside <{inner}>"),
            "complete the file",
        ));
    }
    let mut document = open.remove(0);
    match document.children.pop() {
        Some(root) if document.children.is_empty() => Ok(root),
        _ => Err(Fault::new((1, 1), "there is no root element, or more than one", "give an SVG document")),
    }
}

/// Keeps a part of the text of a style sheet. Of no use there are the entities between the parts.
fn say(open: &mut [Element], part: &[u8]) {
    if let Some(sheet) = open.last_mut().filter(|element| element.name == "style") {
        sheet.text.push_str(&String::from_utf8_lossy(part));
    }
}

fn element(start: &BytesStart, at: usize) -> Result<Element, (String, String)> {
    let local = start.local_name();
    let name = String::from_utf8_lossy(local.as_ref()).to_ascii_lowercase();
    let mut attributes = Vec::new();
    // Their own check for duplicates is quadratic; the first one of a name is taken.
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|e| {
            let what: String = format!("an attribute of <{name}> is malformed: {e}").chars().take(300).collect();
            (what, "correct the markup".to_owned())
        })?;
        let key = attribute.key.local_name();
        let Some(known) = ATTRIBUTES.iter().find(|k| k.as_bytes() == key.as_ref()) else { continue };
        if attributes.iter().any(|(n, _)| n == known) {
            continue;
        }
        let raw = String::from_utf8_lossy(&attribute.value);
        let value = quick_xml::escape::unescape(&raw).map_err(|e| {
            let what: String = format!("attribute {known} of <{name}>: {e}").chars().take(300).collect();
            (what, "write the character itself; entities are not expanded".to_owned())
        })?;
        attributes.push((*known, value.into_owned()));
    }
    Ok(Element { name, attributes, at, ..Element::default() })
}

/// The start of a character at or before an offset.
trait Boundary {
    fn floor_char_boundary_at(&self, offset: usize) -> usize;
}

impl Boundary for str {
    fn floor_char_boundary_at(&self, offset: usize) -> usize {
        let mut at = offset.min(self.len());
        while !self.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}

/// `text` for a message.
pub(super) fn shown(text: &str) -> String {
    quoted(text)
}
