"""Starts insonify_slicer on a free port, and ends it."""
import os
import re
import signal
import subprocess


class Server:
    def __init__(self, program, *options):
        self.process = subprocess.Popen([program, "--port", "0", *options], stdout=subprocess.PIPE, text=True)
        said = ""
        while not (found := re.search(r"port (\d+)", said)):
            line = self.process.stdout.readline()
            assert line, f"the server says {said!r}"
            said += line
        self.port = int(found.group(1))

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self.end()

    def cpu_seconds(self):
        fields = open(f"/proc/{self.process.pid}/stat").read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self, how=signal.SIGTERM):
        """Its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.stdout.read()
        return self.process.wait(20)
