use super::*;

const PERIOD: f64 = 1.5;

/// What is seen of a temperature over time, each with its time in seconds.
fn seen(
    mut see: impl FnMut(Seconds, Celsius) -> Seen,
    temperature: impl Fn(f64) -> f64,
    until_s: f64,
) -> Vec<(f64, Seen)> {
    let mut all = Vec::new();
    let mut noise = 1_u32;
    let mut t = 0.0;
    while t < until_s {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let c = temperature(t) + 0.01 * (f64::from(noise >> 16) / 32_768.0 - 1.0);
        match see(Seconds(t), Celsius(c)) {
            Seen::Nothing => {}
            Seen::Settled => {
                all.push((t, Seen::Settled));
                break;
            }
            other => all.push((t, other)),
        }
        t += PERIOD;
    }
    all
}

fn soak(temperature: impl Fn(f64) -> f64, until_s: f64) -> Vec<(f64, Seen)> {
    let mut watch = SoakWatch::new(Celsius(25.0), Celsius(-40.0), Seconds(3600.0), Seconds(PERIOD));
    seen(|t, c| watch.see(t, c), temperature, until_s)
}

fn ramp(temperature: impl Fn(f64) -> f64, until_s: f64) -> Vec<(f64, Seen)> {
    let mut watch = RampWatch::new(Celsius(-40.0), Celsius(60.0), Seconds(3600.0), Seconds(PERIOD));
    seen(|t, c| watch.see(t, c), temperature, until_s)
}

/// A lag behind a chamber that goes at 2.5 K a minute from `from` to `to`, after a person's `delay_s`.
fn chamber(from: f64, to: f64, delay_s: f64) -> impl Fn(f64) -> f64 {
    const LAG_S: f64 = 300.0;
    move |t| {
        let t = (t - delay_s).max(0.0);
        let rate = 2.5 / 60.0 * (to - from).signum();
        let arrives = (to - from) / rate;
        // The response of a first-order lag to a line, and to its end.
        let behind = |t: f64| rate * (t - LAG_S * (1.0 - (-t / LAG_S).exp()));
        from + behind(t) - if t > arrives { behind(t - arrives) } else { 0.0 }
    }
}

#[test]
fn a_soak_settles_an_hour_after_its_arrival_and_nothing_is_said() {
    let all = soak(chamber(25.0, -40.0, 120.0), 20_000.0);
    assert_eq!(all.len(), 1, "{all:?}");
    // 26 minutes' way, the lag, the window, the hour.
    assert!((5200.0..7500.0).contains(&all[0].0), "{all:?}");
}

#[test]
fn a_chamber_that_is_not_switched_on_is_asked_for_again_and_again() {
    let all = soak(|_| 25.0, 1300.0);
    assert_eq!(all.len(), 4, "{all:?}");
    assert!(matches!(&all[0].1, Seen::Warning(text) if text.contains("nothing has moved") && text.contains("-40 C")));
}

#[test]
fn a_chamber_sent_the_wrong_way_is_told_once() {
    let all = soak(chamber(25.0, 60.0, 0.0), 1500.0);
    assert!(matches!(&all[..], [(_, Seen::Warning(text))] if text.contains("wrong way")), "{all:?}");
}

/// The first reading of a run that goes on may be of a board that lags behind what the chamber shows.
#[test]
fn a_chamber_that_is_sent_where_it_was_need_not_move_whatever_the_readings_are_scaled_by() {
    let mut watch = SoakWatch::new(Celsius(10.0), Celsius(10.0), Seconds(60.0), Seconds(PERIOD));
    let all = seen(|t, c| watch.see(t, c), |_| 0.3, 20_000.0);
    assert!(all.len() == 1 && all[0].1 == Seen::Settled && all[0].0 < 300.0, "{all:?}");
}

#[test]
fn a_soak_that_settles_elsewhere_is_odd() {
    let mut watch = SoakWatch::new(Celsius(25.0), Celsius(-40.0), Seconds(60.0), Seconds(PERIOD));
    watch.see(Seconds(0.0), Celsius(25.0));
    assert_eq!(watch.oddity(Celsius(-37.0)), None);
    assert!(watch.oddity(Celsius(-20.0)).is_some_and(|text| text.contains("counts_per_celsius")));
}

#[test]
fn a_ramp_begins_when_the_reading_turns_though_the_soak_still_settles() {
    let rising = chamber(-40.0, 60.0, 600.0);
    let all = ramp(|t| rising(t) - 0.0005 * t.min(600.0), 9000.0);
    assert!(matches!(&all[0].1, Seen::Warning(text) if text.contains("no ramp")), "after five minutes: {all:?}");
    let begun = all.iter().find(|(_, seen)| *seen == Seen::Begun).unwrap().0;
    assert!((600.0..800.0).contains(&begun), "{all:?}");
    let (ended, last) = all.last().unwrap();
    assert_eq!(*last, Seen::Settled, "{all:?}");
    assert!((3000.0..6500.0).contains(ended), "{all:?}");
}

#[test]
fn a_ramp_too_fast_the_wrong_way_or_stuck_is_told() {
    let warned = |temperature: &dyn Fn(f64) -> f64, part: &str| {
        let all = ramp(temperature, 4000.0);
        let told = all.iter().filter(|(_, seen)| matches!(seen, Seen::Warning(text) if text.contains(part))).count();
        assert_eq!(told, 1, "{part}: {all:?}");
    };
    warned(&|t| -40.0 + 0.2 * t.min(480.0), "too fast");
    warned(&|t| -40.0 - 0.04 * t, "wrong way");
    warned(&|t| (-40.0 + 0.04 * t).min(0.0), "stands still");
}
