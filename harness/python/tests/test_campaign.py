"""Campaigns from arrays, frames and files are the same to the last digit."""

import numpy as np
import pandas
import pytest
import scipy.io
from conftest import BEAM, motion

import stickslip


def assert_same(found, arrays):
    for run, time, displacement, belt, load in zip(found.runs, *arrays, strict=True):
        np.testing.assert_array_equal(run.time, time)
        np.testing.assert_array_equal(run.displacement, displacement)
        assert (run.belt_velocity, run.normal_force) == (belt, load)


def test_arrays_come_back_to_the_last_digit(small, small_arrays):
    assert_same(small, small_arrays)
    assert small.name == "small" and small["run02"].belt_velocity == 0.06
    assert small.beam["natural_frequencies_hz"] == [80.0, 510.0] and small.beam["masses_kg"] == [
        0.427,
        0.427,
    ]
    again = stickslip.Campaign(small.folder)
    assert_same(again, small_arrays)


def test_a_frame_gives_the_same(small_arrays):
    time, displacement, belt, load = small_arrays
    parts = [
        pandas.DataFrame({"t": t, "w": w, "v": v, "force": f, "of": f"part {k}"})
        for k, (t, w, v, f) in enumerate(zip(time, displacement, belt, load))
    ]
    columns = {"displacement": "w", "belt_velocity": "v", "normal_force": "force"}
    whole = stickslip.Campaign.from_dataframe(pandas.concat(parts), time="t", run="of", **columns)
    assert [run.name for run in whole.runs] == ["part_0", "part_1"]
    for run, t, w, v in zip(whole.runs, time, displacement, belt):
        np.testing.assert_array_equal(run.time, t)
        np.testing.assert_array_equal(run.displacement, w)
        np.testing.assert_array_equal(run.inputs["belt_velocity"], np.full(len(t), v))
    one = stickslip.Campaign.from_dataframe(
        parts[0].set_index("t"), displacement="w", belt_velocity=belt[0], normal_force=load[0]
    )
    assert_same(one, [[time[0]], [displacement[0]], [belt[0]], [load[0]]])


def test_csv_and_mat_files_give_the_same(small_arrays, tmp_path):
    time, displacement, belt, load = small_arrays
    csvs, mats = [], []
    for k, (t, w) in enumerate(zip(time, displacement)):
        csvs.append(tmp_path / f"r{k}.csv")
        pandas.DataFrame({"time_s": t, "laser_m": w}).to_csv(csvs[-1], index=False)
        mats.append(tmp_path / f"r{k}.mat")
        scipy.io.savemat(mats[-1], {"time_s": t, "laser_m": w})
    options = {"belt_velocity": belt, "normal_force": load, "beam": BEAM}
    assert_same(stickslip.Campaign.from_csv(csvs, **options), small_arrays)
    assert_same(stickslip.Campaign.from_mat(mats, **options), small_arrays)
    in_mm = stickslip.Campaign.from_csv(
        csvs[0], belt_velocity=belt[0], normal_force=load[0], scale=1e3
    )
    np.testing.assert_allclose(in_mm.runs[0].displacement, 1e3 * displacement[0], rtol=1e-14)


def test_what_can_t_be_used_is_refused_and_nothing_is_written(tmp_path):
    time = np.arange(100) * 1e-3
    good = {"belt_velocity": 0.1, "normal_force": 10.0}
    folder = tmp_path / "new"
    for displacement, options, said in [
        (np.zeros(99), good, "99 values for 100 times"),
        (np.full(100, np.nan), good, "leave missing samples out"),
        (np.zeros(100), {**good, "normal_force": -1.0}, "-1 N is negative"),
        (np.zeros((2, 50)), good, "one dimension"),
    ]:
        with pytest.raises(ValueError, match=said):
            stickslip.Campaign.from_arrays(time, displacement, folder=folder, **options)
    with pytest.raises(stickslip.BadInput, match="s comes after"):
        stickslip.Campaign.from_arrays(time[::-1], np.zeros(100), folder=folder, **good)
    with pytest.raises(ValueError, match="2 entries for 1 runs"):
        stickslip.Campaign.from_arrays(
            [time], [np.zeros(100)], belt_velocity=[0.1, 0.2], normal_force=1.0
        )
    assert not folder.exists()


def test_a_campaign_shows_itself(small):
    assert list(small.to_pandas()["run"]) == ["run01", "run02"]
    assert "run02" in small._repr_html_() and "2 runs" in repr(small)
    figure = small.plot("run02")
    np.testing.assert_array_equal(figure.data[0].y, small["run02"].displacement)


def test_check_finds_what_can_t_be_meant(demo, small_arrays):
    quality = stickslip.check(demo)
    assert quality.usable and len(quality.to_pandas()) == 4
    time, displacement, belt, load = small_arrays
    metres_for_millimetres = [1e3 * w for w in displacement]
    wrong = stickslip.Campaign.from_arrays(
        time, metres_for_millimetres, belt_velocity=belt, normal_force=load, beam=BEAM
    )
    quality = stickslip.check(wrong)
    assert not quality.usable and "remedy" in quality._repr_html_()
    with pytest.raises(stickslip.BadInput, match="can't be meant"):
        stickslip.compare(wrong)


def test_velocities_and_accelerations_come_back_and_are_compared(tmp_path):
    for quantity, unit, suffix, noise_std in [
        ("velocity", "m/s", "m_per_s", 1e-4),
        ("acceleration", "m/s^2", "m_per_s2", 0.2),
    ]:
        time, values = motion(0.06, 60.0, 2000, f"tip_{quantity}", noise_std)
        options = {"belt_velocity": 0.06, "normal_force": 60.0, "beam": BEAM}
        made = stickslip.Campaign.from_arrays(time, values, quantity=quantity, **options)
        assert (made.quantity, made.unit) == (quantity, unit)
        np.testing.assert_array_equal(made.runs[0].measured, values)
        with pytest.raises(AttributeError, match=f"holds a {quantity}"):
            _ = made.runs[0].displacement
        assert f"noise_{suffix}" in made.to_pandas()
        assert made.plot().layout.yaxis.title.text == f"tip {quantity} [{unit}]"
        frame = pandas.DataFrame({"t": time, "y": values})
        same = stickslip.Campaign.from_dataframe(frame, time="t", **{quantity: "y"}, **options)
        np.testing.assert_array_equal(same.runs[0].measured, values)
        file = tmp_path / f"{quantity}.csv"
        frame.rename(columns={"t": "time_s", "y": f"y [{unit}]"}).to_csv(file, index=False)
        read = stickslip.Campaign.from_csv(file, **{quantity: "y"}, **options)
        np.testing.assert_array_equal(read.runs[0].measured, values)
        found = stickslip.compare(made)
        run = found.runs[0]
        assert (run.quantity, run.unit) == (quantity, unit)
        assert run.model_velocity is None and np.nanstd(run.model_displacement) > 1e-5
        assert np.nanstd(run.residual) < 0.2 * np.std(values)
        assert f"measured_amplitude_{suffix}" in found.to_pandas()
    with pytest.raises(ValueError, match="quantity is 'strain'"):
        stickslip.Campaign.from_arrays(time, values, quantity="strain", **options)
    with pytest.raises(ValueError, match="2 of displacement, velocity and acceleration"):
        stickslip.Campaign.from_dataframe(frame, displacement="y", velocity="y", **options)
