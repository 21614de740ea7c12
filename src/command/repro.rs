//! `gradtess repro`: every table and figure of the papers.

use super::{print, print_json, Failure, Global};
use crate::gpu::Gpu;
use crate::repro::record::Origin;
use crate::repro::{self, ReproError, Request, Shard, FIGURES};
use crate::timing::host::Host;
use clap::Args;
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `repro`.
#[derive(Args)]
pub struct Repro {
    /// Folder for figures/ID/*, scenes/* and report.html; figures that it has already are kept
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Folder of the authors' models, searched by name; ours are drawn in any case
    #[arg(long, value_name = "DIR")]
    models: Option<PathBuf>,
    /// Figures by name, such as fig20, zhhk22-fig20, or zhhk22 for all of a paper
    #[arg(long, value_name = "ID,...", value_delimiter = ',')]
    only: Vec<String>,
    /// Part I of N of the figures, I from 1
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// The whole protocol of timings: hours on a software rasteriser
    #[arg(long)]
    full: bool,
    /// Timed frames of each repeat [default: 12 (144 of those below 5 ms), with --full 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Copy the figures of other output folders into this one instead of making any
    #[arg(long, num_args = 1.., value_name = "DIR", conflicts_with_all = ["models", "only", "shard", "full", "frames"])]
    merge: Vec<PathBuf>,
    /// Names of the figures, with --only and --shard those chosen
    #[arg(long, conflicts_with = "merge")]
    list: bool,
}

fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse::<usize>().ok()?, n.parse::<usize>().ok()?)));
    match parts {
        Some((i, of)) if i >= 1 && i <= of => Ok(Shard { index: i - 1, of }),
        _ => Err("give I/N with I from 1 to N, such as 2/8".to_owned()),
    }
}

#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    report: String,
    made: &'a [&'static str],
    kept: &'a [&'static str],
    failed: Vec<serde_json::Value>,
}

impl From<ReproError> for Failure {
    fn from(e: ReproError) -> Self {
        if e.is_request() {
            Failure::input(e)
        } else {
            Failure::machine(e)
        }
    }
}

impl Repro {
    /// Makes, merges or lists.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        if self.list {
            return self.names(global);
        }
        let Some(output) = &self.output else {
            return Err(Failure::input("give a folder with -o DIR"));
        };
        // Commands run in it.
        std::fs::create_dir_all(output).map_err(|e| Failure::machine(format_args!("{}: {e}", output.display())))?;
        if !self.merge.is_empty() {
            return self.merge(output, global);
        }
        let gpu = Gpu::new(&global.gpu())?;
        let request = Request {
            output: output.clone(),
            models: self.models.clone(),
            only: self.only.clone(),
            shard: self.shard,
            flags: flags(global),
            origin: self.origin(&gpu),
        };
        // The figures' commands open the device anew.
        drop(gpu);
        if cfg!(debug_assertions) {
            global.warn("this is a debug build; its times mean little");
        }
        let begun = Instant::now();
        let done = repro::run(request, |figure, i, n| {
            if !global.quiet && !global.json {
                eprintln!(
                    "[{:>3}/{n}] {:>5.0} s  {}: {}",
                    i + 1,
                    begun.elapsed().as_secs_f64(),
                    figure.id,
                    figure.title
                );
            }
        })?;
        if global.json {
            print_json(&Report {
                schema: "gradtess.repro/1",
                report: done.report.display().to_string(),
                made: &done.made,
                kept: &done.kept,
                failed: done.failed.iter().map(|(id, e)| json!({"id": id, "error": e.to_string()})).collect(),
            })?;
        } else if !global.quiet {
            let (made, kept) = (done.made.len(), done.kept.len());
            print(&format!("{}: {made} figures made, {kept} kept\n", done.report.display()));
        }
        for (id, e) in done.failed.iter().skip(1) {
            global.warn(format_args!("{id} was not made: {e}"));
        }
        match done.failed.into_iter().next() {
            None => Ok(()),
            Some((id, e)) => {
                let text = format!("{id} was not made: {e}");
                Err(if e.is_request() { Failure::input(text) } else { Failure::machine(text) })
            }
        }
    }

    fn names(&self, global: &Global) -> Result<(), Failure> {
        let chosen = repro::plan(&self.only, self.shard)?;
        if global.json {
            let figure = |f: &&repro::Figure| json!({"id": f.id, "paper": f.paper, "place": f.place, "title": f.title});
            let all: Vec<_> = chosen.iter().map(figure).collect();
            return print_json(&json!({"schema": "gradtess.repro-list/1", "figures": all}));
        }
        let wide = FIGURES.iter().map(|figure| figure.id.len()).max().unwrap_or(0);
        for figure in chosen {
            print(&format!("{:<wide$}  {}: {}\n", figure.id, figure.place, figure.title));
        }
        Ok(())
    }

    fn merge(&self, output: &Path, global: &Global) -> Result<(), Failure> {
        let (report, copied) = repro::merge(output, &self.merge)?;
        let report = report.display().to_string();
        if global.json {
            return print_json(&json!({"schema": "gradtess.repro-merge/1", "report": report, "copied": copied}));
        }
        if !global.quiet {
            print(&format!("{report}: {copied} figures copied\n"));
        }
        Ok(())
    }

    fn origin(&self, gpu: &Gpu) -> Origin {
        let device = gpu.device();
        let commit = env!("GRADTESS_COMMIT").get(..12).map_or(String::new(), |commit| format!(" {commit}"));
        let changed = if env!("GRADTESS_DIRTY").parse() == Ok(true) { "+" } else { "" };
        Origin {
            program: format!("{}{commit}{changed}", env!("CARGO_PKG_VERSION")),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.to_owned(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            host: Host::here().cpu,
            full: self.full,
            frames: self.frames,
            models: self.models.is_some(),
        }
    }
}

/// Flags that a figure's commands get.
fn flags(global: &Global) -> Vec<String> {
    let device = global.device.iter().flat_map(|name| ["--device".to_owned(), name.clone()]);
    device.chain(global.validate.then(|| "--validate".to_owned())).collect()
}
