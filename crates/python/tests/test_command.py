"""The command that comes with the package."""

import signal
import subprocess
import sys
from pathlib import Path

ZERORATE = Path(sys.executable).with_name("zerorate")


def run(*arguments, **keywords):
    return subprocess.run([ZERORATE, *map(str, arguments)], capture_output=True, text=True, check=False, **keywords)


def test_it_says_and_writes_what_the_built_command_does(command, csv, tmp_path):
    ours, theirs = tmp_path / "ours.json", tmp_path / "theirs.json"
    printed = run("fit", csv, "--out", ours).stdout
    assert printed.replace("ours", "theirs") == command("fit", csv, "--out", theirs).stdout
    assert ours.read_text() == theirs.read_text()
    assert run("--version").stdout == command("--version").stdout


def test_its_exit_codes_are_the_commands(csv):
    assert run("help").returncode == 0
    wrong = run("fit", "--wrong", csv)
    assert (wrong.returncode, "--wrong" in wrong.stderr) == (2, True)
    assert run("fit", "missing.csv").returncode == 2


def test_what_to_type_next_is_the_command_as_it_was_typed(csv):
    assert f"zerorate fit {csv} --plain --out calibration.json" in " ".join(run("fit", csv, "--plain").stdout.split())


def test_ctrl_c_stops_it(tmp_path):
    asked = [ZERORATE, "virtual-board", "--on", f"pty:{tmp_path}/board"]
    board = subprocess.Popen(asked, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    # It says so when it hears.
    assert "listens" in board.stdout.readline()
    assert board.poll() is None
    board.send_signal(signal.SIGINT)
    assert board.wait(timeout=10) == 0
