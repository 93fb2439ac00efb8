use std::io::Read;
use std::process::Stdio;

use crate::{command, folder_with, zerorate};

const SUBCOMMANDS: [&str; 11] = [
    "fit",
    "apply",
    "export",
    "verify",
    "characterise",
    "report",
    "info",
    "setup",
    "device",
    "virtual-board",
    "completions",
];

#[test]
fn every_subcommand_explains_itself_with_examples() {
    let folder = tempfile::tempdir().unwrap();
    for subcommand in SUBCOMMANDS {
        let help = zerorate(folder.path(), &[subcommand, "--help"]);
        assert_eq!((help.code, help.err.as_str()), (0, ""));
        help.says(&["Usage: zerorate", "Examples:\n  zerorate", subcommand]);
        assert!(help.out.lines().all(|line| line.chars().count() <= 120), "{}", help.out);
    }
    for verb in ["info", "monitor", "stream", "mode", "tap", "deploy", "read", "faults", "first-time", "self-test"] {
        let help = zerorate(folder.path(), &["device", verb, "--help"]);
        help.says(&["Usage: zerorate device", "--port", "--json", "Examples:\n  zerorate device", verb]);
    }
    let top = zerorate(folder.path(), &["--help"]);
    SUBCOMMANDS.iter().for_each(|subcommand| top.says(&[&format!("\n  {subcommand} ")]));
    top.says(&["Exit codes: 0 done"]);
}

#[test]
fn without_a_subcommand_the_help_is_shown_as_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let ran = zerorate(folder.path(), &[]);
    assert_eq!((ran.code, ran.out.as_str()), (2, ""));
    ran.says(&["Usage: zerorate"]);
}

#[test]
fn what_is_wrong_with_the_arguments_is_told_to_programs_too() {
    let folder = folder_with("half.csv", "a,b\n1,2\n");
    for (arguments, told) in [
        (&["fit", "half.csv", "--units", "furlong", "--json"][..], "invalid value 'furlong' for '--units <UNIT>'"),
        (&["export", "--format", "rust", "--json"], "'rust' is no format"),
        (&["export", "--json"], "were not provided: --format <FORMAT>"),
        (&["fitt", "--json"], "unrecognized subcommand 'fitt'"),
        (&["device", "--json"], "requires a subcommand"),
    ] {
        let ran = zerorate(folder.path(), arguments);
        assert_eq!(ran.code, 2, "{}", ran.err);
        let json = ran.json();
        let error = json["error"].as_str().unwrap();
        assert!(error.contains(told) && !error.contains("error:") && !error.contains("Usage"), "{error}");
        assert!(!ran.err.is_empty());
    }
    let help = zerorate(folder.path(), &["fit", "--help", "--json"]);
    assert_eq!((help.code, help.out.starts_with('{')), (0, false));
}

#[test]
fn the_version_is_told() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(zerorate(folder.path(), &["--version"]).out, concat!("zerorate ", env!("CARGO_PKG_VERSION"), "\n"));
}

#[test]
fn completions_are_there_for_the_usual_shells() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let ran = zerorate(folder.path(), &["completions", shell]);
        assert_eq!(ran.code, 0);
        ran.says(&["zerorate", "allow-narrow"]);
    }
}

#[test]
fn a_reader_who_goes_away_ends_the_command_quietly() {
    let folder = folder_with("a.csv", "a,b\n1,2\n");
    let mut child = command(folder.path())
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut told = String::new();
    child.stderr.take().unwrap().read_to_string(&mut told).unwrap();
    assert_eq!((child.wait().unwrap().code(), told.as_str()), (Some(0), ""));
}

#[test]
fn nothing_is_coloured_where_no_terminal_is() {
    let folder = folder_with("a.csv", "a,b\n1,2\n");
    let ran = zerorate(folder.path(), &["fit", "a.csv"]);
    assert!(!ran.err.contains('\u{1b}') && ran.code == 2);
}
