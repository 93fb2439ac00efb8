//! The page of several boards in one chamber: where each of them is, and where its own page is.

use maud::html;

use super::{LiveRun, NOTES, NOW, left, page_of_parts};
use crate::page::{self, Table, told};

/// Notes of a board that are shown here; its own page has them all.
const NOTES_SHOWN: usize = 3;

/// One of the boards.
#[derive(Debug, Clone)]
pub struct LiveBoard {
    /// Its serial number.
    pub serial: String,
    /// The address of its own page.
    pub url: String,
    /// Its run as far as it has got.
    pub run: LiveRun,
}

/// Several boards that are run together.
#[derive(Debug, Clone)]
pub struct LiveBoards(pub Vec<LiveBoard>);

impl LiveBoards {
    /// The page around the parts, for runs of this title.
    #[must_use]
    pub fn page(title: &str) -> String {
        page_of_parts("Runs as they go", title, &[("told", "What was told last", NOTES)])
    }

    /// The parts as they are now, by their ids.
    #[must_use]
    pub fn parts(&self) -> Vec<(&'static str, String)> {
        let Self(boards) = self;
        let over = boards.iter().filter(|board| board.run.ended.is_some()).count();
        let mut facts = vec![("Boards", html! { (over) " of " (boards.len()) " over" })];
        // All are in one chamber.
        facts.extend(boards.iter().find_map(|board| board.run.air()).map(|air| ("Chamber", html! { (air) })));
        let now = html! {
            (page::facts(&facts))
            (Table {
                caption: html! {
                    "Each board's newest group. What the fit of its ramp leaves so far is in-sample. Its name leads to its own page, with \
                     its figures."
                },
                heads: &["Board", "Step", "Now", "Temperature", "Zero-rate output, counts", "Fit leaves, counts rms", "Ends about"],
                rows: boards.iter().map(LiveBoard::row).collect(),
                numbers_from: 7,
            }.wide_markup())
        };
        let newest = |board: &LiveBoard| {
            let name = board.serial.clone();
            board.run.notes.iter().take(NOTES_SHOWN).cloned().map(move |note| (name.clone(), note)).collect::<Vec<_>>()
        };
        let notes: Vec<_> = boards.iter().flat_map(newest).collect();
        let notes = html! {
            @if notes.is_empty() { p { "Nothing so far." } } @else {
                ul.reasons { @for (serial, (at, note)) in &notes { li { (serial) " " span.small { (at) } " " (told(note)) } } }
            }
        };
        vec![(NOW, now.into_string()), (NOTES, notes.into_string())]
    }
}

impl LiveBoard {
    fn row(&self) -> Vec<maud::Markup> {
        let run = &self.run;
        let text = |text: Option<String>| html! { (text.unwrap_or_else(|| "–".to_owned())) };
        let now = match &run.ended {
            Some(ended) => told(ended),
            None => text(Some(run.doing.clone()).filter(|doing| !doing.is_empty())),
        };
        vec![
            html! { a href=(self.url) { (self.serial) } },
            text(run.step()),
            now,
            text(run.temperature()),
            text(run.output()),
            text(left(&run.axes.each_ref().map(|axis| run.fit(axis)))),
            text(run.ends.clone().filter(|_| run.ended.is_none())),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RunGroup, RunStep, StepState};
    use super::*;

    fn board(serial: &str, reading_counts: f64) -> LiveBoard {
        let mut run = LiveRun { air_c: 21.5, doing: "heating ramp".into(), ..LiveRun::default() };
        let states = [StepState::Done, StepState::Now].into_iter();
        let step =
            |state| RunStep { name: "trim experiment".into(), chamber: String::new(), takes: String::new(), state };
        run.steps = states.map(step).collect();
        run.axes[1].push(RunGroup {
            time_s: 0.0,
            temperature_counts: 9860.0,
            reading_counts,
            is_ramp: true,
            is_compensated: false,
        });
        LiveBoard { serial: serial.into(), url: format!("http://127.0.0.1/{serial}"), run }
    }

    #[test]
    fn each_board_has_a_row_of_its_own_with_the_way_to_its_page_and_one_that_ended_says_how() {
        let mut boards = LiveBoards(vec![board("A-1", 8192.04), board("A-2", 7000.0)]);
        boards.0[1].run.ended = Some("The unit was <rejected>.".into());
        boards.0[1].run.notes = (0..5).map(|note| (format!("10:0{note}"), format!("note {note}"))).collect();
        let parts = boards.parts();
        let [(_, now), (_, notes)] = &parts[..] else { panic!("{parts:?}") };
        let rows: Vec<&str> = now.split("<tr>").skip(2).collect();
        assert!(rows.len() == 2 && now.contains("1 of 2 over") && now.contains("21.5\u{a0}°C"), "{now}");
        assert!(
            rows[0].contains("<a href=\"http://127.0.0.1/A-1\">A-1</a>") && rows[0].contains("2 of 2: trim"),
            "{now}"
        );
        assert!(
            rows[0].contains("Y\u{a0}8192.0") && rows[0].contains("9860 counts") && rows[0].contains("heating"),
            "{now}"
        );
        assert!(rows[1].contains("The unit was &lt;rejected&gt;.") && !rows[1].contains("heating"), "{now}");
        assert!(notes.contains("note 2") && !notes.contains("note 3") && !now.contains("NaN"), "{notes}");
        let page = LiveBoards::page("Calibration of 2 boards");
        assert!(parts.iter().all(|(id, _)| page.contains(&format!("<div id=\"{id}\"></div>"))));
    }
}
