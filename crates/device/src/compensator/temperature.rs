//! Whether a group's temperature is to be believed.
//!
//! The law moves the wiper by the temperature alone, so a broken temperature reading would throw the tap. What is not
//! believed leaves tap and correction where the last believed temperature put them.

use zerorate_core::board::BoardNumbers;
use zerorate_core::group::GroupSums;
use zerorate_core::units::TemperatureCode;
use zerorate_core::wire::{FaultCounts, TemperatureCheck};

use crate::acquisition::Timing;

/// The fastest that a temperature moves, kelvins a second. The quickest real thing is the package behind air that jumps by
/// 100 K, 0.7 K/s by its time constant of 150 s; a chamber ramps at 2.5 K a minute.
const FASTEST_K_PER_S: u32 = 2;
/// What noise may add to it between two groups, in thirds of a sample's noise: 32 counts where that is 3. It is seven times the
/// rms difference of two groups of a single sample. Of the paper's 500 it is far more than enough.
const NOISE_THIRDS: u32 = 32;
/// Samples of a group scatter no more than this many times their noise. More is a glitch within the group.
const SCATTER_NOISES: u32 = 32;
/// Samples that scatter less than this part of their noise come of no sensor, but of a converter's last bit.
const STILL_PART: u32 = 4;
/// A jump that stays for so many groups is believed: the first is held, the second, and the third moves. At the paper's
/// rate that is 4.5 s, in which the fastest chamber moves 0.2 K: less than a hundredth of a tap, and nothing against a
/// thrown one.
const BELIEVED_AFTER: u8 = 3;
/// So many samples that stand still are stuck: two of the paper's groups. (A sensor quieter than a quarter of what its record
/// says may stand still by right; then holding its tap is the same as following it.)
const STUCK_SAMPLES: u32 = 1000;
/// A group's mean moves by so much with the last bit of a converter alone, counts.
const LAST_BIT_COUNTS: u32 = 1;
/// An axis does not stand while the other moves by so many kelvins, however its last bits move: both gyros stand on one board,
/// and the paper finds their temperatures alike.
const OTHER_MOVES_K: u32 = 3;
/// It has not moved: so many thousandths of a kelvin, a count of the paper's board. A count it may always move.
const STANDS_MK: u32 = 30;

/// Steps of 1/256.
const Q8: u32 = 8;

/// What there is to believe by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Believable {
    /// The converter, and the sensors' scale and noise.
    pub(super) board: BoardNumbers,
    /// How long a group takes.
    pub(super) timing: Timing,
    /// Groups that were missed before this one.
    pub(super) missed: u32,
}

impl Believable {
    /// How far a temperature moves at most from one group to the next, with those between them that were missed.
    fn furthest_codes(&self) -> u64 {
        let noise = (u64::from(self.board.temperature_noise_q8) * u64::from(NOISE_THIRDS) / 3) >> Q8;
        (noise + self.fastest_counts(u64::from(self.missed) + 1)) * u64::from(self.board.codes_per_count)
    }

    /// How far it moves in so many groups.
    fn fastest_counts(&self, groups: u64) -> u64 {
        let counts_per_s_q8 = u64::from(FASTEST_K_PER_S) * u64::from(self.board.counts_per_kelvin_q8);
        (groups.saturating_mul(self.timing.period_us()).saturating_mul(counts_per_s_q8) >> Q8) / 1_000_000
    }

    /// How far samples of a group scatter at most, by their noise or by the fastest ramp, 1/256 count rms.
    fn scatter_q8(&self) -> u32 {
        // Evenly spread over what is passed they scatter by 0.29 of it.
        let ramp = u32::try_from(self.fastest_counts(1) << Q8).unwrap_or(u32::MAX) / 2;
        (SCATTER_NOISES * self.board.temperature_noise_q8).max(ramp)
    }

    /// Kelvins in codes.
    fn codes(&self, thousandths: u32) -> u64 {
        let counts_q8 = u64::from(self.board.counts_per_kelvin_q8) * u64::from(thousandths) / 1000;
        (counts_q8 * u64::from(self.board.codes_per_count)) >> Q8
    }

    /// A converter's last bit in codes.
    const fn last_bit(&self) -> u64 {
        LAST_BIT_COUNTS as u64 * self.board.codes_per_count as u64
    }
}

/// A temperature, and how far it has come there, codes from anywhere, without the jumps that no temperature makes.
#[derive(Debug, Clone, Copy)]
struct Place {
    code: TemperatureCode,
    travelled: i64,
}

/// What is known of one axis's temperature.
#[derive(Debug, Clone, Default)]
pub(super) struct TemperatureWatch {
    believed: Option<TemperatureCode>,
    /// What would be believed if there were no other axis.
    alone: Option<TemperatureCode>,
    /// The jumps among it that stayed, codes: an axis does not stand still because the other one has jumped.
    leaps: i64,
    /// A temperature that was jumped to, and for how many groups.
    jumped: Option<(TemperatureCode, u8)>,
    /// A temperature that does not move, and for how many samples.
    still: Option<(TemperatureCode, u32)>,
    /// Where the axis last moved from, and where the other was then.
    moved: Option<(TemperatureCode, Place)>,
}

/// What is to be thought of a temperature, and the code that the law is to take; `None` where none was believed yet.
pub(super) type Checked = (TemperatureCheck, Option<TemperatureCode>);

