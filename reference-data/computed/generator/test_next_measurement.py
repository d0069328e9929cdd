"""Checks of the study of recommended runs: the run that is added, what the diagnosis gets to see, what is counted.

    python -m pytest test_next_measurement.py
"""

import json
import sys
import tomllib
from argparse import Namespace

import numpy as np
import pytest

from make_campaigns import draw_beam, draw_campaign, parser, replay, write_campaign
from next_measurement import add_run, draw_next, judge, main

EFFECTS = {
    "belt_periodic_friction": {"amplitude": 0.08, "wavelength": 0.022},
    "presliding_compliance": {"bristle_stiffness": 8e5, "bristle_damping": 60.0},
    "third_mode": {"frequency": 1400.0, "damping_ratio": 0.003},
    "static_friction_aging": {"gain": 0.15, "time_constant": 0.01, "form": "log"},
    "viscous_friction": {"coefficient": 0.3},
}
ARGS = Namespace(transients=1.0, offset=0.0, level_scatter=0.005, channel="displacement")


def campaign(folder, effect, runs=2):
    """A campaign in folder/001 with its truth beside it."""
    args = parser().parse_args(["--out", "unused", "--runs", str(runs), "--duration", "0.05"])
    rng = np.random.default_rng(5)
    truth, records = draw_campaign(rng, [effect], args, effects={effect: EFFECTS[effect]})
    write_campaign(folder / "001", "campaign 001", truth, records, rng)
    truth = json.loads(json.dumps({"campaign": "001", **truth}))
    (folder / "truth.json").write_text(json.dumps([truth]))
    return truth


@pytest.mark.parametrize("effect", EFFECTS)
def test_a_run_added_with_the_same_start_moves_as_the_original(effect):
    """The same random numbers after the same beam give the first run's start again: rig, law and effects are the true ones."""
    truth, records = draw_campaign(np.random.default_rng(5), [effect], parser().parse_args(
        ["--out", "unused", "--duration", "0.05", "--transients", "1"]), points=[(60, 0.06)], effects={effect: EFFECTS[effect]})
    rng = np.random.default_rng(5)
    assert draw_beam(rng).mass == truth["true_mass"]
    run, record = draw_next(rng, json.loads(json.dumps(truth)), (60, 0.06), Namespace(**vars(ARGS), duration=0.05))
    assert run == truth["runs"][0]
    assert np.array_equal(record.measured, records[0].measured)


@pytest.mark.parametrize("effect", EFFECTS)
def test_the_copy_has_one_run_more_and_no_truth(tmp_path, effect):
    truth = campaign(tmp_path, effect)
    (tmp_path / "001" / "truth.json").write_text("[]")
    run, record = add_run(tmp_path / "001", tmp_path / "copy", truth, (18.0, 0.009), np.random.default_rng(1), ARGS)
    assert sorted(p.name for p in (tmp_path / "copy").iterdir()) == ["campaign.toml", "run01.csv", "run02.csv", "run03.csv"]
    before, after = (tomllib.loads((tmp_path / name / "campaign.toml").read_text()) for name in ("001", "copy"))
    added = {"file": "run03.csv", "belt_velocity_m_per_s": 0.009, "normal_force_n": 18}
    assert after == {**before, "run": before["run"] + [added]}
    for file in ("run01.csv", "run02.csv"):
        assert (tmp_path / "copy" / file).read_bytes() == (tmp_path / "001" / file).read_bytes()
    data, old = (np.loadtxt(tmp_path / "copy" / f, delimiter=",", skiprows=1) for f in ("run03.csv", "run01.csv"))
    again = replay({**truth, "runs": truth["runs"] + [run]}, 2, duration=0.05)
    assert np.array_equal(again.measured, record.measured) and np.array_equal(data[:, 0], old[:, 0])
    assert (data[:, 1] - again.measured[:-1]).std() == pytest.approx(truth["noise_m"], rel=0.15)


def test_the_added_run_is_for_the_fit_where_roles_are_stated(tmp_path):
    truth = campaign(tmp_path, "viscous_friction")
    toml = tmp_path / "001" / "campaign.toml"
    toml.write_text(toml.read_text() + 'role = "holdout"\n')
    add_run(tmp_path / "001", tmp_path / "copy", truth, (60.0, 0.06), np.random.default_rng(1), ARGS)
    assert [r.get("role") for r in tomllib.loads((tmp_path / "copy" / "campaign.toml").read_text())["run"]] == [None, "holdout", "fit"]


