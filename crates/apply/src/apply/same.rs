//! Whether two corrected logs are of one log.

use std::io::Read;

use csv::StringRecord;

/// Whether two texts that [`apply`](super::apply) wrote are of one log, by whatever calibrations: they have the same columns,
/// and in every row the same in those that no calibration made.
pub fn are_of_one_log(one: impl Read, other: impl Read) -> bool {
    let (mut one, mut other) = (rows(one), rows(other));
    let (Some(Ok(head)), Some(Ok(other_head))) = (one.next(), other.next()) else { return false };
    let made = |column: &str| column.starts_with("predicted_") || column.starts_with("corrected_");
    let kept: Vec<usize> = (0..head.len()).filter(|place| !made(&head[*place])).collect();
    let same = |one: &StringRecord, other: &StringRecord| kept.iter().all(|place| one.get(*place) == other.get(*place));
    head == other_head
        && loop {
            match (one.next(), other.next()) {
                (None, None) => break true,
                (Some(Ok(one)), Some(Ok(other))) if same(&one, &other) => {}
                _ => break false,
            }
        }
}

fn rows<R: Read>(text: R) -> csv::StringRecordsIntoIter<R> {
    csv::ReaderBuilder::new().has_headers(false).from_reader(text).into_records()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_corrected_logs_are_of_one_where_all_that_was_logged_is_the_same() {
        let old = "t,gx,predicted_gx,corrected_gx\n1,3,4,5\n2,6,7,8\n";
        for (new, same) in [
            (old, true),
            // By another calibration.
            ("t,gx,predicted_gx,corrected_gx\n1,3,4.5,5.5\n2,6,7,8\n", true),
            ("t,gx,predicted_gx,corrected_gx\n1,3,4,5\n", false),
            ("t,gx,predicted_gx,corrected_gx\n1,3,4,5\n2,6.5,7,8\n", false),
            // A column was added by hand.
            ("t,gx,predicted_gx,corrected_gx,mine\n1,3,4,5,1\n2,6,7,8,1\n", false),
            ("", false),
        ] {
            assert_eq!(are_of_one_log(old.as_bytes(), new.as_bytes()), same, "{new}");
            assert_eq!(are_of_one_log(new.as_bytes(), old.as_bytes()), same, "{new}");
        }
    }
}