/// Looks at a group of both axes, X and Y.
///
/// ```text
/// this axis                         the other moves by 3 K                    not believed
/// stands, without a sensor's noise  as temperatures do                        this one
/// stands, with a sensor's noise     as temperatures do                        both: it cannot be told
/// stands                            faster than a temperature does, and stays the other, while that is a jump
/// ```
pub(super) fn check([x, y]: [&mut TemperatureWatch; 2], sums: &[GroupSums; 2], believable: Believable) -> [Checked; 2] {
    let own = [x.look(&sums[0], believable), y.look(&sums[1], believable)];
    let [of_x, of_y] = [x.place(), y.place()];
    let stands = [x.stands(own[0], of_y, believable), y.stands(own[1], of_x, believable)];
    [x.conclude(own[0], stands[0], stands[1]), y.conclude(own[1], stands[1], stands[0])]
}

/// What a group says by itself, with its temperature; `None` of an empty one.
type Own = Option<(TemperatureCheck, TemperatureCode)>;

impl TemperatureWatch {
    fn place(&self) -> Option<Place> {
        self.alone.map(|code| Place { code, travelled: i64::from(code.0) - self.leaps })
    }

    fn look(&mut self, sums: &GroupSums, believable: Believable) -> Own {
        let code = sums.temperature_code(believable.board.codes_per_count)?;
        let check = self.judge(code, sums, believable);
        match check {
            TemperatureCheck::Believed => {
                if let Some(alone) = self.alone
                    && distance(alone, code) > believable.furthest_codes()
                {
                    self.leaps += i64::from(code.0) - i64::from(alone.0);
                }
                (self.alone, self.jumped) = (Some(code), None);
            }
            TemperatureCheck::Jumped => {}
            TemperatureCheck::Stuck | TemperatureCheck::Saturated => self.jumped = None,
        }
        Some((check, code))
    }

    /// Whether it stands, by a sensor that is alive, while the other one moves.
    fn stands(&mut self, own: Own, other: Option<Place>, believable: Believable) -> bool {
        matches!((own, other), (Some((TemperatureCheck::Believed, code)), Some(other))
            if self.is_left_behind(code, other, believable))
    }

    fn conclude(&mut self, own: Own, stands: bool, other_stands: bool) -> Checked {
        let check = match own {
            Some((TemperatureCheck::Believed, _)) if stands => TemperatureCheck::Stuck,
            Some((TemperatureCheck::Believed, _)) if other_stands => TemperatureCheck::Jumped,
            Some((TemperatureCheck::Believed, code)) => {
                self.believed = Some(code);
                TemperatureCheck::Believed
            }
            Some((check, _)) => check,
            None => TemperatureCheck::Believed,
        };
        (check, self.believed)
    }

    fn judge(&mut self, code: TemperatureCode, sums: &GroupSums, believable: Believable) -> TemperatureCheck {
        if sums.is_temperature_saturated(believable.board.reach()) {
            return TemperatureCheck::Saturated;
        }
        if self.is_stuck(code, sums, believable) {
            return TemperatureCheck::Stuck;
        }
        if sums.temperature_scatters(believable.scatter_q8()) {
            return TemperatureCheck::Jumped;
        }
        let limit = believable.furthest_codes();
        let near = |other: TemperatureCode| distance(code, other) <= limit;
        if self.alone.is_none_or(near) {
            return TemperatureCheck::Believed;
        }
        let groups = match self.jumped {
            Some((other, groups)) if near(other) => groups + 1,
            _ => 1,
        };
        self.jumped = Some((code, groups));
        if groups < BELIEVED_AFTER { TemperatureCheck::Jumped } else { TemperatureCheck::Believed }
    }

    fn is_stuck(&mut self, code: TemperatureCode, sums: &GroupSums, believable: Believable) -> bool {
        let (since, samples) = match self.still {
            Some((still, samples)) if distance(still, code) <= believable.last_bit() => (still, samples),
            _ => (code, 0),
        };
        let is_still = !sums.temperature_scatters(believable.board.temperature_noise_q8 / STILL_PART);
        self.still = is_still.then(|| (since, samples.saturating_add(sums.n)));
        self.still.is_some_and(|(_, samples)| samples >= STUCK_SAMPLES)
    }

    /// Whether the axis stands still while the other moves.
    fn is_left_behind(&mut self, code: TemperatureCode, other: Place, believable: Believable) -> bool {
        let (own_then, other_then) = *self.moved.get_or_insert((code, other));
        // Two codes within one count of each other, and one more, are told apart by rounding alone.
        let stands = believable.codes(STANDS_MK).max(believable.last_bit()) + believable.last_bit();
        if distance(code, own_then) >= stands {
            self.moved = Some((code, other));
            return false;
        }
        // Neither a jump that stays is a movement, nor one that ends where it began.
        distance(other.code, other_then.code).min(other.travelled.abs_diff(other_then.travelled))
            >= believable.codes(1000 * OTHER_MOVES_K)
    }
}

fn distance(a: TemperatureCode, b: TemperatureCode) -> u64 {
    u64::from(a.0.abs_diff(b.0))
}

/// Counts what was thought of a temperature.
pub(super) const fn count(check: TemperatureCheck, faults: &mut FaultCounts) {
    let counter = match check {
        TemperatureCheck::Believed => return,
        TemperatureCheck::Stuck => &mut faults.temperature_stuck,
        TemperatureCheck::Jumped => &mut faults.temperature_jumped,
        TemperatureCheck::Saturated => &mut faults.temperature_saturated,
    };
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod tests;
