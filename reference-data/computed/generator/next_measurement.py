"""How often the run that the diagnosis recommends tells apart what it could not tell apart.

Every campaign of a folder made by make_campaigns.py is diagnosed. Where the answer names effects as indistinguishable (confounded_with)
and recommends an operating point (next_measurement), the true rig of truth.json is run there once more (a random start, a friction level
and noise of its own, as long as the other runs), the record joins a copy of the campaign, and the copy is diagnosed. The diagnosis
sees the campaigns only, never truth.json.

    python next_measurement.py FOLDER --out DIR [--stickslip PATH] [--fmu PATH] [--seed S]

separated: the verdict then names one effect (or as many as are hidden), and none of those that were tied is tied any more.
alone: and no other effect is tied with it instead. right: separated, and what is named are the effects hidden.

Units in next_measurement.json as in its names (m/s, N); separation: expected difference of the rivals over the noise (1). Answers in
DIR are kept: DIR/NAME/diagnosis.json of the campaign, DIR/NAME/seed_S of the copy and its answer; stopped, the same command goes on.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np

from make_campaigns import draw_run, parser as campaign_parser, true_rig, write_run

SAMPLE_INTERVAL = 1e-4  # s, of simulate()
TRIES = 20  # starts tried until the motion stays within the model's range


def diagnose(command, campaign, out):
    """The answer for a campaign's folder; one that lies in `out` already is taken. RuntimeError: why there is none, in one line.

    Files come to `out` only once the program has ended well, so that an answer stopped half-way is never taken for one."""
    answer, unfinished = out / "diagnosis.json", out / "unfinished"
    if not answer.exists():
        done = subprocess.run([command[0], "diagnose", str(campaign), "-o", str(unfinished), *command[1:]], capture_output=True, text=True)
        if done.returncode != 0 or not (unfinished / answer.name).exists():
            said = done.stderr.strip().splitlines() or ["no message"]
            raise RuntimeError(f"diagnosis failed (exit code {done.returncode}): {said[-1]}")
        for file in sorted(unfinished.iterdir(), key=lambda file: file.name == answer.name):
            os.replace(file, out / file.name)
        unfinished.rmdir()
    return json.loads(answer.read_text())


def named(answer):
    return [e["id"] for e in answer["effects"]]


def ties(answer):
    """Effects that the data can't tell from those named."""
    return sorted({other for e in answer["effects"] for other in e["confounded_with"]})


def draw_next(rng, truth, point, args):
    """(run, record) of the true rig at a point (N, m/s); a start, friction level and phases of its own."""
    for _ in range(TRIES):
        drawn = draw_run(rng, true_rig(truth), truth["parameters"], point, args)
        if drawn is not None:
            return drawn
    raise RuntimeError(f"the rig's motion at {point[0]:g} N, {point[1]:g} m/s leaves the model's range")


def duration(path):
    """Length of a run in s, from its CSV."""
    return (len(path.read_text().split()) - 1) * SAMPLE_INTERVAL


def add_run(campaign, copy, truth, point, rng, args):
    """Copies campaign.toml and the runs it names, and nothing else, and adds a run at a point (N, m/s). Returns (run, record)."""
    text = (campaign / "campaign.toml").read_text()
    runs = tomllib.loads(text)["run"]
    as_long = argparse.Namespace(**vars(args), duration=duration(campaign / runs[0]["file"]))
    run, record = draw_next(rng, truth, point, as_long)
    copy.mkdir(parents=True, exist_ok=True)
    for old in runs:
        shutil.copy(campaign / old["file"], copy / old["file"])
    lines = write_run(copy, f"run{len(runs) + 1:02d}.csv", run, record, truth["noise_m"], rng)
    if any("role" in old for old in runs):
        lines.append('role = "fit"')
    (copy / "campaign.toml").write_text(text + "\n".join(lines) + "\n")
    return run, record


def judge(truth, before, after):
    """What the added run has brought; `why` says in words why the tie is not separated, or the name not right."""
    tied = set(named(before)) | set(ties(before))
    now, left = named(after), ties(after)
    why = ""
    if after["verdict"] != "effect_found":
        why = after["verdict"]
    elif len(now) > max(1, len(truth["effects"])):
        why = f"{len(now)} effects named"
    elif tied & set(left):
        why = "still tied with " + ", ".join(sorted(tied & set(left)))
    separated = not why
    right = separated and set(now) == set(truth["effects"])
    if separated and left:
        why = "now tied with " + ", ".join(left)
    if separated and not right:
        why = "wrong name" + (", " + why if why else "")
    return {"named_after": now, "ties_after": left, "separated": separated, "alone": separated and not left, "right": right, "why": why}


