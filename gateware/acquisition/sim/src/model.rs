//! The verilated block: pins in, pins out. The only place that calls C++.

use core::ffi::c_void;
use core::ptr::NonNull;

/// How many clocks a microsecond of SCAN_PERIOD has, and how quickly the A/D is clocked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// As on the board: 24 clocks a microsecond, the A/D's SCK at 6 MHz, 84 clocks a conversion.
    Board,
    /// For long tests: 3 clocks a microsecond, the A/D's SCK at 12 MHz, 4 clocks a conversion.
    Fast,
}

impl Scale {
    /// Clocks in a microsecond of SCAN_PERIOD.
    #[must_use]
    pub const fn clocks_per_us(self) -> u64 {
        match self {
            Self::Board => 24,
            Self::Fast => 3,
        }
    }
}

/// The block's input pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // They are the pins of rtl/acquisition.sv, by their names.
pub struct Inputs {
    pub clk: bool,
    pub rst_n: bool,
    pub spi_sck: bool,
    pub spi_csn: bool,
    pub spi_mosi: bool,
    pub adc_sdo: bool,
}

impl Inputs {
    fn word(self) -> u32 {
        let pins = [self.clk, self.rst_n, self.spi_sck, self.spi_csn, self.spi_mosi, self.adc_sdo];
        pins.iter().enumerate().fold(0, |word, (place, &pin)| word | u32::from(pin) << place)
    }
}

/// The block's output pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // As above.
pub struct Outputs {
    pub spi_miso: bool,
    pub data_ready: bool,
    pub adc_cnv: bool,
    pub adc_sck: bool,
    pub adc_din: bool,
    pub scan_ready: bool,
}

const ASSERTION_FAILED: u32 = 1 << 31;

#[allow(unsafe_code)]
mod cpp {
    use core::ffi::c_void;

    // SAFETY: these are the signatures in cpp/model.cpp. `new` has no preconditions.
    unsafe extern "C" {
        pub safe fn board_new(seed: u32, assertions: bool) -> *mut c_void;
        pub unsafe fn board_delete(block: *mut c_void);
        pub unsafe fn board_eval(block: *mut c_void, pins: u32) -> u32;
        pub safe fn fast_new(seed: u32, assertions: bool) -> *mut c_void;
        pub unsafe fn fast_delete(block: *mut c_void);
        pub unsafe fn fast_eval(block: *mut c_void, pins: u32) -> u32;
    }
}

/// A block. What it has without reset starts with values drawn from the seed, as do its synchronisers.
#[derive(Debug)]
pub struct Model {
    scale: Scale,
    block: NonNull<c_void>,
}

impl Model {
    /// A block at power-up; it wants a reset. Its assertions can be turned off for a master that breaks the rules.
    ///
    /// # Panics
    /// When memory is out.
    #[must_use]
    pub fn new(scale: Scale, seed: u32, assertions: bool) -> Self {
        let block = match scale {
            Scale::Board => cpp::board_new(seed, assertions),
            Scale::Fast => cpp::fast_new(seed, assertions),
        };
        Self { scale, block: NonNull::new(block).expect("C++'s new does not return null") }
    }

    /// Puts the pins to these levels and lets the block settle.
    ///
    /// # Panics
    /// When an assertion of the RTL fails; Verilator has printed which.
    #[allow(unsafe_code)]
    pub fn eval(&mut self, inputs: Inputs) -> Outputs {
        let block = self.block.as_ptr();
        // SAFETY: `block` came from the `new` of the same scale and lives until `drop`; `&mut self` keeps others away.
        let word = unsafe {
            match self.scale {
                Scale::Board => cpp::board_eval(block, inputs.word()),
                Scale::Fast => cpp::fast_eval(block, inputs.word()),
            }
        };
        assert!(word & ASSERTION_FAILED == 0, "an assertion of the RTL failed, see what Verilator printed");
        let pin = |place: u32| word >> place & 1 == 1;
        Outputs {
            spi_miso: pin(0),
            data_ready: pin(1),
            adc_cnv: pin(2),
            adc_sck: pin(3),
            adc_din: pin(4),
            scan_ready: pin(5),
        }
    }
}

impl Drop for Model {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        let block = self.block.as_ptr();
        // SAFETY: as in `eval`, and nobody has `self` after this.
        unsafe {
            match self.scale {
                Scale::Board => cpp::board_delete(block),
                Scale::Fast => cpp::fast_delete(block),
            }
        }
    }
}
