"""Simulations, against FMPy as an independent master of the same FMU."""

import threading

import fmpy
import numpy as np
import pytest

import stickslip


def test_val_a_motion_is_that_of_another_master():
    found = stickslip.simulate(
        belt_velocity=0.08,
        normal_force=60.0,
        duration=0.3,
        step=1e-3,
        variables=["tip_displacement", "friction_force"],
    )
    other = fmpy.simulate_fmu(
        stickslip.FMU,
        stop_time=0.3,
        output_interval=1e-3,
        step_size=1e-3,
        start_values={"belt_velocity": 0.08, "normal_force": 60.0},
        output=["tip_displacement", "friction_force"],
    )
    assert len(found) == 301 == len(other)
    for name in ("tip_displacement", "friction_force"):
        spread = np.ptp(other[name])
        assert np.max(np.abs(found[name] - other[name])) < 1e-6 * spread, name


def test_arrays_drive_inputs():
    time = np.linspace(0.0, 0.1, 1001)
    force = 5.0 * np.sin(2 * np.pi * 60 * time)
    options = {
        "belt_velocity": 0.0,
        "normal_force": 0.0,
        "duration": 0.1,
        "variables": ["tip_displacement"],
    }
    driven = stickslip.simulate(inputs={"time": time, "external_force": force}, **options)
    still = stickslip.simulate(**options)
    assert np.ptp(driven["tip_displacement"]) > 10 * np.ptp(still["tip_displacement"])


def test_a_simulation_shows_itself():
    found = stickslip.simulate(duration=0.01)
    frame = found.to_pandas()
    assert list(frame.index) == list(found.time) and list(frame.columns) == list(found.values)
    assert found.units["tip_displacement"] == "m"
    assert "tip_displacement" in found._repr_html_() and "101 samples" in repr(found)
    figure = found.plot("tip_displacement", "friction_force")
    np.testing.assert_array_equal(figure.data[1].y, found["friction_force"])
    assert figure.layout.yaxis2.title.text == "friction force [N]"


def test_errors_have_the_command_s_text():
    with pytest.raises(
        stickslip.BadInput, match="0 s is not possible; give a time greater than zero"
    ):
        stickslip.simulate(duration=0.0)
    with pytest.raises(ValueError, match="belt_velocty"):
        stickslip.simulate(settings={"belt_velocty": 0.1})
    with pytest.raises(stickslip.StickslipError, match="no_such.fmu"):
        stickslip.simulate(fmu="no_such.fmu")


def test_other_threads_run_meanwhile_and_hear_of_progress():
    counted, heard, end = [0], [], threading.Event()

    def count():
        while not end.is_set():
            counted[0] += 1
            end.wait(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    stickslip.simulate(
        duration=40.0, step=1e-4, progress=lambda what, share: heard.append((what, share))
    )
    end.set()
    thread.join()
    assert counted[0] > 20, counted
    shares = [share for _, share in heard]
    assert (
        shares == sorted(shares)
        and 0.0 <= shares[0]
        and shares[-1] <= 1.0
        and heard[-1][0] == "simulating"
    )


def test_what_progress_raises_ends_the_work():
    def refuse(what, share):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        stickslip.simulate(duration=1000.0, progress=refuse)
