//! A recording whose process is killed at any moment keeps every whole group, and `info` says that it is cut.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use zerorate_cal::recording::Recording;

use crate::{bench, zerorate};

/// Where the child records; its being set makes the test below the child.
const RECORD_TO: &str = "ZERORATE_TEST_RECORDS_FOREVER";
/// Kills.
const KILLS: u64 = 20;
/// Guards against a child that hangs, however slow the machine.
const HANGS: Duration = Duration::from_secs(600);

#[test]
fn records_until_it_is_killed_where_a_test_asks_for_it() {
    let Some(path) = env::var_os(RECORD_TO) else { return };
    let mut writer = bench::recording(Path::new(&path));
    for number in 0.. {
        writer.write_group(&bench::group(number)).unwrap();
    }
}

#[test]
fn every_whole_group_survives_a_kill_at_any_moment() {
    let mut random = 20_u64;
    let mut most = 0;
    for kill in 0..KILLS {
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(env::current_exe().unwrap())
            .args(["--exact", "killed::records_until_it_is_killed_where_a_test_asks_for_it"])
            .env(RECORD_TO, folder.path().join("run.parquet"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let stream = folder.path().join("run.arrows");
        let began = Instant::now();
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // The header is a few kB; a kill before it is another story, told in `info.rs`.
        let bytes = 10_000 + (random >> 33) % 100_000;
        while fs::metadata(&stream).map_or(0, |file| file.len()) < bytes {
            assert!(began.elapsed() < HANGS, "the child does not record");
            thread::sleep(Duration::from_micros(200));
        }
        // SIGKILL, on Unix.
        child.kill().unwrap();
        child.wait().unwrap();

        let size = fs::metadata(&stream).unwrap().len();
        let recording = Recording::read(&(&stream).into()).unwrap();
        let groups = recording.groups();
        most = most.max(groups);
        assert!(recording.cut, "kill {kill}");
        assert_eq!(recording.rows.len(), 2 * groups, "kill {kill}: whole groups only");
        for (number, rows) in (0..).zip(recording.rows.chunks(2)) {
            assert_eq!(rows, bench::group(number), "kill {kill}: group {number} as it was written");
        }
        assert_all_whole(folder.path(), groups, size);

        let ran = zerorate(folder.path(), &["info", "run.arrows", "--json"]);
        let found = &ran.json()["files"][0];
        assert_eq!((ran.code, &found["cut"], &found["whole_groups"]), (0, &true.into(), &groups.into()));
    }
    assert!(most > 20, "the kills fell too early to show anything: {most} groups at most");
}

/// One group more would not have fitted into the killed stream: none that was whole was left out.
fn assert_all_whole(folder: &Path, groups: usize, killed_size: u64) {
    let size_with = |groups: usize| {
        // Each under a name of its own: a command that another test starts at this moment has this one's files, and with them
        // the lock of a recording, until it runs.
        let path = folder.join(format!("{groups}-groups.parquet"));
        let mut writer = bench::recording(&path);
        (0..groups).for_each(|number| writer.write_group(&bench::group(u32::try_from(number).unwrap())).unwrap());
        fs::metadata(path.with_extension("arrows")).unwrap().len()
    };
    assert!(size_with(groups) <= killed_size && killed_size < size_with(groups + 1));
}
