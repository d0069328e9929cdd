"""Ctrl-C in long work: KeyboardInterrupt, soon, and what was finished is kept."""

import os
import signal
import subprocess
import sys
import time

import pytest

PROGRAM = """
import sys, stickslip
try:
    tell = lambda what, share: print(what, flush=True)
    stickslip.diagnose(sys.argv[1], output=sys.argv[2], progress=tell)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of a console differ elsewhere")
def test_ctrl_c_ends_a_diagnosis_and_keeps_what_was_fitted(demo, tmp_path):
    line = [sys.executable, "-c", PROGRAM, str(demo.folder), str(tmp_path / "out")]
    # A shell starts background jobs with SIGINT ignored, which a program inherits.
    def heeds_ctrl_c():
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    pipe = subprocess.PIPE
    with subprocess.Popen(line, stdout=pipe, text=True, preexec_fn=heeds_ctrl_c) as program:
        # A search of the candidates has begun.
        for said in program.stdout:
            if "of" in said:
                break
        begun = time.monotonic()
        program.send_signal(signal.SIGINT)
        rest = program.stdout.read()
        assert program.wait() == 0 and rest.rstrip().endswith("interrupted"), rest
        assert time.monotonic() - begun < 60
    assert (tmp_path / "out" / "unfinished.fits").stat().st_size > 1000
