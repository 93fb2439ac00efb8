//! Sets a wiper from a Linux board, through spidev.
//!
//!     cargo run --example linux_board -- /dev/spidev0.0 1 511
//!
//! moves wiper 1 to tap 511. A fourth word, `store`, also makes it the position after power-up.

#[cfg(target_os = "linux")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    use linux_embedded_hal::spidev::{SpiModeFlags, SpidevOptions};
    use linux_embedded_hal::{Delay, SpidevDevice};
    use max5494::{Channel, Max5494, Position};

    let words: Vec<String> = std::env::args().skip(1).collect();
    let (path, channel, taps, store) = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [path, channel, taps] => (path, channel, taps, false),
        [path, channel, taps, "store"] => (path, channel, taps, true),
        _ => {
            return Err("usage: linux_board SPIDEV 1|2 TAP [store], for instance /dev/spidev0.0 1 511".into());
        }
    };
    let channel = match channel {
        "1" => Channel::One,
        "2" => Channel::Two,
        other => return Err(format!("channel {other}: the part has channels 1 and 2").into()),
    };
    let position = Position::new(taps.parse().map_err(|e| format!("tap {taps}: {e}"))?)
        .ok_or_else(|| format!("tap {taps}: the wiper has taps 0 to 1023"))?;

    let mut spi =
        SpidevDevice::open(path).map_err(|e| format!("{path}: {e} (is SPI on in the board's device tree?)"))?;
    // The part takes up to 7 MHz; 1 MHz forgives long wires.
    let options = SpidevOptions::new().bits_per_word(8).max_speed_hz(1_000_000).mode(SpiModeFlags::SPI_MODE_0).build();
    spi.0.configure(&options)?;

    let mut pot = Max5494::new(spi);
    pot.write_wiper(channel, position)?;
    if store {
        pot.copy_wiper_to_nv(channel, &mut Delay)?;
    }
    // Write-only: the driver cannot say that the wiper is there, only that the frame left.
    println!("sent: wiper to tap {}{}", position.get(), if store { ", stored for power-up" } else { "" });
    Ok(())
}

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("this example needs Linux's spidev");
}
