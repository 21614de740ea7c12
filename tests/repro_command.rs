//! `gradtess repro`: figures whose numbers are known beforehand. Runs the program itself.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder of its own that is gone at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        Folder(std::env::temp_dir().join(format!("gradtess-repro-{name}-{}", std::process::id())))
    }

    fn table(&self, file: &str) -> Vec<Vec<String>> {
        let text = std::fs::read_to_string(self.0.join("figures").join(file)).unwrap();
        text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn repro(folder: &Path, flags: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gradtess"));
    let done = command.args(["repro", "--json", "--quiet", "-o"]).arg(folder).args(flags).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn figures_have_the_numbers_that_the_paper_says_and_are_kept() {
    let folder = Folder::new("numbers");
    repro(&folder.0, &["--only", "zhhk22-fig4,zhhk22-fig6,zhhk22-fig7,zhhk22-fig11"]);

    // 4.1: the non-quad and its six neighbours, seven faces, are refined.
    let faces = folder.table("zhhk22-fig7/faces.csv");
    assert_eq!(faces[0], ["faces_M0", "non_quads", "refined", "drawn_at_level_0", "drawn_at_level_1"]);
    assert_eq!(faces[1], ["16", "1", "7", "9", "27"]);

    // 4.2: a geometry edit affects its two-ring, a colour edit its three-ring.
    let affected = folder.table("zhhk22-fig6/affected.csv");
    assert_eq!(affected[1][..4], ["geometry", "2", "16", "16"]);
    assert_eq!(affected[2][..4], ["colour", "3", "36", "36"]);

    // NLMD12 section 4: one edge, two adjacent, two opposite, three, four.
    let shown = folder.table("zhhk22-fig4/constellations.csv");
    assert_eq!(shown.iter().skip(1).map(|row| row[3].as_str()).collect::<Vec<_>>(), ["1", "2", "2", "3", "4"]);

    // Where the drag has stopped nothing is turned over; a little farther something is.
    let folds = folder.table("zhhk22-fig11/folds.csv");
    assert_eq!(folds.len(), 5);
    for pair in folds[1..].chunks(2) {
        assert_eq!((pair[0][1].as_str(), pair[0][4].as_str(), pair[0][5].as_str()), ("stopped", "0", "0"));
        assert!(pair[1][4].parse::<u32>().unwrap() > 0, "{pair:?}");
        assert!(pair[0][2].parse::<f64>().unwrap() > 0.05, "{pair:?}");
    }

    let report = std::fs::read_to_string(folder.0.join("report.html")).unwrap();
    assert_eq!(report.matches("<section").count(), 4);
    assert!(!report.contains("src=\"http") && !report.contains("<script") && !report.contains("<link"));

    // Again: all four of them are there.
    let again = repro(&folder.0, &["--only", "zhhk22-fig7"]);
    assert!(again.contains("\"made\":[]") && again.contains("\"kept\":[\"zhhk22-fig7\"]"), "{again}");
}
