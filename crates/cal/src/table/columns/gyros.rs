//! Several gyros side by side in one table.

use crate::table::words::{axis, numbers};

/// The rate columns of one gyro.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Gyro {
    /// Its number by its columns' names; `None` where the table has one gyro, however its columns are called.
    pub instance: Option<u8>,
    /// Its columns.
    pub columns: Vec<usize>,
}

/// More columns than a gyro has axes.
const AXES: usize = 3;

/// The gyros of some rate columns: up to three are one gyro, more are told apart by the numbers in their names, as
/// `gyro0_x` and `gyro1_x`. `None` where the names do not tell.
pub(super) fn split(columns: &[usize], words: &[Vec<String>]) -> Option<Vec<Gyro>> {
    if columns.len() <= AXES {
        return Some(vec![Gyro { instance: None, columns: columns.to_vec() }]);
    }
    let mut gyros: Vec<(Vec<String>, Vec<usize>)> = Vec::new();
    for &column in columns {
        axis(&words[column])?;
        let rest: Vec<String> =
            words[column].iter().filter(|word| axis(&[(*word).clone()]).is_none()).cloned().collect();
        match gyros.iter_mut().find(|(name, _)| *name == rest) {
            Some((_, own)) => own.push(column),
            None => gyros.push((rest, vec![column])),
        }
    }
    let numbers: Vec<Vec<u8>> = gyros.iter().map(|(name, _)| numbers(name)).collect();
    // Of `imu0_gyro1_x` it is the number in which the names differ.
    let place = (0..numbers[0].len()).find(|&place| differ(numbers.iter().map(|own| own.get(place).copied())))?;
    let is_one_name = gyros.iter().all(|(name, _)| without_digits(name) == without_digits(&gyros[0].0));
    let is_one_gyro = |own: &[usize]| differ(own.iter().map(|&column| axis(&words[column])));
    if gyros.len() < 2 || !is_one_name || !gyros.iter().all(|(_, own)| is_one_gyro(own)) {
        return None;
    }
    let gyro = |((_, columns), own): ((_, Vec<usize>), &Vec<u8>)| Gyro { instance: own.get(place).copied(), columns };
    Some(gyros.into_iter().zip(&numbers).map(gyro).collect())
}

/// Whether all are there, and no two are the same.
fn differ<T: PartialEq>(values: impl Iterator<Item = Option<T>>) -> bool {
    let mut seen = Vec::new();
    for value in values {
        if value.is_none() || seen.contains(&value) {
            return false;
        }
        seen.push(value);
    }
    true
}

fn without_digits(name: &[String]) -> Vec<String> {
    name.iter().map(|word| word.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned()).collect()
}
