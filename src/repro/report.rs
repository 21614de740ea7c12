//! The report: one HTML file that needs nothing else.

use super::record::{Item, Origin, Record};
use super::{ReproError, FIGURES};
use base64::prelude::{Engine, BASE64_STANDARD};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const STYLE: &str = include_str!("report.css");

/// Titles of the papers, by key.
const PAPERS: [(&str, &str); 4] = [
    ("ZHHK22", "Feature-Adaptive and Hierarchical Subdivision Gradient Meshes"),
    ("BLHK18", "Locally refinable gradient meshes supporting branching and sharp colour transitions"),
    ("ZBK23", "Subdivision Shading for Catmull-Clark and Loop Subdivision Surfaces with Semi-Sharp Creases"),
    ("BS05", "Generic Mesh Refinement on GPU"),
];

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The report of finished figures and their folders.
///
/// # Errors
/// A file of a figure cannot be read.
pub fn html(figures: &[(PathBuf, Record)]) -> Result<String, ReproError> {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>gradtess: the papers' figures</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>The papers' tables and figures, made by gradtess</h1>\n"
    );
    let mut origins: Vec<&Origin> = Vec::new();
    for (_, record) in figures {
        if !origins.contains(&&record.origin) {
            origins.push(&record.origin);
        }
    }
    for origin in &origins {
        out += &origin_line(origin);
    }
    let missing: Vec<&str> = FIGURES
        .iter()
        .filter(|figure| figures.iter().all(|(_, record)| record.id != figure.id))
        .map(|figure| figure.id)
        .collect();
    if !missing.is_empty() {
        let _ = writeln!(out, "<p>Not in this report: {}.</p>", missing.join(", "));
    }
    out += "</header>\n<nav>\n";
    let name = |path: &Path| escape(&path.file_name().unwrap_or_default().to_string_lossy());
    for (key, title) in PAPERS {
        let own = || figures.iter().filter(|(_, record)| record.paper == key);
        if own().next().is_some() {
            let links: Vec<String> = own()
                .map(|(path, r)| {
                    format!("<a href=\"#{}\" title=\"{}\">{}</a>", name(path), escape(&r.title), escape(&r.place))
                })
                .collect();
            let _ = writeln!(out, "<p><b>{key}</b> <i>{title}</i><br>{}</p>", links.join(" · "));
        }
    }
    out += "</nav>\n";
    for (path, record) in figures {
        section(&mut out, path, &name(path), record, origins.len() > 1)?;
    }
    out += "</body>\n</html>\n";
    Ok(out)
}

fn origin_line(origin: &Origin) -> String {
    let host = origin.host.as_ref().map_or(String::new(), |host| format!(", host {}", escape(host)));
    format!(
        "<p>gradtess {} ({} build) on {} ({}){host}. {} {}</p>\n",
        escape(&origin.program),
        escape(&origin.profile),
        escape(&origin.device),
        escape(&origin.driver),
        if origin.full {
            "Timings follow the whole protocol."
        } else {
            "Timings follow a short protocol: they show that all works and which way ratios point; <code>--full</code> runs the whole."
        },
        if origin.models {
            "The authors' published models stand beside scenes of our own; <code>$MODELS</code> in commands is their folder."
        } else {
            "Scenes of our own; <code>--models DIR</code> adds those of the authors."
        },
    )
}

fn section(out: &mut String, folder: &Path, name: &str, record: &Record, several: bool) -> Result<(), ReproError> {
    let _ = writeln!(
        out,
        "<section id=\"{name}\">\n<h2><span>{} {}</span> {}</h2>\n<p>{}</p>",
        escape(&record.paper),
        escape(&record.place),
        escape(&record.title),
        escape(&record.caption)
    );
    if several {
        *out += &origin_line(&record.origin);
    }
    let mut pictures = false;
    for item in &record.items {
        let is_picture = matches!(item, Item::Picture { .. });
        if is_picture != pictures {
            *out += if is_picture { "<div class=\"row\">\n" } else { "</div>\n" };
            pictures = is_picture;
        }
        let path = folder.join(item.file());
        match item {
            Item::Picture { caption, .. } => {
                let bytes = std::fs::read(&path).map_err(|e| ReproError::file(&path, e))?;
                let _ = writeln!(
                    out,
                    "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>",
                    escape(caption),
                    BASE64_STANDARD.encode(bytes)
                );
            }
            Item::Plot { caption, .. } => {
                let svg = std::fs::read_to_string(&path).map_err(|e| ReproError::file(&path, e))?;
                let _ =
                    writeln!(out, "<figure class=\"plot\">{svg}<figcaption>{}</figcaption></figure>", escape(caption));
            }
            Item::Table { caption, columns, rows, .. } => table(out, caption, columns, rows),
        }
    }
    if pictures {
        *out += "</div>\n";
    }
    for note in &record.notes {
        let _ = writeln!(out, "<p class=\"note\">{}</p>", escape(note));
    }
    let files: Vec<&str> = record.items.iter().map(Item::file).filter(|file| file.ends_with(".csv")).collect();
    let data = if files.is_empty() { String::new() } else { format!(" Data: {}.", files.join(", ")) };
    let _ = writeln!(
        out,
        "<details><summary><code>gradtess repro -o DIR --only {}</code>, {:.0} s, which ran:</summary>\n<pre>{}</pre>\n\
         <p class=\"data\">In <code>figures/{name}/</code>.{}</p></details>\n</section>",
        escape(&record.id),
        record.seconds,
        escape(&record.commands.join("\n")),
        escape(&data)
    );
    Ok(())
}

fn table(out: &mut String, caption: &str, columns: &[String], rows: &[Vec<String>]) {
    let _ = write!(out, "<div class=\"scroll\"><table><caption>{}</caption>\n<tr>", escape(caption));
    for column in columns {
        let _ = write!(out, "<th>{}</th>", escape(&column.replace('_', " ")));
    }
    *out += "</tr>\n";
    for row in rows {
        *out += "<tr>";
        for cell in row {
            let number = cell.parse::<f64>().is_ok() || cell == "NA";
            let _ = write!(out, "<td{}>{}</td>", if number { " class=\"n\"" } else { "" }, escape(&shown(cell)));
        }
        *out += "</tr>\n";
    }
    *out += "</table></div>\n";
}

/// A cell as it is shown: six digits are enough to read; the CSV file has all.
fn shown(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if cell.contains(['.', 'e']) && x != 0.0 => {
            let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
            if x.abs() < 1e-6 {
                format!("{x:.2e}")
            } else {
                format!("{x:.digits$}")
            }
        }
        _ => cell.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_shortened_only_where_they_are_fractions() {
        assert_eq!(shown("158976"), "158976");
        assert_eq!(shown("0.123456789"), "0.1235");
        assert_eq!(shown("12.3456789"), "12.35");
        assert_eq!(shown("0.00000000000123"), "1.23e-12");
        assert_eq!(shown("cherry"), "cherry");
        assert_eq!(shown("0.0"), "0.0");
    }
}
