//! The firmware in QEMU against the application run natively. Run by `cargo xtask test firmware`.

#![cfg(unix)]
#![allow(clippy::unwrap_used)] // what a test cannot do without

use zerorate_bench::emulated;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::{Phase, Recorder, Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::UnitSerial;
use zerorate_core::wire::SampleWindow;

#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn twenty_groups_with_all_samples_are_the_same_bits() {
    let setup = SetUp::paper();
    let unit = UnitSerial::try_from("ZR-7").unwrap();
    let firmware = emulated::find_firmware(None).unwrap();
    let mut native = simulated::bench(PlantKind::Paper.build(1), &setup, &unit);
    let mut emulated = emulated::bench(PlantKind::Paper.build(1), &setup, &unit, &firmware).unwrap();
    let [native, emulated] = [&mut native, &mut emulated].map(|bench| {
        let mut progress = Silent;
        let began = std::time::Instant::now();
        let mut session = Session::new(bench, &setup, &mut progress);
        session.begin().unwrap();
        let identity = session.bench.device.identify().unwrap();
        session.start(SampleWindow::NONE).unwrap();
        let plain = session.until(100, Phase::Soak, &mut Recorder::discarding()).unwrap();
        session.stop().unwrap();
        println!("{:?}", began.elapsed());
        session.start(SampleWindow::ALL).unwrap();
        let groups: Vec<_> = (0..20).map(|_| session.bench.device.next_group().unwrap()).collect();
        println!("{:?}", began.elapsed());
        let plain: Vec<_> = plain.into_iter().map(|taken| taken.report).collect();
        (identity, plain, groups)
    });
    assert_eq!(native.0.unit, emulated.0.unit);
    assert_eq!(native.1, emulated.1);
    assert_eq!(native.2, emulated.2);
    assert_eq!(emulated.2[19].samples[1].len(), 500);
}
