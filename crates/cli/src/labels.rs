//! What is doubtful in labels, told where they are typed.

use std::collections::BTreeMap;
use std::time::SystemTime;

use zerorate_cal::recording::label_doubts;

use crate::screen;

/// Sentences, as of today.
pub fn doubts(labels: &BTreeMap<String, String>) -> Vec<String> {
    label_doubts(labels, SystemTime::now().into())
}

/// Tells them beside what the command prints.
pub fn tell_doubts(labels: &BTreeMap<String, String>) {
    doubts(labels).iter().for_each(|sentence| screen::note(sentence));
}
