//! Style sheets in a drawing: which declarations of its `<style>` elements hold for which element (CSS 2.1, 5 and 6.4).
//!
//! Selectors are compounds of a name or `*`, `.class` and `#id`, alone, in lists, or as descendants of others; rules with
//! other selectors are left out, and counted. At-rules are passed over. Inputs come from anywhere, so the work is bounded.

use super::xml::Element;
use crate::scene::error::Fault;
use std::rc::Rc;

/// Properties that are looked at.
const PROPERTIES: [&str; 7] = ["fill", "fill-opacity", "opacity", "stop-color", "stop-opacity", "color", "display"];
/// Most comparisons of a selector's part with an element.
const MOST: u64 = 100_000_000;
/// Most bytes of a value: no colour and no reference has as many.
const LONGEST: usize = 1000;
/// Most bytes of selectors that are kept, with 16 more for each.
const MOST_SELECTORS: usize = 2 << 20;

/// A declaration that holds for an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Declared {
    pub name: &'static str,
    /// Shared: one value may hold for every element of the drawing.
    pub value: Rc<str>,
    pub important: bool,
}

/// Puts a declaration in place of a weaker one, so that there are few however many rules hold.
fn strengthen(declared: &mut Vec<Declared>, by: Declared) {
    declared.retain(|weaker| (weaker.name, weaker.important) != (by.name, by.important));
    declared.push(by);
}

/// A name, classes and an identifier, any of which may be open.
#[derive(Clone, Debug, Default, PartialEq)]
struct Compound<'a> {
    name: Option<&'a str>,
    id: Option<&'a str>,
    classes: Vec<&'a str>,
}

impl Compound<'_> {
    fn of(text: &str) -> Option<Compound<'_>> {
        let mut out = Compound::default();
        let start = text.find(['.', '#']).unwrap_or(text.len());
        let ident = |part: &str| {
            !part.is_empty() && part.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_' || !c.is_ascii())
        };
        match &text[..start] {
            "" if start < text.len() => {}
            "*" => {}
            name if ident(name) => out.name = Some(name),
            _ => return None,
        }
        let mut rest = &text[start..];
        while let Some(kind) = rest.chars().next() {
            let end = rest[1..].find(['.', '#']).map_or(rest.len(), |at| at + 1);
            let part = Some(&rest[1..end]).filter(|part| ident(part))?;
            match kind {
                '.' => out.classes.push(part),
                _ => out.id = Some(part),
            }
            rest = &rest[end..];
        }
        Some(out)
    }

    fn matches(&self, element: &Element) -> bool {
        let has =
            |class: &&str| element.get("class").is_some_and(|all| all.split_ascii_whitespace().any(|c| c == *class));
        self.name.is_none_or(|name| name.eq_ignore_ascii_case(&element.name))
            && self.id.is_none_or(|id| element.get("id") == Some(id))
            && self.classes.iter().all(has)
    }
}

/// A selector and what it declares.
struct Rule<'a> {
    /// Identifiers, classes, names: the greater wins.
    specificity: [usize; 3],
    /// From the outermost to the element itself.
    path: Vec<Compound<'a>>,
    declarations: Rc<Vec<Declared>>,
}

/// The rules of all sheets in ascending order of precedence, and how many selectors were left out; `None` when there are
/// more than [`MOST_SELECTORS`].
fn rules(sheets: &str) -> Option<(Vec<Rule<'_>>, usize)> {
    let (mut all, mut left_out, mut kept) = (Vec::new(), 0, 0);
    let mut rest = sheets.trim_start();
    while let Some(stop) = rest.find(['{', ';']) {
        let prelude = rest[..stop].trim();
        if rest.as_bytes()[stop] == b';' {
            // The end of an at-rule without a block, or nonsense.
            rest = rest[stop + 1..].trim_start();
            continue;
        }
        let end = block_end(rest, stop);
        let body = &rest[stop + 1..end];
        rest = rest.get(end + 1..).unwrap_or("").trim_start();
        if prelude.starts_with('@') {
            continue;
        }
        let declarations = Rc::new(declarations(body));
        if declarations.is_empty() {
            continue;
        }
        for selector in prelude.split(',') {
            kept += selector.len() + 16;
            if kept > MOST_SELECTORS {
                return None;
            }
            let path: Option<Vec<Compound>> = selector.split_ascii_whitespace().map(Compound::of).collect();
            match path.filter(|path| !path.is_empty()) {
                Some(path) => {
                    let count = |of: fn(&Compound) -> usize| path.iter().map(of).sum();
                    let specificity = [
                        count(|c| usize::from(c.id.is_some())),
                        count(|c| c.classes.len()),
                        count(|c| usize::from(c.name.is_some())),
                    ];
                    all.push(Rule { specificity, path, declarations: declarations.clone() });
                }
                None => left_out += 1,
            }
        }
    }
    all.sort_by_key(|rule| rule.specificity);
    Some((all, left_out))
}

