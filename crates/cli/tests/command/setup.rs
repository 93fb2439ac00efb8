use std::fs;

use crate::{folder_with, schema, zerorate};

#[test]
fn what_is_printed_is_sound_and_the_same_as_the_papers() {
    let folder = tempfile::tempdir().unwrap();
    let printed = zerorate(folder.path(), &["setup"]);
    assert_eq!((printed.code, printed.err.as_str()), (0, ""));
    fs::write(folder.path().join("bench.toml"), &printed.out).unwrap();
    let checked = zerorate(folder.path(), &["setup", "--check", "bench.toml"]);
    assert_eq!(checked.code, 0);
    checked.says(&["bench.toml: sound, and the same as the paper's"]);
    let typical = zerorate(folder.path(), &["setup", "--plant", "typical"]);
    assert!(typical.out.contains("\nmodel = \"auto\"\n"));
    assert_eq!(zerorate(folder.path(), &["setup", "--json"]).json()["board"]["middle_tap"], 511);
}

#[test]
fn a_difference_from_the_paper_is_shown() {
    let folder = folder_with("bench.toml", "[chamber]\ncold_c = -20.0\n");
    let checked = zerorate(folder.path(), &["setup", "--check", "bench.toml"]);
    checked.says(&["chamber.cold_c  -20.0  -40.0"]);
    let json = zerorate(folder.path(), &["setup", "--check", "bench.toml", "--json"]).json();
    assert_eq!(json["differences"][0]["field"], "chamber.cold_c");
}

#[test]
fn a_set_up_that_contradicts_itself_is_refused_with_every_contradiction() {
    let folder =
        folder_with("bench.toml", "[chamber]\ncold_c = 70.0\n[trim]\npoints = 2\n[board]\nmiddle_tap = 2000\n");
    zerorate(folder.path(), &["setup", "--check", "bench.toml"]).is_error(&[
        "bench.toml contradicts itself",
        "chamber.cold_c 70 is not below chamber.hot_c 60",
        "trim.points 2",
        "board.middle_tap 2000 is not a tap",
    ]);
}

#[test]
fn a_limit_below_a_tap_is_told_and_what_is_not_known_is_not_claimed() {
    let folder = folder_with("bench.toml", "[limits]\ntrim_residual_pp_counts = 30.0\n");
    let check = ["setup", "--check", "bench.toml"];
    let checked = zerorate(folder.path(), &check);
    assert!(!checked.out.contains("sound"), "{}", checked.out);
    checked.says(&[
        "few units or chambers can do what it asks, if any",
        "Few can do, if any",
        "limits.trim_residual_pp_counts 30 is less than a tap as the circuit's drawing has it, 31.3 counts",
        "only where a unit's own taps are smaller",
    ]);
    let json = zerorate(folder.path(), &[&check[..], &["--json"]].concat()).json();
    assert_eq!(json["unreachable"].as_array().unwrap().len(), 1);
    fs::write(folder.path().join("bench.toml"), "[limits]\ntrim_residual_pp_counts = 32.0\n").unwrap();
    assert!(!zerorate(folder.path(), &check).out.contains("Few can"));
}

#[test]
fn a_ramp_that_no_chamber_goes_is_told() {
    // 100 K in 100 groups of 1.5 s.
    let folder = folder_with("bench.toml", "[chamber]\nramp_groups = 100\n");
    let checked = zerorate(folder.path(), &["setup", "--check", "bench.toml"]);
    assert_eq!(checked.code, 0);
    checked.says(&["few units or chambers can do", "100 K in them are 40.0 K/min", "1.7 K/min"]);
}

#[test]
fn the_plan_of_a_simulated_run_tells_the_rate_of_its_chamber() {
    // A ramp in half of the time: the chamber goes as it goes (bench holds that to the plant's own air).
    let folder = folder_with("bench.toml", "[chamber]\nramp_groups = 1200\n");
    let plan = ["calibrate", "--dry-run", "--setup", "bench.toml"];
    zerorate(folder.path(), &plan).says(&["to 60 C at 2.5 K/min", "simulated chamber goes at 2.5 K/min"]);
    let ran = zerorate(folder.path(), &[&plan[..], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    schema::hold("plan.json", &json);
    assert_eq!(json["ramp_k_per_min"], 2.5);
}

#[test]
fn what_is_no_set_up_is_named_by_line() {
    let folder = folder_with("bench.toml", "[chamber]\ncold = -40.0\n");
    let check = ["setup", "--check", "bench.toml"];
    zerorate(folder.path(), &check).is_error(&[
        "bench.toml, line 2: unknown field 'cold'",
        "'cold_c'",
        "zerorate setup",
    ]);
    fs::write(folder.path().join("bench.toml"), "[board]\n\nconverter_bits = \n").unwrap();
    zerorate(folder.path(), &check).is_error(&["bench.toml, line 3: "]);
    fs::write(folder.path().join("bench.toml"), "[chamber]\ncold_c = \"cold\"\n").unwrap();
    zerorate(folder.path(), &check).is_error(&["bench.toml, line 2: invalid type: string \"cold\", expected f64"]);
    zerorate(folder.path(), &["setup", "--check", "nothing.toml"]).is_error(&["nothing.toml", "No such file"]);
}

#[test]
fn a_label_that_should_be_a_date_and_can_be_none_is_told_where_it_is_typed() {
    let labels =
        "[labels]\noperator = \"A. N.\"\nchamber_calibrated = \"last spring\"\nsupply_calibrated = \"9999-12-31\"\n";
    let folder = folder_with("bench.toml", labels);
    let doubts = [
        "label chamber_calibrated = \"last spring\": this is no date, as 2026-02-01",
        "label supply_calibrated = \"9999-12-31\": this is in the future",
    ];
    let checked = zerorate(folder.path(), &["setup", "--check", "bench.toml"]);
    assert_eq!(checked.code, 0);
    checked.says(&doubts);
    let json = zerorate(folder.path(), &["setup", "--check", "bench.toml", "--json"]).json();
    assert_eq!(json["doubtful_labels"], serde_json::json!(doubts));
    let run = zerorate(folder.path(), &["calibrate", "--setup", "bench.toml"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(doubts.iter().all(|doubt| run.err.contains(doubt)), "{}", run.err);
    let sound = folder_with("bench.toml", "[labels]\nchamber_calibrated = \"2025-02-01\"\n");
    let checked = zerorate(sound.path(), &["setup", "--check", "bench.toml"]);
    assert!(!checked.out.contains("label chamber_calibrated ="), "{}", checked.out);
}
