use std::collections::BTreeMap;

use super::*;

const FILES: [&str; 3] = ["calibration.json", "full-temperature.parquet", "summary.json"];

/// A folder with an earlier set, a user's own file and folder, and a run that is whole, with what an earlier run had left.
fn bench() -> (tempfile::TempDir, PathBuf) {
    let bench = tempfile::tempdir().unwrap();
    let folder = bench.path().join("calibration");
    fs::create_dir_all(folder.join(IN_PROGRESS)).unwrap();
    fs::create_dir_all(folder.join("photographs")).unwrap();
    for file in FILES {
        fs::write(folder.join(file), "earlier").unwrap();
        fs::write(folder.join(IN_PROGRESS).join(file), "new").unwrap();
    }
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    fs::write(folder.join("photographs/board.jpg"), "mine").unwrap();
    fs::write(folder.join(IN_PROGRESS).join("soaks.cut.arrows"), "cut").unwrap();
    (bench, folder)
}

/// Every file below a folder, with what is in it.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
                found.insert(name, fs::read_to_string(path).unwrap());
            }
        }
    }
    found
}

/// The set that is in a folder, if it is whole and of one run.
fn set(folder: &Path) -> Option<String> {
    let found = files(folder);
    let set: Vec<&String> = FILES.iter().map(|file| found.get(*file)).collect::<Option<_>>()?;
    set.iter().all(|text| *text == set[0]).then(|| set[0].clone())
}

fn live() -> io::Result<()> {
    Ok(())
}

/// What ends everything after so many changes of the disk.
fn dying(mut left: usize) -> impl FnMut() -> io::Result<()> {
    move || {
        left = left.checked_sub(1).ok_or(io::ErrorKind::Interrupted)?;
        Ok(())
    }
}

fn publish_dying(folder: &Path, moments: usize) -> Option<Option<PathBuf>> {
    publish(folder, &FILES, &mut dying(moments)).ok()
}

fn assert_settled(bench: &Path, folder: &Path, expected: &str) {
    assert_eq!(set(folder).as_deref(), Some(expected));
    let found = files(folder);
    assert_eq!((found["notes.txt"].as_str(), found["photographs/board.jpg"].as_str()), ("mine", "mine"));
    assert_eq!(found["in-progress/soaks.cut.arrows"], "cut");
    assert_eq!(fs::read_dir(bench).unwrap().count(), 1, "nothing is left beside");
}

#[test]
fn a_set_takes_the_place_of_the_earlier_one_and_a_users_own_files_stay() {
    let (bench, folder) = bench();
    assert_eq!(publish(&folder, &FILES, &mut live).unwrap(), None);
    assert_settled(bench.path(), &folder, "new");
    assert_eq!(files(&folder).len(), FILES.len() + 3, "what is in place is not in progress");
}

#[test]
fn a_kill_at_any_moment_leaves_a_whole_set_and_every_file_and_the_next_run_finishes_it() {
    let mut outcomes = Vec::new();
    for moments in 0_usize.. {
        let (bench, folder) = bench();
        let mut left = moments;
        let mut survived = true;
        let mut at = || {
            survived = left > 0;
            left = left.checked_sub(1).ok_or(io::ErrorKind::Interrupted)?;
            Ok(())
        };
        let _ = publish(&folder, &FILES, &mut at);

        // In place is one whole set or, between two renames, nothing; then both are beside.
        let in_place = set(&folder);
        if folder.exists() {
            assert!(in_place.is_some(), "{moments}: a mixture");
        } else {
            let beside: Vec<_> = fs::read_dir(bench.path()).unwrap().flatten().map(|entry| entry.path()).collect();
            let sets: Vec<_> = beside.iter().map(|folder| set(folder)).collect();
            assert_eq!(sets.iter().flatten().count(), 2, "{moments}: {beside:?}");
        }
        let all = files(bench.path());
        for own in ["notes.txt", "photographs/board.jpg", "in-progress/soaks.cut.arrows"] {
            assert_eq!(all.keys().filter(|name| name.ends_with(own)).count(), 1, "{moments}: {own}");
        }

        recover(&folder, &mut live).unwrap();
        let expected = in_place.unwrap_or_else(|| "new".to_owned());
        assert_settled(bench.path(), &folder, &expected);
        outcomes.push(expected);
        if survived {
            break;
        }
    }
    assert!(outcomes.is_sorted(), "once the new set is there it stays: {outcomes:?}");
    assert!(outcomes.iter().any(|set| set == "earlier") && outcomes.iter().any(|set| set == "new"));
}

#[test]
fn what_cannot_be_moved_back_is_told_and_keeps_nothing_else_from_it() {
    let (bench, folder) = bench();
    // Ended just before the earlier folder is removed, as where something in it cannot be moved.
    let changes = (0..).find(|&moments| publish_dying(&self::bench().1, moments) == Some(None)).unwrap();
    let aside = publish_dying(&folder, changes - 1).unwrap().unwrap();
    assert!(aside.is_dir() && aside.parent() == folder.parent());
    assert_eq!(set(&folder).as_deref(), Some("new"));
    assert_eq!(files(&folder)["notes.txt"], "mine");
    recover(&folder, &mut live).unwrap();
    assert_settled(bench.path(), &folder, "new");
}

#[test]
fn a_kill_while_the_next_run_finishes_it_loses_nothing_either() {
    for moments in 0..40 {
        let (bench, folder) = bench();
        let _ = publish(&folder, &FILES, &mut dying(8));
        let _ = recover(&folder, &mut dying(moments));
        recover(&folder, &mut live).unwrap();
        assert_settled(bench.path(), &folder, "new");
    }
}

#[test]
fn a_folder_that_cannot_be_moved_gets_its_files_one_by_one_and_they_stay_whole_meanwhile() {
    for moments in 0..40 {
        let (_bench, folder) = bench();
        let result = one_by_one(&folder, &FILES, &mut dying(moments));
        match result {
            Ok(()) => assert_eq!(set(&folder).as_deref(), Some("new")),
            Err(_) => {
                let of_run = set(&folder.join(IN_PROGRESS));
                assert!(of_run.as_deref() == Some("new") || set(&folder).as_deref() == Some("new"), "{moments}");
            }
        }
    }
}

#[test]
fn what_only_looks_like_ours_is_left_alone() {
    let (bench, folder) = bench();
    for name in ["calibration.next", "calibration.old.earlier", "other.12.earlier"] {
        fs::create_dir(bench.path().join(name)).unwrap();
    }
    recover(&folder, &mut live).unwrap();
    assert_eq!(fs::read_dir(bench.path()).unwrap().count(), 4);
    assert_eq!(set(&folder).as_deref(), Some("earlier"));
}