/// Where the block that opens at `open` closes; the end of the text where it does not.
fn block_end(text: &str, open: usize) -> usize {
    let mut depth = 0usize;
    for (at, byte) in text.bytes().enumerate().skip(open) {
        match byte {
            b'{' => depth += 1,
            b'}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// Declarations of `name: value; ...` that are of interest.
pub(super) fn declarations(body: &str) -> Vec<Declared> {
    let one = |part: &str| {
        let (name, value) = part.split_once(':')?;
        let name = *PROPERTIES.iter().find(|known| known.eq_ignore_ascii_case(name.trim()))?;
        let value = value.trim();
        let (value, important) = match value.rsplit_once('!') {
            Some((before, word)) if word.trim().eq_ignore_ascii_case("important") => (before.trim_end(), true),
            _ => (value, false),
        };
        (value.len() <= LONGEST).then(|| Declared { name, value: value.into(), important })
    };
    let mut all = Vec::new();
    body.split(';').filter_map(one).for_each(|declared| strengthen(&mut all, declared));
    all
}

/// `text` without its comments.
fn without_comments(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find("/*") {
        out.push_str(&rest[..start]);
        out.push(' ');
        rest = rest[start + 2..].split_once("*/").map_or("", |(_, after)| after);
    }
    out.push_str(rest);
    out
}

/// An element and those around it.
struct Path<'a> {
    element: &'a Element,
    outer: Option<&'a Path<'a>>,
}

/// Gives every element the declarations of the sheets that hold for it, and stops the inherited colour. A note where
/// rules were left out.
///
/// # Errors
/// Too many rules for so large a drawing.
pub(super) fn cascade(text: &str, root: &mut Element) -> Result<Option<String>, Fault> {
    let mut sheets = String::new();
    collect(root, &mut sheets);
    let sheets = without_comments(&sheets);
    let Some((rules, left_out)) = rules(&sheets) else { return Err(too_many(text, root)) };
    apply(text, root, None, None, &rules, &mut 0)?;
    Ok(match left_out {
        0 => None,
        1 => Some("1 selector of a style sheet is of a kind that is not read".to_owned()),
        n => Some(format!("{n} selectors of style sheets are of a kind that is not read")),
    })
}

fn too_many(text: &str, element: &Element) -> Fault {
    let fix = "write the gradients' properties as attributes";
    element.fault(text, "the style sheets have too many rules for so large a drawing", fix)
}

fn collect(element: &Element, sheets: &mut String) {
    if element.name == "style" {
        sheets.push_str(&element.text);
        sheets.push('\n');
    }
    element.children.iter().for_each(|child| collect(child, sheets));
}

fn apply(
    text: &str,
    element: &mut Element,
    outer: Option<&Path>,
    colour: Option<&Rc<str>>,
    rules: &[Rule],
    work: &mut u64,
) -> Result<(), Fault> {
    let mut declared = Vec::new();
    for rule in rules {
        let Some((last, above)) = rule.path.split_last() else { continue };
        *work += 1;
        // The nearest that matches leaves most for the others, so none needs to be tried again.
        let mut found = last.matches(element);
        let mut at = outer;
        for part in above.iter().rev() {
            while found {
                *work += 1;
                let Some(path) = at else {
                    found = false;
                    break;
                };
                at = path.outer;
                if part.matches(path.element) {
                    break;
                }
            }
        }
        if found {
            rule.declarations.iter().cloned().for_each(|by| strengthen(&mut declared, by));
        }
    }
    if *work > MOST {
        return Err(too_many(text, element));
    }
    element.declared = declared;
    let own: Option<Rc<str>> = element.property("color").filter(|value| *value != "inherit").map(Rc::from);
    let colour = own.as_ref().or(colour);
    if let (None, "stop", Some(value)) = (&own, element.name.as_str(), colour) {
        element.declared.push(Declared { name: "color", value: value.clone(), important: true });
    }
    let mut children = std::mem::take(&mut element.children);
    let path = Path { element, outer };
    let done = children.iter_mut().try_for_each(|child| apply(text, child, Some(&path), colour, rules, work));
    element.children = children;
    done
}

#[cfg(test)]
mod tests {
    use super::super::xml::parse;
    use super::*;

    fn styled(sheet: &str, body: &str) -> Element {
        let text = format!("<svg><style>{sheet}</style>{body}</svg>");
        let mut root = parse(&text).unwrap();
        cascade(&text, &mut root).unwrap();
        root.children.pop().unwrap()
    }

    #[test]
    fn the_more_specific_then_the_later_rule_wins_and_the_style_attribute_over_both() {
        let sheet = "/* {} */ stop { stop-color: red } .a{stop-color:lime;stop-opacity:.5} stop{stop-color:blue}";
        let of = |stop: &str| styled(sheet, stop).property("stop-color").map(str::to_owned);
        assert_eq!(of("<stop/>").as_deref(), Some("blue"));
        assert_eq!(of("<stop class='b a'/>").as_deref(), Some("lime"));
        assert_eq!(of("<stop class='a' style='stop-color:#123'/>").as_deref(), Some("#123"));
        assert_eq!(of("<stop stop-color='white'/>").as_deref(), Some("blue"), "attributes are weakest");
        let important = "stop{stop-color:red !important}";
        assert_eq!(styled(important, "<stop style='stop-color:#123'/>").property("stop-color"), Some("red"));
    }

    #[test]
    fn descendants_lists_and_identifiers() {
        let sheet = "@font-face{src:url(x)} @import 'y'; #m .p stop, #n{fill:red} g>stop{fill:blue} a:hover{fill:lime}";
        let inner = |body: &str| {
            let mut at = &styled(sheet, body);
            while let Some(child) = at.children.first() {
                at = child;
            }
            at.property("fill").map(str::to_owned)
        };
        assert_eq!(inner("<g id='m'><g class='p'><g><stop/></g></g></g>").as_deref(), Some("red"));
        assert_eq!(inner("<g class='p'><g id='m'><stop/></g></g>"), None, "in the other order");
        assert_eq!(inner("<stop id='n'/>").as_deref(), Some("red"));
        assert_eq!(inner("<g><stop/></g>"), None, "of a kind that is not read");
        let text = format!("<svg><style>{sheet}</style></svg>");
        let note = cascade(&text, &mut parse(&text).unwrap()).unwrap().unwrap();
        assert!(note.starts_with("2 selectors"), "{note}");
    }

    #[test]
    fn the_current_colour_is_inherited() {
        let of = |body: &str| {
            let mut at = &styled(".x{color:#00f}", body);
            while let Some(child) = at.children.first() {
                at = child;
            }
            at.property("color").map(str::to_owned)
        };
        assert_eq!(of("<g class='x'><g><stop/></g></g>").as_deref(), Some("#00f"));
        assert_eq!(of("<g class='x'><stop color='red'/></g>").as_deref(), Some("red"));
        assert_eq!(of("<g><stop/></g>"), None);
    }

    #[test]
    fn unfinished_sheets_end() {
        for sheet in
            ["{", "}", "a{", "a{fill:red", "/*", "@x", "@x{{}", ",{fill:red}", "a{;:;!important}", ".{fill:red}"]
        {
            styled(sheet, "<a/>");
        }
    }

    #[test]
    fn many_rules_on_many_elements_are_refused() {
        let sheet = "stop{fill:red}".repeat(20_000);
        let text = format!("<svg><style>{sheet}</style>{}</svg>", "<g/>".repeat(6_000));
        let fault = cascade(&text, &mut parse(&text).unwrap()).unwrap_err();
        assert!(format!("{fault:?}").contains("too many rules"));
    }
}
