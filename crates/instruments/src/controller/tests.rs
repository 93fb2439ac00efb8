use std::sync::{Arc, Mutex};

use super::*;

/// A controller that can be made to misbehave, in degrees of its own.
#[derive(Default)]
struct Fake {
    actual: f64,
    set_point: f64,
    /// Set points that it does not take.
    ignores: bool,
    sent: Vec<f64>,
    stopped: bool,
    is_gone: bool,
    /// It acknowledges a stop, and runs on.
    runs_on: bool,
}

struct Behind(Arc<Mutex<Fake>>);

impl Speech for Behind {
    fn actual(&mut self) -> Result<f64, Fault> {
        Ok(self.0.lock().unwrap().actual)
    }

    fn set_point(&mut self) -> Result<f64, Fault> {
        Ok(self.0.lock().unwrap().set_point)
    }

    fn send(&mut self, value: f64) -> Result<(), Fault> {
        let mut fake = self.0.lock().unwrap();
        if fake.is_gone {
            return Err(Fault::Silent { asked: "write".into(), heard: "nothing came" });
        }
        fake.sent.push(value);
        if !fake.ignores {
            // It keeps tenths.
            fake.set_point = (value * 10.0).round() / 10.0;
        }
        Ok(())
    }

    fn run(&mut self) -> Result<(), Fault> {
        self.0.lock().unwrap().stopped = false;
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Fault> {
        self.0.lock().unwrap().stopped = true;
        Ok(())
    }

    fn stopped(&mut self) -> Result<Option<bool>, Fault> {
        let fake = self.0.lock().unwrap();
        Ok(Some(fake.stopped && !fake.runs_on))
    }

    fn resolution(&self) -> f64 {
        0.1
    }

    fn identity(&mut self) -> Result<Option<String>, Fault> {
        Ok(None)
    }
}

fn controller(degrees: Degrees) -> (Controller, Arc<Mutex<Fake>>) {
    let fake = Arc::new(Mutex::new(Fake::default()));
    let speech = Box::new(Behind(Arc::clone(&fake)));
    let limits = [Celsius(-40.0), Celsius(80.0)];
    (Controller { speech, degrees, limits, safe: Celsius(25.0) }, fake)
}

#[test]
fn nothing_is_sent_that_is_outside_the_limits_or_no_number() {
    let (mut controller, fake) = controller(Degrees::C);
    for wrong in [-40.1, 80.1, f64::NAN, f64::INFINITY] {
        let told = controller.send(Celsius(wrong)).unwrap_err().to_string();
        assert!(told.contains("outside -40 to 80, chamber.limits_c of the set-up: nothing was sent"), "{told}");
    }
    assert!(fake.lock().unwrap().sent.is_empty());
    controller.send(Celsius(-40.0)).unwrap();
}

#[test]
fn a_set_point_that_is_not_taken_is_told_with_what_is_read_back() {
    let (mut controller, fake) = controller(Degrees::C);
    fake.lock().unwrap().ignores = true;
    fake.lock().unwrap().set_point = 23.0;
    let told = controller.send(Celsius(60.0)).unwrap_err().to_string();
    assert!(told.contains("60 was sent, and 23 is read back"), "{told}");
}

#[test]
fn tenths_of_a_controller_are_rounding_and_no_refusal() {
    let (mut controller, fake) = controller(Degrees::F);
    controller.send(Celsius(-17.77)).unwrap();
    assert!((fake.lock().unwrap().sent[0] - 0.014).abs() < 1e-9, "in Fahrenheit");
}

#[test]
fn what_no_sensor_gives_is_refused() {
    let (mut controller, fake) = controller(Degrees::C);
    for wrong in [f64::NAN, 3276.7, -3276.8, f64::INFINITY, 1e30] {
        fake.lock().unwrap().actual = wrong;
        let told = controller.actual().unwrap_err();
        assert!(!told.may_pass() && told.to_string().contains("the air's temperature reads"), "{told}");
    }
    fake.lock().unwrap().actual = -39.5;
    assert!((controller.actual().unwrap().0 + 39.5).abs() < 1e-9);
}

#[test]
fn at_rest_it_is_stopped_at_its_safe_set_point_and_stopped_though_that_is_not_taken() {
    let (mut controller, fake) = controller(Degrees::C);
    controller.rest().unwrap();
    assert!(fake.lock().unwrap().stopped && fake.lock().unwrap().sent == [25.0]);
    fake.lock().unwrap().stopped = false;
    fake.lock().unwrap().is_gone = true;
    assert!(controller.rest().is_err() && fake.lock().unwrap().stopped);
}

#[test]
fn a_controller_that_started_anew_is_told_by_its_set_point_or_that_it_stands() {
    let (mut controller, fake) = controller(Degrees::C);
    controller.send(Celsius(40.0)).unwrap();
    assert_eq!(controller.strayed_from(Celsius(40.0)).unwrap(), None);
    fake.lock().unwrap().stopped = true;
    assert_eq!(controller.strayed_from(Celsius(40.0)).unwrap().unwrap(), "stopped");
    fake.lock().unwrap().set_point = 25.0;
    assert_eq!(controller.strayed_from(Celsius(40.0)).unwrap().unwrap(), "set to 25.0 C");
}

#[test]
fn one_that_acknowledges_a_stop_and_runs_on_is_not_at_rest() {
    let (mut controller, fake) = controller(Degrees::C);
    fake.lock().unwrap().runs_on = true;
    assert!(matches!(controller.rest(), Err(Fault::RunsOn)));
}