def study(command, folder, out, truth, args):
    """One campaign: its answer and, where it has ties and a recommendation, what the recommended run has brought."""
    campaign, out = folder / truth["campaign"], out / truth["campaign"]
    before = diagnose(command, campaign, out)
    found = {"campaign": truth["campaign"], "hidden": truth["effects"], "verdict": before["verdict"], "named": named(before),
             "ties": ties(before)}
    point = before.get("next_measurement")
    if before["verdict"] != "effect_found" or not found["ties"] or not point:
        return found
    found["next_measurement"] = point
    again = out / f"seed_{args.seed}"
    if not (again / "diagnosis.json").exists():
        rng = np.random.default_rng([args.seed, *truth["campaign"].encode()])
        add_run(campaign, again / "campaign", truth, (point["normal_force_n"], point["belt_velocity_m_per_s"]), rng, args)
    return {**found, **judge(truth, before, diagnose(command, again / "campaign", again))}


def totals(rows):
    count = lambda key: sum(bool(row.get(key)) for row in rows)
    return {"campaigns": len(rows), "failed": count("error"), "effect_found": sum(r.get("verdict") == "effect_found" for r in rows),
            "ties_declared": count("ties"), "recommended": sum("separated" in r for r in rows), "separated": count("separated"),
            "separated_alone": count("alone"), "separated_and_right": count("right")}


def line(row):
    """A row of the table."""
    if "error" in row:
        return f"{row['campaign']:>8}  {row['error']}"
    answer = ", ".join(row["named"]) or row["verdict"]
    text = f"{row['campaign']:>8}  {', '.join(row['hidden']) or 'nothing'} -> {answer}"
    if row["ties"]:
        text += f" or {', '.join(row['ties'])}"
    if "separated" in row:
        p = row["next_measurement"]
        after = ", ".join(row["named_after"]) or "nothing"
        text += (f"; at {p['normal_force_n']:g} N, {p['belt_velocity_m_per_s']:g} m/s ({p['separation']:.1f} times the noise): {after}, "
                 + ("separated" if row["separated"] else "not separated") + (f" ({row['why']})" if row["why"] else ""))
    return text


def write_whole(path, text):
    """Beside the target first, then renamed."""
    beside = path.with_name(path.name + ".new")
    beside.write_text(text)
    os.replace(beside, path)


def parser():
    rig = campaign_parser()
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("folder", type=Path, help="made by make_campaigns.py, with truth.json")
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("--stickslip", default="stickslip", help="the program")
    p.add_argument("--fmu", help="FMU to diagnose; without it the program's own")
    p.add_argument("--seed", type=int, default=1, help="of the added runs")
    p.add_argument("--transients", type=float, default=rig.get_default("transients"), help="as in make_campaigns.py")
    p.add_argument("--offset", type=float, default=rig.get_default("offset"), help="as in make_campaigns.py, m")
    p.add_argument("--level-scatter", type=float, default=rig.get_default("level_scatter"), help="as in make_campaigns.py, 1")
    p.set_defaults(channel=rig.get_default("channel"))  # the folders are those of blind tests, which hold displacements
    return p


def main(argv=None):
    args = parser().parse_args(argv)
    try:
        answers = json.loads((args.folder / "truth.json").read_text())
    except (OSError, ValueError) as e:
        sys.exit(f"{args.folder / 'truth.json'} can't be read: {e}")
    program = shutil.which(args.stickslip)
    if program is None:
        sys.exit(f"{args.stickslip}: no such program")
    if args.fmu and not Path(args.fmu).is_file():
        sys.exit(f"{args.fmu}: no such file")
    command = [program] + (["--fmu", args.fmu] if args.fmu else [])
    args.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for truth in answers:
        try:
            rows.append(study(command, args.folder, args.out, truth, args))
        except (OSError, ValueError, KeyError, RuntimeError) as e:
            rows.append({"campaign": truth["campaign"], "error": str(e)})
        print(line(rows[-1]), flush=True)
        write_whole(args.out / "next_measurement.json", json.dumps({"totals": totals(rows), "campaigns": rows}, indent=1) + "\n")
    for key, value in totals(rows).items():
        print(f"{key.replace('_', ' '):>20}  {value}")


if __name__ == "__main__":
    main()
