"""While Rust is at work other threads run, and Ctrl-C is heard."""

import os
import signal
import threading

import pytest

import zerorate


class Slow(os.PathLike):
    """A pipe that nobody has written to yet: its reading waits."""

    def __init__(self, path):
        os.mkfifo(path)
        self.path = path

    def __fspath__(self):
        return str(self.path)


@pytest.fixture
def keys():
    """Ctrl-C as at a terminal: what a shell starts in the background is deaf to it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_is_heard(tmp_path, keys):
    slow = Slow(tmp_path / "pipe")
    press = threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT])
    # Who is not heard is not waited for: a writer that comes and goes ends the reading.
    end = threading.Timer(60.0, lambda: open(slow.path, "wb").close())
    end.daemon = True
    press.start()
    end.start()
    with pytest.raises(KeyboardInterrupt):
        zerorate.fit(slow)
    end.cancel()


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
