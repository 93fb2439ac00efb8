//! The reports as their reader gets them.

mod sample;

use zerorate_cal::calibration::Origin;
use zerorate_cal::log_fit::{AxisVerdict, LogFit};
use zerorate_cal::quality::{Reason, ReasonKind, Verdict};
use zerorate_cal::units::WrittenRate;
use zerorate_fit::predict::DriftModel;
use zerorate_fit::trend::{Against, Trend};
use zerorate_report::{LogPage, board_page};

/// A page may not be larger than this: it goes by mail.
const MOST_BYTES: usize = 1_500_000;

fn pages() -> [String; 4] {
    let (lot, small) = (sample::lot(204, 0.37), sample::lot(1, 0.0));
    [board_page(&sample::board_run(), None), log_page(&sample::log()), lot.to_html(), small.to_html()]
}

fn log_page(fit: &LogFit) -> String {
    log_page_in(fit, None)
}

/// The page with its rates in a unit.
fn log_page_in(fit: &LogFit, units: Option<WrittenRate>) -> String {
    let labels = [("operator".to_owned(), "A. N.".to_owned())].into();
    let (serial, next_command) = (Some("ZR-0007"), Some("zerorate apply"));
    LogPage { fit, units, serial, labels: &labels, sources: &[], chamber: None, next_command, export_command: None }
        .to_html()
}

/// The texts between `start` and `end`, in order.
fn between<'a>(page: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    page.split(start).skip(1).filter_map(|rest| rest.split(end).next()).collect()
}

#[test]
fn equal_reports_make_equal_bytes() {
    assert_eq!(pages(), pages());
}

