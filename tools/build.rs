//! Tells the program what it is compiled from, for `run.json`.

use std::process::Command;

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let out = Command::new(program).args(arguments).output().ok()?;
    out.status.success().then(|| String::from_utf8_lossy(&out.stdout).trim().to_owned())
}

fn main() {
    let release = std::env::var("PROFILE").is_ok_and(|p| p == "release");
    // What goes into the program; a change there means compiling anyway.
    let sources = ["src", "spv", "tools/build.rs", "Cargo.toml", "Cargo.lock"];
    for source in sources {
        println!("cargo::rerun-if-changed={source}");
    }
    // Every commit, but only where numbers are to be believed: debug builds would be compiled over and over.
    if release && std::path::Path::new(".git/logs/HEAD").exists() {
        println!("cargo::rerun-if-changed=.git/logs/HEAD");
    }
    let set = |name: &str, value: Option<String>| println!("cargo::rustc-env={name}={}", value.unwrap_or_default());
    set("GRADTESS_COMMIT", output("git", &["rev-parse", "HEAD"]));
    let changed = output("git", &[&["status", "--porcelain", "--untracked-files=no", "--"][..], &sources[..]].concat());
    set("GRADTESS_DIRTY", changed.map(|lines| (!lines.is_empty()).to_string()));
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    set("GRADTESS_RUSTC", output(&rustc, &["--version"]));
    let mut features: Vec<String> =
        std::env::vars().filter_map(|(name, _)| Some(name.strip_prefix("CARGO_FEATURE_")?.to_lowercase())).collect();
    features.sort();
    set("GRADTESS_FEATURES", Some(features.join(",")));
}
