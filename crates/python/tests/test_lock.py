"""While Rust is at work other threads run, and Ctrl-C is heard."""

import os
import signal
import threading
import time

import pytest

import zerorate


class Slow(os.PathLike):
    """A pipe that nobody has written to yet: its reading waits."""

    def __init__(self, path):
        os.mkfifo(path)
        self.path = path

    def __fspath__(self):
        return str(self.path)


def test_ctrl_c_is_heard(tmp_path):
    press = threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT])
    press.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        zerorate.fit(Slow(tmp_path / "pipe"))
    assert time.monotonic() - began < 5.0


def test_other_threads_run_meanwhile(columns):
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.wait(0.001):
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    zerorate.fit(columns)
    done.set()
    thread.join()
    assert counted > 5
