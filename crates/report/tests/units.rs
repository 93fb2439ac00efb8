//! The page of many units as its reader gets it.

use zerorate_cal::quality::Verdict;
use zerorate_report::{UnitAxis, UnitCalibration, UnitCalibrations, UnitsReport};

/// A unit that was calibrated so often, a month apart; its X curve changed by so many counts at the last.
fn unit(number: u32, times: u32, change: f64) -> UnitCalibrations {
    let calibration = |time: u32| {
        let change = (time > 0).then_some(if time + 1 == times { change } else { 0.1 });
        let x = UnitAxis { drift: 436.5, trim: Some(35.5), hybrid: Some(3.0), change };
        UnitCalibration {
            made: format!("2026-0{}-01 08:00", time + 1),
            day: Some(20_454.0 + 30.0 * f64::from(time)),
            verdict: Verdict::Good,
            axes: [Some(x), None],
        }
    };
    UnitCalibrations { serial: format!("ZR-{number:04}"), calibrations: (0..times).map(calibration).collect() }
}

fn page(units: Vec<UnitCalibrations>) -> String {
    UnitsReport { folder: "units".into(), units, unreadable: Vec::new() }.to_html()
}

#[test]
fn of_a_thousand_units_those_that_changed_most_are_drawn_and_the_others_are_counted() {
    let page = page((0..1000).map(|number| unit(number, 1 + number % 2, f64::from(number))).collect());
    assert!(
        page.contains("500 units were calibrated more than once") && page.contains("476 more are in the table alone")
    );
    assert_eq!(page.matches("<figure id=").count(), 24);
    let drawn: Vec<&str> =
        page.split("<figcaption><b>").skip(1).filter_map(|rest| rest.split(".</b>").next()).collect();
    assert_eq!((drawn[0], drawn[23]), ("ZR-0999", "ZR-0953"));
    assert_eq!(page.matches("<th scope=\"row\">").count(), 1500, "every calibration is in the table");
    assert!(page.len() < 1_500_000 && !page.contains("<script"), "{}", page.len());
}

#[test]
fn dates_are_days_since_the_first_calibration_and_without_them_calibrations_are_counted() {
    let dated = page(vec![unit(1, 3, 5.0)]);
    assert!(dated.contains("days since 2026-01-01, from") && dated.contains("changed by 5.0 counts at most"));
    let mut undated = unit(1, 3, 5.0);
    undated.calibrations[1].day = None;
    assert!(page(vec![undated]).contains("calibration, number"));
    assert!(page(vec![unit(1, 1, 0.0)]).contains("there is no trend to draw"));
}
