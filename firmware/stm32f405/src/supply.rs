//! The processor's supply: why the chip was reset, the level at which it is held in reset, and dips above that level.
//!
//! ```text
//! 3.3 V      nominal; 3.13 V at -5 %
//! 2.93 V     PVD level 6, falling (2.85 to 2.99, rising 2.96 to 3.10): a dip is counted
//! 2.83 V     BOR level 3, falling (2.75 to 2.88): the chip is held in reset
//! 2.7 V      flash is written 32 bits at a time down to here
//! 1.8 V      the chip works down to here, and without BOR would go on to it
//! ```
//! (Data sheet, tables 14, 19 and 46.) Level 3 is the one above what writing to flash takes, and below any 3.3 V supply.

use stm32f4xx_hal::pac::{EXTI, FLASH, PWR, RCC};
use zerorate_device::restart::Reset;

/// PVD level 6.
const PVD_LEVEL: u8 = 6;
/// BOR level 3 in the option bytes, where 3 is off (RM0090 rev 19, 3.9.10). The HAL's names for the bits are the other way
/// round.
const BOR_LEVEL_3: u8 = 0;
/// What unlocks the option bytes, one after the other (RM0090 rev 19, 3.6.2).
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

/// Why the chip was reset. The flags add up until they are cleared; power sets the brown-out's, too, and the pin goes low with
/// every reset: so what tells more is asked for first (RM0090 rev 19, 7.3.21).
pub fn reset(rcc: &RCC) -> Reset {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    if flags.porrstf().bit_is_set() {
        Reset::Power
    } else if flags.borrstf().bit_is_set() {
        Reset::BrownOut
    } else if flags.wdgrstf().bit_is_set() {
        Reset::Watchdog
    } else if flags.sftrstf().bit_is_set() {
        Reset::Software
    } else {
        Reset::Pin
    }
}

/// Has dips of the supply interrupt, by the line of EXTI that is the PVD's.
pub fn watch(power: &PWR, exti: &EXTI) {
    #[allow(unsafe_code)]
    // SAFETY: every pattern of the three bits is a level.
    power.cr().modify(|_, w| unsafe { w.pls().bits(PVD_LEVEL).pvde().set_bit() });
    // The output rises as the supply falls.
    exti.rtsr().modify(|_, w| w.tr16().set_bit());
    exti.imr().modify(|_, w| w.mr16().set_bit());
}

/// The dip that has interrupted is taken note of.
pub fn clear(exti: &EXTI) {
    exti.pr().write(|w| w.pr16().clear_bit_by_one());
}

/// Sets the option bytes' BOR level where it is another: option bytes wear, and a chip comes with BOR off. Not from a supply
/// that may still be rising: the next start will.
pub fn hold_in_reset_when_low(flash: &FLASH, power: &PWR) {
    let options = flash.optcr();
    if options.read().bor_lev().bits() == BOR_LEVEL_3 || power.csr().read().pvdo().bit_is_set() {
        return;
    }
    for key in OPTION_KEYS {
        #[allow(unsafe_code)]
        // SAFETY: the register takes any word.
        flash.optkeyr().write(|w| unsafe { w.optkeyr().bits(key) });
    }
    while flash.sr().read().bsy().bit_is_set() {}
    #[allow(unsafe_code)]
    // SAFETY: every pattern of the two bits is a level.
    options.modify(|_, w| unsafe { w.bor_lev().bits(BOR_LEVEL_3) });
    options.modify(|_, w| w.optstrt().set_bit());
    while flash.sr().read().bsy().bit_is_set() {}
    options.modify(|_, w| w.optlock().set_bit());
}
