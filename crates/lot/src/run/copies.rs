//! Recordings that hold the same readings: copies of one run, which is one unit's.

use std::collections::BTreeMap;

use zerorate_cal::quality::{Reason, ReasonKind};
use zerorate_report::few;

use crate::models::ModelRow;

/// Warns of each recording whose readings another one has, to the last bit; the rows of a recording stand side by side.
pub(super) fn judge(rows: &mut [ModelRow]) {
    let mut by_readings: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for unit in rows.chunk_by(of_one_file).filter(|unit| !unit[0].readings_sha256.is_empty()) {
        by_readings.entry(&unit[0].readings_sha256).or_default().push((&unit[0].file, &unit[0].unit_serial));
    }
    by_readings.retain(|_, files| files.len() > 1);
    let mut told: BTreeMap<String, Reason> = BTreeMap::new();
    for files in by_readings.values() {
        let of_one = files.iter().all(|(_, serial)| *serial == files[0].1);
        let advice = if of_one {
            "it is one run under several names: keep one of them"
        } else {
            "it is one run under several serials, and tells of one unit: find out of which, and record the others"
        };
        for (own, _) in files {
            let others = files.iter().filter(|(file, _)| file != own);
            let others: Vec<String> = others.map(|(file, serial)| format!("{file} (serial {serial})")).collect();
            let others = few(&others.iter().map(String::as_str).collect::<Vec<_>>());
            let text = format!("its readings are those of {others}, to the last bit: {advice}");
            told.insert((*own).to_owned(), Reason::new(ReasonKind::Copied, text));
        }
    }
    for row in rows {
        if let Some(reason) = told.get(&row.file) {
            let reasons: Vec<Reason> = row.reason_list().into_iter().chain([reason.clone()]).collect();
            row.judge(&reasons);
        }
    }
}

fn of_one_file(a: &ModelRow, b: &ModelRow) -> bool {
    a.file == b.file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_told_on_each_of_them_and_recordings_without_a_ramp_are_none() {
        let row = |file: &str, serial: &str, readings: &str| ModelRow {
            file: file.into(),
            unit_serial: serial.into(),
            readings_sha256: readings.into(),
            ..ModelRow::default()
        };
        let pairs = [("a", "1", "aa"), ("b", "2", "bb"), ("c", "3", "aa"), ("d", "4", ""), ("e", "5", "")];
        let mut rows: Vec<ModelRow> =
            pairs.iter().flat_map(|it| [row(it.0, it.1, it.2), row(it.0, it.1, it.2)]).collect();
        judge(&mut rows);
        let told: Vec<usize> = rows.iter().map(|row| row.reason_list().len()).collect();
        assert_eq!(told, [1, 1, 0, 0, 1, 1, 0, 0, 0, 0]);
        assert!(rows[0].verdict == "warning" && rows[0].reason_list()[0].text.contains("those of c (serial 3), to"));
        assert!(rows[4].reason_list()[0].text.ends_with("of which, and record the others"));
        let mut rows = [row("a", "1", "aa"), row("b", "1", "aa")];
        judge(&mut rows);
        assert!(
            rows[1].reason_list()[0].text.ends_with(
                "those of a (serial 1), to the last bit: it is one run under several names: keep one of them"
            )
        );
    }
}
