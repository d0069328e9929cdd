"""Three peers of `stickslip diagnose` on the same campaigns, and the project's own row beside them.

    python -m venv target/diagnosis-venv
    target/diagnosis-venv/bin/pip install -r benches/peers/diagnosis/requirements.txt
    PYTHON=target/diagnosis-venv/bin/python
    $PYTHON reference-data/computed/generator/make_campaigns.py --kind single --count 6 --seed 4401 --out target/peers/single
    $PYTHON reference-data/computed/generator/make_campaigns.py --kind none   --count 2 --seed 4402 --out target/peers/none
    $PYTHON reference-data/computed/generator/make_campaigns.py --kind pair   --count 2 --seed 4403 --out target/peers/pair
    OMP_NUM_THREADS=1 $PYTHON benches/peers/diagnosis/run.py target/peers/single target/peers/none target/peers/pair \\
        --out target/peers/out --stickslip target/release/stickslip

A FOLDER holds campaigns of the generator and its truth.json, which is read to count alone. Results are kept one by one in OUT
(peers/FOLDER/CAMPAIGN/PEER.json, project/FOLDER/CAMPAIGN/blind-test.json); what is there is not run again. OUT/peers.json and OUT/peers.md hold all.

Named rightly: the effects named are exactly the hidden ones. Forecast: median NRMSE of one cycle, 20 ms at least, that starts in blocks
kept out of the fits (forecast.py), start states fitted to the forecast window as `diagnose` does with its shots. The project's figure is its
own held-out error, on shots of its own choice: alike in kind, not the same windows. Time: processor time, of the peers without forecasts.

What is set up how
    all     Modal frequencies, damping and mass as campaign.toml states them, the law's nominal constants, which the project's FMU has as start
            values. All integrate the very program that made the campaigns (simulate.py): favourable, no modelling error. States by a
            stick-aware Kalman smoother (smoother.py), not by differences of the signal: favourable. Its settings and the peers' rules were
            tuned while looking at campaigns of the seeds 4401 to 4403: favourable on those.
    sindy   Favourable: the library holds just the catalogue's terms, the law is among the nuisances, lines are found beforehand.
            Unfavourable: static_friction_aging, presliding_compliance, third_mode, belt_drive_compliance and sensor_lag have no term, so
            it can't name them; terms act on the smoothed force, which smears within three samples of a change of contact.
    bic     Favourable: every catalogue effect with its exact equation, lines of the slip force as starts, derivatives that know which
            knob belongs to which run, fits that grow along the window. Unfavourable: free simulation over 0.06 s, which stick-slip
            makes a rough landscape; a limit of processor time (--seconds), within which a second round may not end; BIC counts samples in a row
            that err alike one by one, so it tends to add effects.
    freeform  Names nothing: a ceiling of what states and force tell without a law. Favourable: learns place and time of each run. Unfavourable:
            place and time can't be carried over to other runs; kept-out blocks lie between the learned ones.
"""

import argparse
import json
import resource
import subprocess
import time
from pathlib import Path

import bic
import freeform
import numpy as np
import sindy
from campaign import load
from smoother import calibrate

PEERS = {
    "sindy": lambda rig, runs, levels, seconds: sindy.diagnose(rig, runs, levels),
    "bic": bic.diagnose,
    "freeform": lambda rig, runs, levels, seconds: freeform.diagnose(rig, runs, levels),
}
FORECASTS = {"sindy": sindy.forecast, "bic": bic.forecast, "freeform": freeform.forecast}
NAMES = {"sindy": "sparse regression (PySINDy)", "bic": "forward search by BIC", "freeform": "free-form force"}
FOR_FORECASTS = "model", "smoothed", "found"  # not written


def run_peer(peer, folder, seconds):
    """One peer on one campaign, as plain data."""
    rig, runs = load(folder)
    begun = time.process_time()
    found = PEERS[peer](rig, runs, calibrate(rig, runs), seconds)
    spent = time.process_time() - begun
    with np.errstate(all="ignore"):
        error = FORECASTS[peer](found, runs)
    kept = {k: v for k, v in found.items() if k not in FOR_FORECASTS}
    return {**kept, "forecast_nrmse": error, "seconds": spent}


