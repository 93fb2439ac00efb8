//! Every JSON that a test sees is held against its form in docs/schemas.

use std::fs;
use std::path::Path;

use jsonschema::Registry;
use serde_json::Value;

/// Holds JSON against a form, as `fit.json`.
#[track_caller]
pub fn hold(form: &str, json: &Value) {
    let shared = ["common.json", "summary.json"].into_iter();
    let registry = shared
        .fold(Registry::new(), |registry, form| registry.add(format!("zerorate:/schemas/{form}"), read(form)).unwrap())
        .prepare()
        .unwrap();
    let validator = jsonschema::options().with_registry(&registry).build(&read(form)).unwrap();
    let wrong: Vec<String> =
        validator.iter_errors(json).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(wrong.is_empty(), "not as docs/schemas/{form} has it: {wrong:#?}");
}

fn read(form: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas").join(form);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap()
}

/// Holds what a command has printed with `--json` against the form of that command.
#[track_caller]
pub fn hold_printed(arguments: &[String], json: &Value) {
    let command = arguments.first().map_or("", String::as_str);
    let form = match command {
        _ if json.get("error").is_some() => "error".to_owned(),
        "calibrate" => "summary".to_owned(),
        "setup" if arguments.iter().any(|argument| argument == "--check") => "setup-check".to_owned(),
        "device" if json.get("refused").is_some() => "device-refused".to_owned(),
        "device" => format!("device-{}", verb(arguments)),
        command => command.to_owned(),
    };
    hold(&format!("{form}.json"), json);
}

fn verb(arguments: &[String]) -> &str {
    const VERBS: [&str; 9] = ["info", "monitor", "mode", "tap", "deploy", "read", "faults", "first-time", "self-test"];
    arguments.iter().map(String::as_str).find(|argument| VERBS.contains(argument)).unwrap()
}
