"""The functions on data, and their results as objects."""

import math

import numpy as np
import plotly.graph_objects
import pytest
from conftest import BEAM, REPOSITORY, motion

import stickslip


def test_val_the_model_is_like_itself_and_unlike_the_demonstration(demo):
    time, displacement = motion(0.06, 60.0, samples=4000)
    itself = stickslip.Campaign.from_arrays(
        time, displacement, belt_velocity=0.06, normal_force=60.0, beam=BEAM
    )
    same = stickslip.compare(itself)
    assert same.worst.nrmse < 3 * same.worst.noise_floor < 0.02
    other = stickslip.compare(demo)
    assert [run.nrmse for run in other.runs] == sorted(
        (run.nrmse for run in other.runs), reverse=True
    )
    assert other.worst.nrmse > 0.1
    run = other["run03"]
    np.testing.assert_allclose(run.residual, run.measured - run.model, atol=1e-15)
    spread = np.std(run.measured)
    assert math.isclose(np.sqrt(np.mean(run.residual**2)) / spread, run.nrmse, rel_tol=0.2)
    assert run.sticks.dtype == bool and 0.1 < run.sticks.mean() < 0.4


def test_a_comparison_shows_itself_with_the_report_s_figures(demo, tmp_path):
    found = stickslip.compare(demo, output=tmp_path / "out")
    frame = found.to_pandas()
    assert list(frame["run"]) == [run.name for run in found.runs]
    assert "worst first" in str(found) and "\x1b" not in str(found)
    assert "<table>" in found._repr_html_() and found.worst.name in repr(found)
    page = found.report.read_text()
    assert page.count('<script type="application/json">') == len(found.figures) > 4
    figure = found.plot()
    assert isinstance(figure, plotly.graph_objects.Figure)
    assert [t.name for t in figure.data] == [t.get("name") for t in found.figures[0].data["data"]]
    assert found.plot("run02") != figure
    with pytest.raises(LookupError, match="no figure"):
        found.plot("no such caption")
    saved = found.save(tmp_path / "saved")
    assert (saved / "comparison.json").read_bytes() == (
        tmp_path / "out" / "comparison.json"
    ).read_bytes()
    assert found.data["provenance"]["command_line"].startswith("stickslip compare --fmu=")


def test_gates_and_the_files_of_temporary_results(demo):
    with pytest.raises(stickslip.GateFailed, match="run04"):
        stickslip.compare(demo, fail_above=0.1)
    found = stickslip.compare(demo, fail_above=1.0)
    folder = found.folder
    assert (folder / "report.html").exists()
    del found
    assert not folder.exists()


def test_an_effect_tried_by_hand_is_found_and_its_fmu_repairs(demo):
    tried = stickslip.try_effects(demo, "belt_periodic_friction")
    [effect] = tried.effects
    truth = {"amplitude": 0.08, "wavelength": 0.022}
    for name, value in truth.items():
        estimate = effect.parameters[name]
        assert abs(estimate.value - value) < 0.02 * value and estimate.std > 0, name
    ladder = tried.ladder()
    assert list(ladder["step"]) == ["as given", "calibrated", "+ belt_periodic_friction"]
    assert ladder["holdout_nrmse"].iloc[-1] < 0.01 < ladder["holdout_nrmse"].iloc[0]
    assert len(tried.figures) > 3 and "belt_periodic_friction" in str(tried)
    again = stickslip.compare(demo, fmu=tried.fmu)
    held = [run["nrmse_from_start_states"] for run in again.data["runs"]]
    assert max(held) < 0.01
    with pytest.raises(stickslip.BadInput, match="belt_periodic_friction"):
        stickslip.try_effects(demo, "belt_periodic_fricton")


def test_the_observer_sees_the_friction_that_the_model_has():
    # The FMU's own structure is that of BEAM.
    found = stickslip.simulate(
        belt_velocity=0.06,
        normal_force=60.0,
        duration=2.0,
        step=1e-4,
        variables=["tip_displacement", "friction_force"],
    )
    last = slice(-5000, None)
    noise = np.random.default_rng(1).normal(0, 1e-7, 5000)
    campaign = stickslip.Campaign.from_arrays(
        found.time[last],
        found["tip_displacement"][last] + noise,
        belt_velocity=0.06,
        normal_force=60.0,
        beam=BEAM,
    )
    seen = stickslip.observe(campaign.runs[0])
    error = seen.force - found["friction_force"][last]
    assert np.sqrt(np.mean(error**2)) < 0.1 * np.std(found["friction_force"])
    assert set(np.unique(seen.mode)) <= {-1, 0, 1} and len(seen.to_pandas()) == 5000
    assert len(seen.characteristic()) == len(seen.data["bins"]) > 3 and seen.report.exists()


def test_val_the_dimension_of_the_henon_map():
    # Grassberger and Procaccia, Physica D 9 (1983) 189: 1.21 +- 0.01 for a = 1.4, b = 0.3.
    series = np.empty(6000)
    x, y = 0.1, 0.1
    for k in range(len(series) + 100):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        if k >= 100:
            series[k - 100] = x
    heard = []
    found = stickslip.correlation_dimension(
        series, delay=1, surrogates=19, max_dimension=6, progress=lambda *news: heard.append(news)
    )
    np.testing.assert_array_equal(found.series, series)
    assert found.verdict == "dimension" and abs(found.dimension - 1.21) < 0.04, str(found)
    assert found.pairs.shape == (6, len(found.radii)) == found.local_slopes.shape and heard
    assert list(found.to_pandas().columns) == [f"m={m}" for m in range(1, 7)]


def test_a_study_has_its_table_and_its_section_points(tmp_path):
    options = {"values": [0.1, 0.16], "start": ["fixed", "up"], "settle": 50, "cycles": 40}
    found = stickslip.sweep(
        "belt_velocity", output=tmp_path / "s", settings={"normal_force": 41.0}, **options
    )
    table = found.to_pandas()
    assert list(table["belt_velocity"]) == [0.1, 0.1, 0.16, 0.16] and list(table["start"][:2]) == [
        "fixed",
        "up",
    ]
    assert len(found.section) == 4 and found.figures
    with pytest.raises(stickslip.BadInput, match="another sweep|other"):
        stickslip.sweep("belt_velocity", output=tmp_path / "s", **options)
    with pytest.raises(TypeError, match="'form' is no option"):
        stickslip.sweep("belt_velocity", form=0.1)


def test_the_catalogue_is_that_of_the_fmu():
    catalogue = stickslip.effects()
    assert len(catalogue) == 16 and catalogue["third_mode"].parameters[0].variable.startswith(
        "third_mode."
    )
    assert list(catalogue.to_pandas()["id"]) == sorted(e.id for e in catalogue)
    terms = REPOSITORY / "harness" / "src" / "diagnose" / "model" / "library"
    assert len(stickslip.effects(library=True)) == len(list(terms.glob("*.toml")))
    assert "third_mode" in catalogue._repr_html_() and "<pre>" in catalogue[0]._repr_html_()
