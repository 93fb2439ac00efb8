//! Tables of text.

use console::{Alignment, Style, pad_str};

use super::style;

/// A table: words to the left, numbers to the right, two spaces between.
#[derive(Debug)]
pub struct Grid {
    heads: usize,
    columns: Vec<Alignment>,
    rows: Vec<Vec<String>>,
}

impl Grid {
    /// An empty table; `columns` has a letter a column: `l` to the left, `r` to the right.
    pub fn new(columns: &str) -> Self {
        let alignment = |letter| if letter == 'r' { Alignment::Right } else { Alignment::Left };
        Self { heads: 0, columns: columns.chars().map(alignment).collect(), rows: Vec::new() }
    }

    /// Adds a line of headings; those that are added first stand on top.
    pub fn head<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.heads += 1;
        self.row(cells);
    }

    /// Adds a row.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// The table's lines.
    pub fn lines(&self) -> Vec<String> {
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| console::measure_text_width(cell)).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).zip(&self.columns);
            let cells = cells.map(|((cell, &width), &alignment)| pad_str(cell, width, alignment, None).into_owned());
            format!("  {}", cells.collect::<Vec<_>>().join("  ").trim_end())
        };
        let heads = self.rows[..self.heads].iter().map(|row| style(Style::new().dim(), line(row)).to_string());
        heads.chain(self.rows[self.heads..].iter().map(line)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_left_and_numbers_right() {
        let mut grid = Grid::new("lr");
        grid.head(["axis", "drift"]);
        grid.row(["x", "1.5"]);
        grid.row(["gyro_y", "20.4"]);
        assert_eq!(grid.lines(), ["  axis    drift", "  x         1.5", "  gyro_y   20.4"]);
    }
}
