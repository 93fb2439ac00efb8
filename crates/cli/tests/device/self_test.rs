//! A board's test of itself, on a line: what is printed, as a page and as JSON, and how it ends.

use crate::board::Board;

#[test]
fn a_board_tests_itself_and_says_what_to_do_where_it_fails() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::start("tcp:127.0.0.1:0", &["--speed", "60"], folder.path());
    // As its maker delivers it, the potentiometer's memory holds tap 512.
    board.device(&["self-test"], folder.path()).ends(1, &["has failed its test", "first-time"]);
    board.device(&["first-time", "--yes"], folder.path()).ends(0, &["is stored"]);
    board.device(&["self-test"], folder.path()).ends(0, &["has passed its test", "wiper X, plus 8 taps", "not run"]);
    let found = board.device(&["self-test", "--json"], folder.path()).json();
    assert_eq!((&found["passed"], &found["unit_serial"]), (&true.into(), &"ZR-0042".into()));
    board.order("break saturated-y");
    let failed = board.device(&["self-test", "--json"], folder.path());
    assert_eq!((failed.code, &failed.json()["passed"]), (Some(1), &false.into()));
    board.device(&["self-test"], folder.path()).ends(1, &["reading Y", "plugged in"]);
}
