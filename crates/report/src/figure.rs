//! Figures: panels side by side with a key and a caption. A page shows two panels a row on a desktop and one on a phone,
//! so that one drawing serves both and its type stays legible.

mod ink;
mod panel;
mod scale;
mod svg;
mod thin;

use maud::{Markup, PreEscaped, html};

pub(super) use ink::Ink;
pub(super) use panel::{Mark, Panel, Side, holding};

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
                    ul.key {
                        @for (ink, sample, text) in &self.key { li { (swatch(*ink, *sample)) " " (text) } }
                    }
                }
                div.panels {
                    @for (column, panels) in self.columns.iter().enumerate() {
                        div {
                            @for (row, panel) in panels.iter().enumerate() {
                                (PreEscaped(panel.svg(&format!("{}-{column}{row}", self.id))))
                            }
                        }
                    }
                }
                figcaption { b { (self.name) "." } " " (self.caption) }
            }
        }
    }
}

/// A small drawing of an ink, to stand in a key. It says nothing that the word beside it does not.
fn swatch(ink: Ink, sample: Sample) -> Markup {
    let class = ink.class();
    let path = match (sample, ink.marker()) {
        (Sample::Line, _) => format!(r#"<path class="l {class}" d="m10 70h280"/>"#),
        (Sample::Patch, _) => format!(r#"<path class="a {class}" d="m10 10h280v120h-280z"/>"#),
        (Sample::Dot, ink::Marker::Dot) => format!(r#"<path class="d big {class}" d="m150 70h0"/>"#),
        (Sample::Dot, ink::Marker::Ring) => {
            format!(r#"<path class="m {class}" d="m111 70a39 39 0 1 0 78 0a39 39 0 1 0-78 0z"/>"#)
        }
        (Sample::Dot, ink::Marker::Triangle) => format!(r#"<path class="m {class}" d="m150 26l34 66h-68z"/>"#),
    };
    PreEscaped(format!(r#"<svg class="swatch" viewBox="0 0 300 140" aria-hidden="true">{path}</svg>"#))
}
