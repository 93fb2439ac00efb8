//! Figures: panels side by side with a key and a caption. A page shows two panels a row on a desktop and one on a phone,
//! so that one drawing serves both and its type stays legible.

mod frame;
mod ink;
mod mark;
mod panel;
mod path;
mod scale;
mod second;
mod thin;

use maud::{Markup, html};

pub(super) use ink::Ink;
pub(super) use mark::{Mark, Side};
pub(super) use panel::Panel;
use path::{Path, SPARSE, markers};
pub(super) use scale::{extent, holding};
pub(super) use second::Second;

/// How an ink is shown in a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sample {
    /// A piece of line.
    Line,
    /// A marker.
    Dot,
    /// A shaded patch.
    Patch,
}

/// A figure.
pub(super) struct Figure {
    /// Its place in the page, as `fig-2`.
    pub id: String,
    /// Its name in the caption, as `Figure 2`.
    pub name: String,
    /// What is seen in it, after the name.
    pub caption: Markup,
    /// The key: ink, how it is drawn, what it is.
    pub key: Vec<(Ink, Sample, String)>,
    /// Columns of panels, each from top to bottom.
    pub columns: Vec<Vec<Panel>>,
}

impl Figure {
    /// The figure as HTML.
    pub(super) fn markup(&self) -> Markup {
        html! {
            figure id=(self.id) {
                @if !self.key.is_empty() {
                    ul.key { @for (ink, sample, text) in &self.key { li { (swatch(*ink, *sample)) " " (text) } } }
                }
                div.panels { @for (column, panels) in self.columns.iter().enumerate() { div {
                    @for (row, panel) in panels.iter().enumerate() {
                        (panel.markup(&format!("{}-{column}{row}", self.id)))
                    }
                } } }
                figcaption { b { (self.name) "." } " " (self.caption) }
            }
        }
    }
}

/// A small drawing of an ink, to stand in a key. It says nothing that the word beside it does not.
fn swatch(ink: Ink, sample: Sample) -> Markup {
    let drawing = match sample {
        Sample::Line => Path::default().line([(10, 70), (290, 70)]).markup("l", ink.class()),
        Sample::Patch => Path::default().line([(10, 10), (290, 10), (290, 130), (10, 130)]).markup("a", ink.class()),
        Sample::Dot => markers([(150, 70)], ink, SPARSE),
    };
    html! { svg.swatch viewBox="0 0 300 140" aria-hidden="true" { (drawing) } }
}