#[test]
fn nothing_is_loaded_from_anywhere() {
    for page in pages() {
        for loader in ["http:", "https:", "src=", "@import", "url(", "fetch(", "import(", "XMLHttp", "xlink"] {
            assert!(!page.contains(loader), "{loader}");
        }
        // The icon is empty and in the page.
        assert_eq!(between(&page, "<link ", ">"), [r#"rel="icon" href="data:,""#]);
    }
}

#[test]
fn only_a_logs_page_has_a_script_and_what_it_copies_is_in_the_page() {
    let [calibration, log, ..] = pages();
    assert!(!calibration.contains("<script"));
    assert_eq!(log.matches("<script>").count(), 1);
    let ids = between(&log, " id=\"", "\"");
    let copied = between(&log, "data-copies=\"", "\"");
    assert!(copied.len() >= 4 && copied.iter().all(|id| ids.contains(id)), "{copied:?}");
}

#[test]
fn pages_are_small_enough_for_a_mail() {
    for page in pages() {
        assert!(page.len() < MOST_BYTES, "{}", page.len());
    }
}

#[test]
fn every_id_is_there_once_and_every_link_has_its_place() {
    for page in pages() {
        let ids = between(&page, " id=\"", "\"");
        for (place, id) in ids.iter().enumerate() {
            assert!(!ids[..place].contains(id), "{id} twice");
        }
        for link in between(&page, "href=\"#", "\"") {
            assert!(ids.contains(&link), "#{link}");
        }
        for labels in between(&page, "aria-labelledby=\"", "\"") {
            assert!(labels.split(' ').all(|label| ids.contains(&label)), "{labels}");
        }
    }
}

#[test]
fn headings_go_down_one_level_at_a_time() {
    for page in pages() {
        let levels: Vec<u32> =
            between(&page, "<h", ">").iter().filter_map(|level| level.chars().next()?.to_digit(10)).collect();
        assert_eq!((levels[0], levels.iter().filter(|level| **level == 1).count()), (1, 1));
        assert!(levels.windows(2).all(|pair| pair[1] <= pair[0] + 1), "{levels:?}");
    }
}

#[test]
fn a_calibration_shows_the_papers_figures_and_corrects_its_erratum_aloud() {
    let page = board_page(&sample::board_run(), None);
    for figure in ["Figure 2.", "Figure 3.", "Figure 4.", "Figure 6a.", "Figure 6d."] {
        assert!(page.contains(figure), "{figure}");
    }
    assert!(page.contains("See erratum") && page.contains("As printed: + 0.676531"));
    assert!(page.contains("1 of 4 checks"));
}

#[test]
fn a_board_run_shows_when_it_was_begun_and_every_recording_that_it_left() {
    let files = ["full-temperature", "trim-sweep", "compensation-test-trim", "compensation-test-hybrid", "soaks"];
    let mut run = sample::board_run();
    assert!(!board_page(&run, None).contains("begun"), "a simulated run has no date");
    run.full_temperature.info.started = Some("2026-03-01T08:05:59Z".parse().unwrap());
    run.full_temperature.info.firmware = "0.1.0".to_owned();
    let first = run.summary.recordings[0].clone();
    run.summary.recordings = files
        .map(|file| Origin { file: format!("{file}.parquet"), sha256: format!("hash of {file}"), ..first.clone() })
        .into();
    let page = board_page(&run, None);
    assert!(page.contains(", firmware 0.1.0, begun 2026-03-01 08:05 UTC</p>"), "on the first screen");
    for file in files {
        assert!(page.contains(&format!("of {file}.parquet, SHA-256 <code>hash of {file}</code>")), "{file}");
    }
}

#[test]
fn every_word_from_outside_is_escaped() {
    let mut run = sample::board_run();
    run.summary.serial = "<b>&\"".into();
    run.summary.warnings.push("<i>".into());
    let page = board_page(&run, None);
    assert!(!page.contains("<b>&\"") && !page.contains("<i><"));
    let mut log = sample::log();
    log.axes[0].name = "<q>".into();
    log.notes.push("`<u>`".into());
    assert!(!log_page(&log).contains("<q>") && !log_page(&log).contains("<u>"));
}

#[test]
fn a_rejected_log_has_reasons_and_advice_and_no_empty_chapters() {
    let mut log = sample::log();
    log.judgement.verdict = Verdict::Rejected;
    log.axes.clear();
    log.excluded.clear();
    let page = log_page(&log);
    assert!(page.contains("No calibration comes of this log") && page.contains("How to get a better log"));
    assert!(!page.contains("Coefficients to copy") && !page.contains("What was excluded"));
}

#[test]
fn a_parameter_is_shown_as_code_and_no_option_of_a_command_is_named() {
    let mut log = sample::log();
    log.judgement.add(Reason::new(ReasonKind::StuckTemperature, "a lone ` and a name: `rate_unit` says it"));
    let page = log_page(&log);
    assert!(page.contains("a lone ` and a name: <code>rate_unit</code> says it"), "{page}");
    assert!(page.contains("name another with <code>temperature</code>."));
    let words = page.split("</style>").nth(1).unwrap();
    assert!(!words.contains(" --"), "{}", words.split(" --").nth(1).unwrap());
}

#[test]
fn a_log_without_time_is_drawn_in_its_order() {
    let mut log = sample::log();
    for axis in &mut log.axes {
        axis.trace.iter_mut().for_each(|point| point.time_s = f64::NAN);
    }
    let page = log_page(&log);
    assert!(page.contains("place in the log, points"));
    let words = page.split("</style>").nth(1).unwrap();
    assert!(!words.contains("NaN"));
}

#[test]
fn a_calibration_without_tests_soaks_and_checks_is_a_page_all_the_same() {
    let mut run = sample::board_run();
    run.summary.tests.clear();
    run.summary.soaks = None;
    run.summary.checks.clear();
    run.calibration.axes.values_mut().flat_map(|axis| &mut axis.trim).for_each(|trim| trim.trim.measured = None);
    let page = board_page(&run, None);
    assert!(page.contains("no compensation test was run") && page.contains("Nothing was checked against a limit"));
}

#[test]
fn the_page_of_a_log_has_its_models_what_was_excluded_and_coefficients_to_copy() {
    let page = log_page(&sample::log());
    for part in ["gyro_x_rad_s", "The choice of the model", "the unit was moved", "Coefficients to copy", "INS_TCAL1"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.contains(r#"class="a excluded""#), "the interval is shaded");
}

#[test]
fn the_static_cubic_of_a_model_with_a_history_is_called_so_and_says_what_it_costs() {
    let mut log = sample::log();
    let page = log_page(&log);
    let copied = between(&page, "<code id=\"coefficients-1\">", "</code>")[0];
    let axis = &log.axes[0].calibration.fit;
    let (chosen, cubic) = (axis.chosen_model(), axis.static_cubic.as_ref().unwrap());
    assert!(axis.model.history.is_some() && chosen.contains(" + "), "{chosen}");
    let beside = format!("# gyro_x_rad_s, poly:3, the static cubic beside {chosen}\n# this cubic leaves ");
    assert!(copied.starts_with(&beside), "{copied}");
    for left in [cubic.deployed, axis.statistics.deployed] {
        // In mrad/s, as the screen and the tables tell it.
        let told = |word: &str| {
            word.trim_matches(['(', ')', ';'])
                .parse::<f64>()
                .is_ok_and(|it| (it / 1e3 / left.unwrap().rms - 1.0).abs() < 6e-4)
        };
        assert!(copied.split_whitespace().any(told), "{copied}");
    }
    // A curve that is a cubic is its own.
    let fit = &mut log.axes[0].calibration.fit;
    fit.model = DriftModel::of_curve(fit.static_cubic.as_ref().unwrap().drift.clone());
    assert!(!log_page(&log).contains("gyro_x_rad_s, poly:3, the static"));
}

#[test]
fn a_lot_names_the_units_outside_its_limits_the_furthest_first_and_draws_the_limits() {
    let page = sample::lot(204, 0.37).to_html();
    let section = between(&page, "<section id=\"outside\">", "</section>")[0];
    let serials = between(section, "<th scope=\"row\">", "</th>");
    assert!(serials.iter().any(|serial| serial.contains("ZR-2026-0009")), "{serials:?}");
    let parts = between(section, "<td class=\"n\" data-head=", "</td>");
    let percent = |cell: &&str| cell.rsplit('>').next()?.strip_suffix("\u{a0}%")?.parse::<f64>().ok();
    let far = parts.iter().filter_map(percent).collect::<Vec<_>>();
    assert!(far.len() == serials.len() && far.is_sorted_by(|a, b| a >= b), "{far:?}");
    for label in ["at most 1500", "at most 5", "at least 8050", "at most 8350"] {
        assert!(page.contains(&format!(">{label}</text>")), "{label}");
    }
    // Those of the list, each once.
    let units: std::collections::BTreeSet<&&str> = serials.iter().collect();
    assert!(page.contains(&format!(", {} are outside the limits", units.len())), "{units:?}");
    // It would leave no room for the units.
    assert!(page.contains("in-sample residual, rms at most 400"));
    assert!(page.contains("<td class=\"n\">0.5</td><td class=\"n\">400</td>"));
}

#[test]
fn a_lot_says_once_what_many_of_its_units_share() {
    let mut lot = sample::lot(204, 0.37);
    let notes = lot.undrawn_notes();
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(
        notes[0].starts_with("9 of the worst units (ZR-2026-0001, ZR-2026-0002")
            && notes[0].contains(" /lot/… not found")
    );
    lot.undrawn.truncate(1);
    assert_eq!(lot.undrawn_notes(), lot.undrawn);
}

#[test]
fn a_lot_tells_what_was_skipped_and_says_once_what_several_units_are_warned_of() {
    let mut lot = sample::lot(204, 0.37);
    let page = lot.to_html();
    let section = |page: &str, id: &str| between(page, &format!("<section id=\"{id}\">"), "</section>")[0].to_owned();
    assert!(
        section(&page, "skipped").contains("notes.txt") && page.contains("1 file was skipped. 2 recordings of other")
    );
    // Units 3, 43, 83, 123, 163 and 203; none of them is one of the rejected.
    let warnings = section(&page, "warnings");
    assert_eq!(warnings.matches("the temperature only rises").count(), 1);
    assert!(warnings.contains("ZR-2026-0003, ZR-2026-0043, ZR-2026-0083 and 3 more") && warnings.contains(">6</td>"));
    assert!(page.contains("6 have warnings") && lot.warned() == 6);
    lot.units[3].rejected = vec!["the run ended before its ramp did".into()];
    assert!(lot.warned() == 5 && section(&lot.to_html(), "warnings").contains(">6</td>"));
    lot.beside = None;
    let untold = lot.to_html();
    assert!(untold.contains("Which files were skipped is not told") && !untold.contains("id=\"skipped\""));
}

#[test]
fn a_small_lot_is_not_drawn_as_if_it_were_a_large_one() {
    let one = sample::lot(1, 0.0).to_html();
    assert!(one.contains("Lot of 1 unit<") && !one.contains("1 units"));
    assert!(one.contains("no two have times that differ") && !one.contains("time-figure"));
    let three = sample::lot(3, 0.05).to_html();
    // The key shows what is drawn: points, and lines where there is a median.
    let key = |page: &str| {
        let figure = between(page, "<figure id=\"time-figure\">", "</ul>")[0].to_owned();
        between(&figure, "<svg class=\"swatch\"", "</svg>")[0].to_owned()
    };
    assert!(key(&three).contains("class=\"d big x\""), "{}", key(&three));
    assert!(key(&sample::lot(204, 0.37).to_html()).contains("class=\"l x\""));
    assert!(three.contains("hours since the first unit") && three.contains("With fewer than 20 units"));
    let mut none = sample::lot(1, 0.0);
    none.units[0].axes.clear();
    none.units[0].rejected = vec!["the run ended before its ramp did".into()];
    none.worst.clear();
    let none = none.to_html();
    assert!(
        none.contains("there is nothing to draw") && !none.contains("role=\"img\"") && none.contains("1 was rejected")
    );
}

#[test]
fn a_logs_page_tells_every_rate_in_the_unit_asked_for_and_its_figures_too() {
    let page = log_page_in(&sample::log(), Some(WrittenRate::DegPerHour));
    let words = page.split("</style>").nth(1).unwrap();
    assert!(words.contains("rate, deg/h") && words.contains("Allan deviation, deg/h"));
    // The coefficients to copy are those of the calibration, and say so.
    let told = words.find("mrad/s").map(|at| &words[at.saturating_sub(300)..at + 8]);
    assert!(told.is_none() && words.contains("gyro_x_rad_s, rad/s</h3>"), "{told:?}");
}

#[test]
fn what_a_device_has_left_of_each_axis_stands_with_its_error_before_the_figures() {
    let log = sample::log();
    let page = log_page(&log);
    let first = page.split("<section").next().unwrap();
    let before = first.find("A. N.").unwrap();
    assert!(first[..before].contains("ZR-0007") && first.contains("Deployed, rms"));
    for axis in &log.axes {
        let deployed = axis.calibration.fit.statistics.deployed.unwrap();
        let error = 1e3 * deployed.rms_standard_error.unwrap();
        let cell = format!("{:.4}\u{a0}±\u{a0}{error:.4}", 1e3 * deployed.rms);
        assert!(first.contains(&cell[..4]), "{cell} of {}", axis.name);
        assert!(first.matches('±').count() >= 3);
    }
}

#[test]
fn what_speaks_against_a_log_and_its_rejected_axes_stand_before_any_number() {
    let mut log = sample::log();
    let mut judgement = log.verdicts[0].judgement.clone();
    judgement.verdict = Verdict::Rejected;
    log.verdicts.push(AxisVerdict { name: "gyro_w".into(), judgement });
    let page = log_page(&log);
    let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}"));
    let good = at("Deployed, rms");
    assert!(at("Rejected, and not in the calibration: gyro_w.") < good && at("the unit was moved") < good);
}

#[test]
fn a_trend_that_is_left_is_named() {
    let mut log = sample::log();
    log.axes[1].calibration.fit.statistics.trends =
        vec![Trend { against: Against::Time, change: 4e-4, standard_error: 3e-5 }];
    let first = log_page(&log);
    let told = "gyro_y_rad_s: what the model leaves still rises by 0.400 ± 0.030 mrad/s from the log&#39;s start";
    let told = told.replace("&#39;", "'");
    assert!(first.split("<section").next().unwrap().contains(&told));
}

#[test]
fn degrees_stand_beside_counts_where_the_set_up_knows_them() {
    let mut run = sample::board_run();
    let page = board_page(&run, None);
    // 8500 counts are -40 °C and 11 900 are 60 °C by the paper's 34 counts a degree.
    assert!(
        page.contains("8500 counts (\u{2212}40.0\u{a0}°C) to") && page.contains(">60\u{a0}°C</text>"),
        "{page:.3000}"
    );
    run.calibration.setup = None;
    let page = board_page(&run, None);
    assert!(page.contains("from 8500 counts to") && !page.contains("°C</text>"));
}

#[test]
fn a_rejected_unit_says_why_before_what_it_does_well_and_by_whom_it_was_made() {
    let page = board_page(&sample::board_run(), None);
    let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}"));
    assert!(at("checks failed") < at("Over one heating ramp") && at("checks failed") < at("What a deployed device"));
    assert!(at("A. N.") < at("<section") && at("SHA-256 <code>") > at("How to read the numbers</h2>"));
}
