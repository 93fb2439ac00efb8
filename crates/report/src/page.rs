//! The page around a report: one file, nothing loaded from anywhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use zerorate_cal::calibration::Origin;
use zerorate_cal::quality::Verdict;

/// The style sheet.
const STYLE: &str = include_str!("style.css");

/// A chapter of a page: its id, its heading, what is in it.
pub(super) type Chapter = (&'static str, &'static str, Markup);

/// A whole page: a headline, links to the chapters, the chapters. The browser's own title bar shows `title`.
pub(super) fn page(title: &str, headline: &Markup, chapters: &[Chapter]) -> String {
    page_with_script(title, headline, chapters, "")
}

/// A whole page with a script of its own in it, without which everything can be read all the same.
pub(super) fn page_with_script(title: &str, headline: &Markup, chapters: &[Chapter], script: &'static str) -> String {
    let body = html! {
        header {
            (headline)
            nav aria-label="Contents" {
                ul { @for (id, heading, _) in chapters { li { a href={ "#" (id) } { (heading) } } } }
            }
        }
        main { @for (id, heading, chapter) in chapters { section id=(id) { h2 { (heading) } (chapter) } } }
        @if !script.is_empty() { script { (PreEscaped(script)) } }
    };
    document(title, "", &body)
}

/// A file with nothing around its contents; `style` comes after the style of all pages.
pub(super) fn document(title: &str, style: &'static str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="generator" content={ "zerorate " (env!("CARGO_PKG_VERSION")) };
                // An empty icon: without one, a browser asks the server for it.
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(style)) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// A sentence in which a parameter or a command is named between backticks.
pub(super) fn told(sentence: &str) -> Markup {
    let Some((before, rest)) = sentence.split_once('`') else { return html! { (sentence) } };
    match rest.split_once('`') {
        // A name has a mark on both sides, and no space beside them.
        Some((name, after)) if !name.is_empty() && name.trim() == name => {
            html! { (before) code { (name) } (told(after)) }
        }
        _ => html! { (before) "`" (told(rest)) },
    }
}

/// Words, each with what it means.
pub(super) fn terms(terms: &[(&str, Markup)]) -> Markup {
    html! { dl.terms { @for (term, meaning) in terms { dt { (term) } dd { (meaning) } } } }
}

/// What a page is made of, with its SHA-256, so that it can be told from another of the same name.
pub(super) fn sources(created_by: &str, sources: &[Origin]) -> Markup {
    html! {
        p { "Made by " (created_by) "," }
        ul { @for Origin { file, sha256, .. } in sources { li { "of " (file) ", SHA-256 " code { (sha256) } } } }
    }
}

/// Facts, each a term and what holds of it.
pub(super) fn facts(facts: &[(&str, Markup)]) -> Markup {
    html! { dl.facts { @for (term, fact) in facts { div { dt { (term) } dd { (fact) } } } } }
}

/// The verdict as a word with a sign, so that it does not rest on colour.
pub(super) fn verdict(verdict: Verdict) -> Markup {
    let (class, sign, word) = match verdict {
        Verdict::Good => ("good", "✓", "Good"),
        Verdict::Warning => ("warning", "!", "Warning"),
        Verdict::Rejected => ("rejected", "✕", "Rejected"),
    };
    html! { span.verdict.(class) { span.sign aria-hidden="true" { (sign) } " " (word) } }
}

/// A table in a box of its own, which scrolls sideways where the page is too narrow.
pub(super) struct Table<'a> {
    /// What it lists.
    pub caption: Markup,
    /// The heads of the columns.
    pub heads: &'a [&'a str],
    /// The rows; the first cell of each is its head.
    pub rows: Vec<Vec<Markup>>,
    /// Columns from this one on hold numbers, set to the right.
    pub numbers_from: usize,
}

impl Table<'_> {
    /// The table as HTML. Its caption stays where it is when the box scrolls, and the box can be reached by keyboard, for
    /// those who scroll with it.
    pub(super) fn markup(&self) -> Markup {
        self.as_lists_on_a_phone(false)
    }

    /// The same for one too wide for a phone: there its rows stand as lists, each cell with the head of its column.
    pub(super) fn wide_markup(&self) -> Markup {
        self.as_lists_on_a_phone(true)
    }

    fn as_lists_on_a_phone(&self, lists: bool) -> Markup {
        let class = |column: usize| if column >= self.numbers_from { "n" } else { "" };
        html! {
            figure.table {
                figcaption { (self.caption) }
                div.scroll tabindex="0" { table.lists[lists] {
                    thead { tr { @for (column, head) in self.heads.iter().enumerate() {
                        th scope="col" class=(class(column)) { (head) }
                    } } }
                    tbody { @for row in &self.rows { tr { @for (column, cell) in row.iter().enumerate() {
                        @if column == 0 { th scope="row" { (cell) } } @else {
                            td class=(class(column)) data-head=[lists.then_some(self.heads[column])] { (cell) }
                        }
                    } } } }
                } }
            }
        }
    }
}
