use super::*;

const MS: u64 = 1_000_000;

fn part() -> Potentiometer {
    Potentiometer::new(&PotentiometerParameters::default())
}

/// Sends the lowest `clocks` bits of `bits`, most significant first.
fn send(part: &mut Potentiometer, bits: u64, clocks: u32, now_ns: u64) {
    part.select();
    (0..clocks).rev().for_each(|place| part.clock(bits >> place & 1 == 1));
    part.deselect(now_ns);
}

fn tap(position: u16) -> Taps {
    Taps::new(position).unwrap()
}

#[test]
fn a_write_of_24_clocks_moves_one_wiper_and_neither_the_other_nor_the_memory() {
    let mut part = part();
    send(&mut part, 0x01 << 16 | 511 << 6, 24, 0);
    assert_eq!([part.wiper(Axis::X), part.wiper(Axis::Y)], [tap(511), tap(512)]);
    send(&mut part, 0x02 << 16 | 1023 << 6 | 0x3F, 24, 0);
    assert_eq!([part.wiper(Axis::X), part.wiper(Axis::Y)], [tap(511), tap(1023)]);
    assert_eq!([part.stored(Axis::X), part.stored(Axis::Y)], [tap(512); 2]);
    assert_eq!((part.ignored_illegal(), part.ignored_busy()), (0, 0));
}

#[test]
fn a_memory_write_does_not_move_the_wiper_until_the_next_power_up() {
    let mut part = part();
    send(&mut part, 0x11 << 16 | 300 << 6, 24, 0);
    assert_eq!((part.wiper(Axis::X), part.stored(Axis::X)), (tap(512), tap(300)));
    part.power_cycle();
    assert_eq!(part.wiper(Axis::X), tap(300));
}

#[test]
fn copies_take_8_or_24_clocks_and_one_or_both_channels() {
    let mut part = part();
    send(&mut part, 0x01 << 16 | 100 << 6, 24, 0);
    send(&mut part, 0x02 << 16 | 200 << 6, 24, 0);
    send(&mut part, 0x23, 8, 0);
    assert_eq!([part.stored(Axis::X), part.stored(Axis::Y)], [tap(100), tap(200)]);
    send(&mut part, 0x01 << 16, 24, 12 * MS);
    send(&mut part, 0x02 << 16, 24, 12 * MS);
    send(&mut part, 0x31 << 16 | 0xABCD, 24, 12 * MS);
    assert_eq!([part.wiper(Axis::X), part.wiper(Axis::Y)], [tap(100), tap(0)]);
    send(&mut part, 0x33, 8, 12 * MS);
    assert_eq!([part.wiper(Axis::X), part.wiper(Axis::Y)], [tap(100), tap(200)]);
    assert_eq!([part.stores(Axis::X), part.stores(Axis::Y)], [1, 1]);
}

#[test]
fn frames_during_a_store_are_ignored_and_counted() {
    let mut part = part();
    send(&mut part, 0x12 << 16 | 7 << 6, 24, 5 * MS);
    send(&mut part, 0x02 << 16 | 9 << 6, 24, 17 * MS - 1);
    assert_eq!((part.wiper(Axis::Y), part.ignored_busy()), (tap(512), 1));
    send(&mut part, 0x02 << 16 | 9 << 6, 24, 17 * MS);
    assert_eq!((part.wiper(Axis::Y), part.ignored_busy()), (tap(9), 1));
}

#[test]
fn every_store_counts_and_no_volatile_write_does() {
    let mut part = part();
    for round in 0..5 {
        send(&mut part, 0x11 << 16 | 42 << 6, 24, round * 100 * MS);
        send(&mut part, 0x21, 8, round * 100 * MS + 50 * MS);
        send(&mut part, 0x01 << 16 | 43 << 6, 24, round * 100 * MS + 99 * MS);
        send(&mut part, 0x31, 8, round * 100 * MS + 99 * MS);
    }
    assert_eq!([part.stores(Axis::X), part.stores(Axis::Y)], [10, 0]);
}

#[test]
fn a_frame_of_any_other_length_is_ignored_and_counted() {
    for clocks in (0..=64).filter(|clocks| ![8, 24].contains(clocks)) {
        let mut part = part();
        send(&mut part, 0x01 << 16 | 5 << 6, clocks, 0);
        send(&mut part, 0x33, clocks, 0);
        assert_eq!((part.wiper(Axis::X), part.ignored_illegal()), (tap(512), 2), "{clocks} clocks");
    }
}

#[test]
fn exactly_ten_commands_are_legal_in_24_clocks_and_six_in_8() {
    let legal = |clocks: u32| -> Vec<u64> {
        (0..256)
            .filter(|command| {
                let mut part = part();
                send(&mut part, command << (clocks - 8), clocks, 0);
                part.ignored_illegal() == 0
            })
            .collect()
    };
    assert_eq!(legal(24), [0x01, 0x02, 0x11, 0x12, 0x21, 0x22, 0x23, 0x31, 0x32, 0x33]);
    assert_eq!(legal(8), [0x21, 0x22, 0x23, 0x31, 0x32, 0x33]);
}
