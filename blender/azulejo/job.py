# SPDX-License-Identifier: MIT OR Apache-2.0
"""Runs azulejo as a child process, and says how far it is."""

import os
import re
import shutil
import subprocess
import threading
import time
from collections import deque
from pathlib import Path

try:
    import fcntl
    import pty
    import struct
    import termios
except ImportError:
    # Windows has no pseudo-terminals of this kind.
    pty = None

CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
BAR = re.compile(r"^\s*(?P<stage>.*?)\s*\[[=> ]*\]\s*(?P<percent>\d+)%")
# Where programs are that a Blender started from a menu does not find: the search path may be that of the shell only.
PLACES = ("~/.cargo/bin", "~/.local/bin", "/usr/local/bin")
WHERE = "in Edit › Preferences › Add-ons › azulejo"
# Seconds that the program has to end after it was asked to.
PATIENCE = 3.0


class JobError(Exception):
    """The program is missing, or has failed; the text says why."""


def find_executable(given: str) -> str:
    """The program: the one that the user has named, or the one on the search path or in usual places."""
    found = shutil.which(given or "azulejo")
    if not found and not given:
        found = shutil.which("azulejo", path=os.pathsep.join(os.path.expanduser(place) for place in PLACES))
    if found:
        return found
    if given:
        what = "is not a program that can be run" if os.path.exists(given) else "is not there"
        raise JobError(f"{given} {what}: set the path of azulejo {WHERE}")
    raise JobError(f"azulejo is not on the search path: install it, or set its path {WHERE}")


class Job:
    """A run of azulejo."""

    def __init__(self, command: list[str], folder: Path) -> None:
        """Starts the command; its standard output goes to a file in the folder."""
        self.started = time.monotonic()
        self.stage, self.percent = "", 0
        self.lines: deque[str] = deque(maxlen=12)
        self.output = folder / "report.json"
        # The program draws its progress on terminals only.
        reading, writing = pty.openpty() if pty else os.pipe()
        if pty:
            fcntl.ioctl(writing, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 160, 0, 0))
        try:
            with self.output.open("wb") as output:
                self.process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=writing,
                    env={**os.environ, "TERM": "xterm"},
                    creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
                )
        except OSError as error:
            os.close(reading)
            raise JobError(f"{command[0]} cannot be started: {error}") from error
        finally:
            os.close(writing)
        self.reader = threading.Thread(target=self._read, args=(reading,), daemon=True)
        self.reader.start()

    def _read(self, source: int) -> None:
        """Follows what the program says, until it ends."""
        rest = ""
        with open(source, "rb", buffering=0) as stream:
            while True:
                try:
                    data = stream.read(4096)
                except OSError:
                    # How Linux says that the other side of a pseudo-terminal is closed.
                    break
                if not data:
                    break
                text = rest + CONTROL.sub("", data.decode("utf-8", "replace"))
                *complete, rest = re.split(r"[\r\n]+", text)
                # The bar is drawn again and again in one line that does not end.
                for line in [*complete, rest]:
                    self._hear(line, is_whole=line is not rest)

    def _hear(self, line: str, is_whole: bool) -> None:
        """Takes note of one line."""
        bar = BAR.match(line)
        if bar:
            self.stage, self.percent = bar["stage"], int(bar["percent"])
        elif is_whole and line.strip() and "%  " not in line:
            self.lines.append(line.strip())

    def is_running(self) -> bool:
        """Whether the program has not ended yet."""
        return self.process.poll() is None

    def status(self) -> str:
        """A few words on the state of the work."""
        if not self.is_running():
            return "done, waits for Object Mode"
        seconds = time.monotonic() - self.started
        stage = self.stage or (self.lines[-1] if self.lines else "starting")
        percent = f" {self.percent}%" if self.stage else ""
        return f"{stage}{percent}, {seconds:.0f} s"

    def finish(self) -> None:
        """Waits for the end; raises an error with the last words of the program if it has failed."""
        code = self.process.wait()
        self.reader.join(PATIENCE)
        if code != 0:
            said = [line for line in self.lines if not line.startswith("warning:")] or list(self.lines)
            words = "\n".join(said[-6:]) or self.output.read_text("utf-8", "replace")[-600:]
            raise JobError(f"azulejo has failed (exit code {code}):\n{words}")

    def cancel(self) -> None:
        """Ends the program, in an orderly way if it can."""
        if self.is_running():
            self.process.terminate()
            try:
                self.process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.reader.join(PATIENCE)