def run_project(binary, folder, name, out):
    """`stickslip blind-test` on one campaign; its processor time is kept beside its result."""
    out.mkdir(parents=True, exist_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([binary.resolve(), "blind-test", folder, "--only", name, "-o", out], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    (out / "seconds.json").write_text(json.dumps(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) + "\n")


def project(out):
    """The project's own result in the form of a peer's, or None. Wall time where the processor time was not kept."""
    file = out / "blind-test.json"
    if not file.exists():
        return None
    case = json.loads(file.read_text())[0]
    seconds = json.loads((out / "seconds.json").read_text()) if (out / "seconds.json").exists() else case["seconds"]
    named = ["unknown"] if case["verdict"] == "unknown_effect" else sorted(case["named"])
    return {"named": named, "right": case["right"], "forecast_nrmse": case["holdout_nrmse"][1], "seconds": seconds}


def results(args):
    """[{folder, campaign, hidden, peer: result}], computed as far as they are not there."""
    out = []
    for folder in args.folders:
        for answer in json.loads((folder / "truth.json").read_text()):
            name = answer["campaign"]
            row = {"folder": folder.name, "campaign": name, "hidden": sorted(answer["effects"])}
            for peer in args.peers:
                file = args.out / "peers" / folder.name / name / f"{peer}.json"
                if not file.exists() and args.tabulate:
                    continue
                if not file.exists():
                    file.parent.mkdir(parents=True, exist_ok=True)
                    file.write_text(json.dumps(run_peer(peer, folder / name, args.seconds), indent=1) + "\n")
                row[peer] = json.loads(file.read_text())
                if row[peer].get("named") is not None:
                    row[peer]["right"] = row[peer]["named"] == row["hidden"]
                print(folder.name, name, peer, row[peer], flush=True)
            place = args.out / "project" / folder.name / name
            if args.stickslip and not args.tabulate and not (place / "blind-test.json").exists():
                run_project(args.stickslip, folder, name, place)
            row["project"] = project(place)
            out.append(row)
    return out


def cell(result):
    if result is None:
        return "-"
    error = result["forecast_nrmse"]
    shown = "-" if error is None else f"{100 * error:.2g} %"
    names = "" if result.get("named") is None else ("right" if result["right"] else "wrong") + f": {' + '.join(result['named']) or 'none'}; "
    return f"{names}{shown}; {result['seconds']:.0f} s"


def summary(rows, key):
    """Right of how many, median forecast error and time."""
    found = [r[key] for r in rows if r.get(key)]
    if not found:
        return "| - | - | - |"
    judged = [f["right"] for f in found if f.get("named") is not None]
    errors = [f["forecast_nrmse"] for f in found if f["forecast_nrmse"] is not None]
    right = f"{sum(judged)} of {len(judged)}" if judged else "names nothing"
    median = f"{100 * np.median(errors):.2g} %" if errors else "-"
    return f"| {right} | {median} | {np.median([f['seconds'] for f in found]):.0f} s |"


def table(rows, peers):
    keys = [*peers, "project"]
    titles = {**NAMES, "project": "`stickslip diagnose`"}
    lines = ["| | named rightly | one-cycle forecast error, median | time, median |", "|---|---|---|---|"]
    lines += [f"| {titles[k]} {summary(rows, k)}" for k in keys]
    lines += ["", "| campaign | hidden | " + " | ".join(titles[k] for k in keys) + " |", "|---" * (2 + len(keys)) + "|"]
    for row in rows:
        cells = " | ".join(cell(row.get(k)) for k in keys)
        lines.append(f"| {row['folder']} {row['campaign']} | {' + '.join(row['hidden']) or 'none'} | {cells} |")
    return "\n".join(lines) + "\n"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("folders", type=Path, nargs="+", metavar="FOLDER")
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("--peers", nargs="+", choices=list(PEERS), default=list(PEERS))
    p.add_argument("--seconds", type=float, default=300.0, help="of processor time that the search by BIC may take for a campaign")
    p.add_argument("--stickslip", type=Path, help="binary of the project; without it only results that are there are read")
    p.add_argument("--tabulate", action="store_true", help="run nothing, tabulate what is there")
    args = p.parse_args()
    rows = results(args)
    text = table(rows, args.peers)
    (args.out / "peers.json").write_text(json.dumps(rows, indent=1) + "\n")
    (args.out / "peers.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
