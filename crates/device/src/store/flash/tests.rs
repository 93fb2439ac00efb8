use std::format;
use std::vec;
use std::vec::Vec;

use zerorate_sim::{Flash, HalfErased};

use super::*;

/// Pages as an external NOR flash erases them, words as a microcontroller's own flash writes them.
type External = Flash<4096, 4>;
/// Small pages and long words.
type Internal = Flash<2048, 8>;
/// Bytes written one by one.
type Serial = Flash<4096, 1>;

fn open<const PAGE: usize, const WORD: usize>(flash: Flash<PAGE, WORD>) -> FlashStore<Flash<PAGE, WORD>> {
    let end = u32::try_from(flash.bytes().len()).unwrap();
    FlashStore::new(flash, 0..end).unwrap()
}

/// A record that no other record and no part of another is mistaken for.
fn record(number: u32, length: usize) -> Vec<u8> {
    let noise =
        |k: u32| (k.wrapping_mul(2_654_435_761) ^ number.wrapping_mul(40_503)).wrapping_mul(2_246_822_519) >> 24;
    (0..u32::try_from(length).unwrap()).map(|k| u8::try_from(noise(k)).unwrap()).collect()
}

fn read(store: &mut impl RecordStore) -> Vec<u8> {
    let mut bytes = vec![0; MAX_RECORD_BYTES + 1];
    let n = store.read(0, &mut bytes).unwrap();
    bytes.truncate(n);
    assert_eq!(n, usize::from(store.stored().length()));
    bytes
}

#[test]
fn a_blank_flash_says_so_and_a_record_survives_the_power() {
    let mut store = open(External::erased(4));
    assert_eq!((store.stored(), read(&mut store)), (Stored::Blank, vec![]));
    for (number, length) in [(1, 3000), (2, 1), (3, MAX_RECORD_BYTES), (4, 255), (5, 256)] {
        store.commit(&record(number, length)).unwrap();
        assert_eq!(read(&mut store), record(number, length));
        store = open(store.banks.flash.0);
        assert_eq!(store.stored(), Stored::Whole(u16::try_from(length).unwrap()));
        assert_eq!(read(&mut store), record(number, length));
    }
    assert_eq!(store.commit(&[]), Err(StoreFailed));
    assert_eq!(store.commit(&[0; MAX_RECORD_BYTES + 1]), Err(StoreFailed));
}

#[test]
fn any_part_of_a_record_can_be_read() {
    let mut store = open(External::erased(4));
    let whole = record(9, 1500);
    store.commit(&whole).unwrap();
    for (offset, length) in [(0, 128), (200, 128), (254, 2), (255, 255), (1400, 128), (1499, 1), (1500, 8), (9000, 8)] {
        let mut part = vec![0; length];
        let n = store.read(offset, &mut part).unwrap();
        assert_eq!(part[..n], whole[offset.min(1500)..(offset + length).min(1500)], "{length} from {offset}");
    }
}

#[test]
fn whichever_bit_of_the_newest_record_turns_the_one_before_it_is_not_taken_for_it() {
    let mut store = open(External::erased(4));
    store.commit(&record(1, 480)).unwrap();
    store.commit(&record(2, 480)).unwrap();
    let flash = store.banks.flash.0;
    let start = usize::from(store.bank) * flash.bytes().len() / 2;
    let written = (start..start + flash.bytes().len() / 2).filter(|&at| flash.bytes()[at] != 0xFF);
    for (at, bit) in written.flat_map(|at| (0..8).map(move |bit| (at, 1 << bit))) {
        let mut damaged = flash.clone();
        damaged.wear(at, bit);
        let mut store = open(damaged);
        let expected = match store.stored() {
            // A mark of a page, which says nothing of the record.
            Stored::Whole(480) => record(2, 480),
            Stored::Older(480) => record(1, 480),
            other => panic!("byte {at}, bit {bit}: {other:?}"),
        };
        assert_eq!(read(&mut store), expected, "byte {at}, bit {bit}");
    }
}

#[test]
fn a_store_that_was_written_over_is_not_blank() {
    for seed in 0..50 {
        let mut flash = External::erased(4);
        for (at, byte) in record(seed, flash.bytes().len()).into_iter().enumerate() {
            flash.wear(at, !byte);
        }
        assert_eq!(open(flash).stored(), Stored::Damaged, "{seed}");
    }
}

