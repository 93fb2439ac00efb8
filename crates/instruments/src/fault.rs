//! Why an instrument did not do as it was told.

/// Why an instrument did not do as it was told.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The line cannot be opened or is gone.
    #[error("{0}: check the instrument's power, cable and address")]
    Line(#[source] std::io::Error),
    /// Nothing came that can be read.
    #[error(
        "no answer to {asked}: {heard}: check the instrument's power, cable, address and, on a serial line, its rate"
    )]
    Silent {
        /// What was asked, as "read register 1".
        asked: String,
        /// What came instead.
        heard: &'static str,
    },
    /// Another unit answers.
    #[error(
        "unit {asked} was asked and unit {answered} answers: give each controller on the line a number of its own, and put it into chamber.controller.unit"
    )]
    OtherUnit {
        /// The unit that was asked.
        asked: u8,
        /// The unit that answered.
        answered: u8,
    },
    /// The controller refuses.
    #[error("the controller refuses to {asked}: {}. {}", exception(*code), remedy(*code))]
    Refused {
        /// What was asked.
        asked: String,
        /// The exception's code (Modbus Application Protocol V1.1b3, chapter 7).
        code: u8,
    },
    /// An SCPI instrument's error queue is not empty.
    #[error("the instrument refuses `{command}`: {error}")]
    Scpi {
        /// What it was told.
        command: String,
        /// Its own words.
        error: String,
    },
    /// An answer that is none to the question.
    #[error("the answer to `{asked}` is '{answer}', which is none: is this the right instrument?")]
    OtherAnswer {
        /// What was asked.
        asked: String,
        /// What came.
        answer: String,
    },
    /// A reading that no sensor gives.
    #[error(
        "{what} reads {raw}, which is no temperature of a chamber: the sensor is broken or not connected, or form, scale or word_order in chamber.controller are another controller's"
    )]
    NoTemperature {
        /// Which value.
        what: &'static str,
        /// What it reads.
        raw: String,
    },
    /// A value that must not be sent.
    #[error("{what} {} is outside {least} to {most}, {limit} of the set-up: nothing was sent", short(*value))]
    OutsideLimits {
        /// What was to be sent, with its unit.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The least that may be sent.
        least: f64,
        /// The most.
        most: f64,
        /// The field of the set-up that says so.
        limit: &'static str,
    },
    /// What was sent is not what is read back.
    #[error(
        "{what} {} was sent, and {} is read back: the instrument does not take it. Look at its own limits, its lock, and whether a programme runs on it",
        short(*sent),
        short(*read_back)
    )]
    NotTaken {
        /// What was sent, with its unit.
        what: &'static str,
        /// What was sent.
        sent: f64,
        /// What is read back.
        read_back: f64,
    },
    /// A controller that was stopped says that it runs.
    #[error("it was stopped, and says that it runs on: see whether a programme runs on it, and its lock")]
    RunsOn,
    /// A supply has not held what it fed.
    #[error(
        "the supply fed {volts:.4} V and gives {given:.4} V now: what was measured meanwhile is not of it. See whether it has started anew or limits its current"
    )]
    NotHeld {
        /// What it fed, volts.
        volts: f64,
        /// What it gives, volts.
        given: f64,
    },
    /// A supply limits its current.
    #[error(
        "the supply is in current limit: set to {volts:.4} V it gives {given:.4} V and {amperes:.4} A, its limit: look for a short circuit, or raise the limit"
    )]
    CurrentLimit {
        /// What it was set to, volts.
        volts: f64,
        /// What it gives, volts.
        given: f64,
        /// Its current, amperes.
        amperes: f64,
    },
}

impl Fault {
    /// Whether it may answer later: the line is cut, or the instrument starts anew or is busy.
    #[must_use]
    pub const fn may_pass(&self) -> bool {
        match self {
            Self::Line(_) | Self::Silent { .. } => true,
            Self::Refused { code, .. } => is_busy(*code),
            _ => false,
        }
    }
}

/// A number to the ten-thousandth: no instrument here shows more.
fn short(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// Whether an exception's code says that it does something else just now, or that a gateway does not reach it.
const fn is_busy(code: u8) -> bool {
    matches!(code, 5 | 6 | 10 | 11)
}

/// What is to be done about it.
const fn remedy(code: u8) -> &'static str {
    match code {
        _ if is_busy(code) => "See whether a programme runs on it, somebody is in its menus, or its gateway is cut off",
        4 | 8 => "Look at its display, which says what has failed, and at its manual",
        _ => "Check the registers in chamber.controller, and that the controller may be set from outside",
    }
}

/// What an exception's code says.
const fn exception(code: u8) -> &'static str {
    match code {
        1 => "it does not know the function (exception 1)",
        2 => "it has no such register (exception 2)",
        3 => "it does not take the value (exception 3)",
        4 => "it has failed (exception 4)",
        5 => "it is still busy with it (exception 5)",
        6 => "it is busy (exception 6)",
        8 => "its memory is damaged (exception 8)",
        10 | 11 => "the gateway does not reach it (exception 10 or 11)",
        _ => "it gives a code of its own",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Modbus Application Protocol V1.1b3, chapter 7: 5 acknowledge, 6 device busy, 10 and 11 of gateways.
    #[test]
    fn a_controller_that_is_busy_may_answer_later_and_one_without_the_register_does_not() {
        let refused = |code| Fault::Refused { asked: "write register 2782".to_owned(), code };
        for code in [5, 6, 10, 11] {
            assert!(refused(code).may_pass() && !refused(code).to_string().contains("Check the registers"), "{code}");
        }
        for code in [1, 2, 3, 99] {
            assert!(!refused(code).may_pass() && refused(code).to_string().contains("Check the registers"), "{code}");
        }
        for code in [4, 8] {
            assert!(!refused(code).may_pass() && refused(code).to_string().contains("Look at its display"), "{code}");
        }
    }
}
