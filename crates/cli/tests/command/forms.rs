//! The forms themselves: sound, closed, and told.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::log::Log;
use crate::{folder_with, zerorate};

/// Objects that name their fields allow no others; a number says what it is and in what unit, itself or as its list does.
fn look(at: &str, form: &Value, told: bool) {
    let told = told || form["description"].is_string();
    let kinds = form["type"].to_string();
    assert!(told || !(kinds.contains("number") || kinds.contains("integer")), "{at}: a number without a description");
    if let Some(fields) = form["properties"].as_object() {
        assert_eq!(form["additionalProperties"], false, "{at}: it allows what it does not name");
        fields.iter().for_each(|(name, field)| look(&format!("{at}.{name}"), field, false));
    }
    if form["additionalProperties"].is_object() {
        look(&format!("{at}.*"), &form["additionalProperties"], false);
    }
    if form["items"].is_object() {
        look(&format!("{at}[]"), &form["items"], told);
    }
    for several in ["anyOf", "oneOf"] {
        form[several].as_array().into_iter().flatten().for_each(|one| look(at, one, told));
    }
    let shared = form["$defs"].as_object();
    shared.into_iter().flatten().for_each(|(name, one)| look(&format!("{at} {name}"), one, false));
}

#[test]
fn every_form_is_sound_and_closed_tells_its_numbers_and_stands_in_the_readme() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
    let readme = fs::read_to_string(folder.join("README.md")).unwrap();
    for file in fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if name == "README.md" {
            continue;
        }
        assert!(readme.contains(&format!("| [{name}]({name}) |")), "{name} is not in the README");
        let form: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        jsonschema::meta::validate(&form).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(form["$id"], format!("zerorate:/schemas/{name}"));
        look(name, &form, false);
    }
}

#[test]
fn what_is_made_of_a_calibration_tells_its_form() {
    let folder = folder_with("flight.ulg", Log::cycle().ulg());
    let run = |arguments: &[&str]| zerorate(folder.path(), arguments).json();
    let log = "flight.ulg";
    run(&["fit", log, "--out", "c.json", "--json"]);
    assert_eq!(run(&["apply", "c.json", log, "--out", "corrected.csv", "--json"])["out"], "corrected.csv");
    for format in ["px4", "ardupilot", "csv", "c"] {
        let out = format!("made.{format}");
        assert_eq!(run(&["export", "c.json", "--format", format, "--out", &out, "--json"])["out"], *out);
    }
    assert_eq!(run(&["verify", log, "--with", "c.json", "--in-sample", "--max-rms", "1dps", "--json"])["passed"], true);
    assert_eq!(run(&["info", "c.json", log, "corrected.csv", "--json"])["files"].as_array().unwrap().len(), 3);
    assert!(run(&["characterise", log, "--sensor", "gyro", "--json"])["noise"].is_array());
}
