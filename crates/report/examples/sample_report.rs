//! Writes the reports of invented runs, to be looked at: `cargo run -p zerorate-report --example sample_report`.
//! They go to `target/sample-reports`, or to the folder given.

#[path = "../tests/sample/mod.rs"]
mod sample;

use std::path::PathBuf;
use std::{env, fs, io};

use zerorate_report::{LogPage, board_page};

fn main() -> io::Result<()> {
    let folder = env::args_os().nth(1).map_or_else(|| PathBuf::from("target/sample-reports"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let log = sample::log();
    let pages = [
        ("calibration.html", board_page(&sample::board_run(), None)),
        (
            "log.html",
            LogPage {
                fit: &log,
                units: None,
                serial: Some("ZR-0007"),
                labels: &[("operator".to_owned(), "A. N.".to_owned())].into(),
                chamber: None,
                sources: &[],
                next_command: Some("zerorate apply"),
                export_command: None,
            }
            .to_html(),
        ),
        ("lot.html", sample::lot(204, 0.37).to_html()),
        ("small-lot.html", sample::lot(3, 0.05).to_html()),
    ];
    for (name, page) in pages {
        let path = folder.join(name);
        fs::write(&path, &page)?;
        println!("{} ({} kB)", path.display(), page.len() / 1000);
    }
    Ok(())
}