/// Cuts the power in the middle of every write of a word and every erase of a page of many commits in a row, each way
/// that an erase may be left, and looks what is found afterwards. Returns how many cuts were made.
fn cut_everywhere<const PAGE: usize, const WORD: usize>(pages: usize, lengths: &[usize], commits: u32) -> u32 {
    let mut flash = Flash::<PAGE, WORD>::erased(pages);
    let (mut cuts, mut lost) = (0, 0);
    let mut old = Vec::new();
    for number in 0..commits {
        let new = record(number, lengths[number as usize % lengths.len()]);
        let mut after = 0;
        let whole = loop {
            // The first operations are erases, and leave what they leave.
            let halves =
                if after < u32::try_from(pages).unwrap() { &HalfErased::ALL[..] } else { &HalfErased::ALL[..1] };
            let mut finished = None;
            for &half in halves {
                let mut flash = flash.clone();
                flash.cut_power_after(after, half);
                let mut store = open(flash);
                let committed = store.commit(&new);
                let mut cut = store.banks.flash.0;
                if cut.is_powered() {
                    assert_eq!(committed, Ok(()));
                    cut.restore_power();
                    finished = Some(cut);
                    break;
                }
                assert_eq!(committed, Err(StoreFailed));
                cut.restore_power();
                cuts += 1;
                let mut store = open(cut);
                let found = read(&mut store);
                lost += u32::from(found != old && found != new);
                // What was begun does not stand in the way of the next attempt, nor does a cut in that one.
                if after % 7 < 2 {
                    let mut flash = store.banks.flash.0;
                    flash.cut_power_after(after / 2, half);
                    let mut again = open(flash);
                    let _ = again.commit(&new);
                    let mut flash = again.banks.flash.0;
                    flash.restore_power();
                    let mut again = open(flash);
                    let found = read(&mut again);
                    lost += u32::from(found != old && found != new);
                    again.commit(&new).unwrap();
                    assert_eq!(
                        read(&mut open(again.banks.flash.0)),
                        new,
                        "commit {number}, cut {after}, {half:?}, again"
                    );
                }
            }
            match finished {
                Some(flash) => break flash,
                None => after += 1,
            }
        };
        assert_eq!(after, whole.operations() - flash.operations(), "every operation was cut");
        flash = whole;
        old = new;
    }
    assert_eq!(lost, 0, "of {cuts} cuts");
    std::println!("{cuts} cuts in {commits} commits on pages of {PAGE} and words of {WORD}: both records lost 0 times");
    cuts
}

#[test]
fn no_cut_of_the_power_loses_both_records() {
    let cuts = cut_everywhere::<4096, 4>(4, &[700, 1500, 260], 12);
    assert!(cuts > 2000, "{cuts} cuts");
}

#[test]
fn no_cut_loses_both_records_with_longer_words_and_smaller_pages() {
    let cuts = cut_everywhere::<2048, 8>(8, &[600, 3000], 12);
    assert!(cuts > 2000, "{cuts} cuts");
}

#[test]
fn no_cut_loses_both_records_with_words_of_a_byte() {
    let cuts = cut_everywhere::<4096, 1>(4, &[300], 6);
    assert!(cuts > 1500, "{cuts} cuts");
}

#[test]
fn no_cut_loses_both_records_of_the_greatest_length() {
    let cuts = cut_everywhere::<16_384, 4>(2, &[MAX_RECORD_BYTES], 3);
    assert!(cuts > 4000, "{cuts} cuts");
}

#[test]
fn a_damaged_record_gives_way_to_the_one_before_it_and_two_damaged_ones_to_none() {
    let mut store = open(External::erased(4));
    let (first, second) = (record(1, 900), record(2, 900));
    store.commit(&first).unwrap();
    store.commit(&second).unwrap();
    let mut flash = store.banks.flash.0;
    let place = |flash: &External, what: &[u8]| {
        flash.bytes().windows(64).position(|window| window == &what[100..164]).expect("the record is in the flash")
    };
    flash.wear(place(&flash, &second), 0xFF);
    let mut store = open(flash);
    assert_eq!((store.stored(), read(&mut store)), (Stored::Older(900), first.clone()));
    let mut flash = store.banks.flash.0;
    flash.wear(place(&flash, &first), 0xFF);
    let mut store = open(flash);
    assert_eq!((store.stored(), read(&mut store)), (Stored::Damaged, vec![]));
    let third = record(3, 900);
    store.commit(&third).unwrap();
    let mut store = open(store.banks.flash.0);
    assert_eq!((store.stored(), read(&mut store)), (Stored::Whole(900), third));
}

#[test]
fn a_flash_full_of_something_else_is_no_record_and_is_taken_over() {
    for fill in [0x00, 0xA5, 0x7F] {
        let mut flash = Internal::erased(8);
        for at in 0..flash.bytes().len() {
            flash.wear(at, !fill);
        }
        let mut store = open(flash);
        assert_eq!(store.stored().length(), 0, "{fill:#x}");
        store.commit(&record(1, 2000)).unwrap();
        assert_eq!(read(&mut open(store.banks.flash.0)), record(1, 2000), "{fill:#x}");
    }
}

#[test]
fn a_flash_that_does_not_answer_is_said_and_a_range_too_small_refused() {
    let mut flash = External::erased(4);
    flash.cut_power_after(0, HalfErased::Zeros);
    let _ = embedded_storage::nor_flash::NorFlash::erase(&mut flash, 0, 4096);
    let mut store = open(flash);
    assert_eq!(store.stored(), Stored::Unreachable);
    assert_eq!(store.commit(&record(1, 100)), Err(StoreFailed));
    let refused = |pages, range| FlashStore::new(External::erased(pages), range).err();
    assert_eq!(refused(8, 0..2 * 4096), Some(Unusable::TooSmall { items: 14, needed: 26 }));
    for range in [0..10_000, 0..3 * 4096, 2048..2048 + 4 * 4096] {
        assert_eq!(refused(8, range), Some(Unusable::Geometry));
    }
    assert!(refused(8, 3 * 4096..7 * 4096).is_none());
    assert!(format!("{:?}", open(Serial::erased(4)).stored()).contains("Blank"));
}
