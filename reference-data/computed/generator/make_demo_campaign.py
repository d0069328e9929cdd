"""The demonstration campaign in reference-data/demo: four short runs that hide a periodic variation of friction along the belt.

    python make_demo_campaign.py        writes campaign.toml, run01.csv .. run04.csv, truth.json and meta.toml
"""

import json
from pathlib import Path

import numpy as np

from make_campaigns import draw_campaign, parser, write_campaign
from meta import write_meta

DEMO = Path(__file__).resolve().parents[2] / "demo"
SEED = 1992
DURATION = 0.48  # s
POINTS = [(36, 0.04), (60, 0.06), (80, 0.1), (120, 0.12)]  # N, m/s
EFFECTS = {"belt_periodic_friction": {"amplitude": 0.08, "wavelength": 0.022}}


def main(folder=DEMO):
    rng = np.random.default_rng(SEED)
    args = parser().parse_args(["--out", str(folder), "--noise", "5e-7", "--duration", str(DURATION), "--transients", "0"])
    truth, records = draw_campaign(rng, list(EFFECTS), args, POINTS, EFFECTS)
    write_campaign(folder, "demonstration", truth, records, rng)
    (folder / "truth.json").write_text(json.dumps([{"campaign": "demo", **truth}], indent=1) + "\n")
    write_meta(
        folder,
        title="Demonstration campaign with a hidden belt effect",
        source="computed: generator/make_demo_campaign.py; model of Stelter 1992, eqs. 1-7, and belt_periodic_friction",
        role="demonstration: the diagnosis is shown on it; truth.json holds the answer and must not be read by the diagnosis",
        consumers=["reference-data/computed/generator/test_generator.py"],
        channels=[
            ("time_s", "s", "from the first sample of the run"),
            ("tip_displacement_m", "m", "positive along the belt's motion; white noise of 0.5 micrometres, display steps of 2.5 nm"),
        ],
    )


if __name__ == "__main__":
    main()