def answer(verdict, *effects):
    return {"verdict": verdict, "effects": [{"id": name, "confounded_with": list(others)} for name, *others in effects]}


@pytest.mark.parametrize("after, expected, why", [
    (answer("effect_found", ["a"]), (True, True, True), ""),
    (answer("effect_found", ["b"]), (True, True, False), "wrong name"),
    (answer("effect_found", ["a", "c"]), (True, False, True), "now tied with c"),
    (answer("effect_found", ["b", "a"]), (False, False, False), "still tied with a"),
    (answer("effect_found", ["a", "b", "c"]), (False, False, False), "still tied with b"),
    (answer("effect_found", ["a"], ["c"]), (False, False, False), "2 effects named"),
    (answer("no_missing_effect"), (False, False, False), "no_missing_effect"),
    (answer("unknown_effect"), (False, False, False), "unknown_effect"),
])
def test_separated_means_one_name_and_none_of_the_ties_left(after, expected, why):
    found = judge({"effects": ["a"]}, answer("effect_found", ["b", "a"]), after)
    assert (found["separated"], found["alone"], found["right"]) == expected
    assert found["why"] == why


STAND_IN = """#!{python}
import json, sys, tomllib
from pathlib import Path
campaign, out = Path(sys.argv[2]), Path(sys.argv[4])
runs = tomllib.loads((campaign / "campaign.toml").read_text())["run"]
out.mkdir(parents=True, exist_ok=True)
with open({log!r}, "a") as log:
    print(len(runs), file=log)
tied = {{"verdict": "effect_found", "effects": [{{"id": "quadratic_drag", "confounded_with": ["viscous_friction"]}}],
        "next_measurement": {{"belt_velocity_m_per_s": 0.1, "normal_force_n": 60.0, "separation": 9.0}}}}
told = {{"verdict": "effect_found", "effects": [{{"id": "viscous_friction", "confounded_with": []}}]}}
(out / "diagnosis.json").write_text(json.dumps(tied if len(runs) == 2 else told))
"""


def test_the_study_counts_goes_on_after_a_failure_and_keeps_answers(tmp_path, capsys):
    truth = campaign(tmp_path, "viscous_friction")
    (tmp_path / "truth.json").write_text(json.dumps([{**truth, "campaign": "000"}, truth]))
    program, log = tmp_path / "stand_in", tmp_path / "log"
    program.write_text(STAND_IN.format(python=sys.executable, log=str(log)))
    program.chmod(0o755)
    for _ in range(2):
        main([str(tmp_path), "--out", str(tmp_path / "out"), "--stickslip", str(program)])
        found = json.loads((tmp_path / "out" / "next_measurement.json").read_text())
        assert found["totals"] == {"campaigns": 2, "failed": 1, "effect_found": 1, "ties_declared": 1, "recommended": 1, "separated": 1,
                                   "separated_alone": 1, "separated_and_right": 1}
        assert "FileNotFoundError" in found["campaigns"][0]["error"]
        assert "60 N, 0.1 m/s (9.0 times the noise): viscous_friction, separated" in capsys.readouterr().out
    assert log.read_text().split() == ["2", "3"]


def test_an_answer_of_a_program_that_failed_is_not_taken(tmp_path, capsys):
    campaign(tmp_path, "viscous_friction")
    program = tmp_path / "stand_in"
    program.write_text(STAND_IN.format(python=sys.executable, log=str(tmp_path / "log")) + "sys.exit('stopped')\n")
    program.chmod(0o755)
    for _ in range(2):
        main([str(tmp_path), "--out", str(tmp_path / "out"), "--stickslip", str(program)])
        assert "diagnosis failed (exit code 1): stopped" in capsys.readouterr().out
    assert not (tmp_path / "out" / "001" / "diagnosis.json").exists()


@pytest.mark.parametrize("missing, message", [("truth", "truth.json can't be read"), ("program", "no such program"), ("fmu", "no such file")])
def test_what_is_missing_is_said_in_one_line(tmp_path, missing, message):
    if missing != "truth":
        (tmp_path / "truth.json").write_text("[]")
    program = str(tmp_path / "none") if missing == "program" else sys.executable
    with pytest.raises(SystemExit) as e:
        main([str(tmp_path), "--out", str(tmp_path / "out"), "--stickslip", program, "--fmu", str(tmp_path / "none.fmu")])
    assert message in str(e.value) and "\n" not in str(e.value)
