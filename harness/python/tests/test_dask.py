"""Work on a LocalCluster gives the results of local runs, also when a worker is killed in the
middle."""

import contextlib
import json
import os
import shutil
import signal
import threading
import time

import pytest
from dask.distributed import Client, LocalCluster

import stickslip
import stickslip.dask


@pytest.fixture
def client():
    cluster = LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    )
    client = Client(cluster)
    yield client
    # On a busy machine worker processes may take longer to end than Dask waits; the results are
    # there already.
    with contextlib.suppress(TimeoutError):
        client.close()
        cluster.close()


def same_but_cost(data):
    """A diagnosis without what it cost, and without places and time."""
    return {key: value for key, value in data.items() if key not in ("counters", "provenance")}


def test_a_study_has_the_local_tables_also_when_a_worker_dies(client, tmp_path):
    options = {
        "from_": 0.096,
        "to": 0.112,
        "points": 33,
        "start": ["fixed", "up"],
        "settle": 2000,
        "cycles": 300,
    }
    local = stickslip.sweep("belt_velocity", output=tmp_path / "local", **options)
    remote, killed = tmp_path / "remote", []

    def kill_one():
        table = remote / "sweep.csv"
        while not (table.exists() and table.read_text().count("\n") > 3):
            time.sleep(0.01)
        os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
        killed.append(table.read_text().count("\n") - 1)

    killer = threading.Thread(target=kill_one, daemon=True)
    killer.start()
    found = stickslip.dask.sweep(client, "belt_velocity", output=remote, **options)
    killer.join(timeout=60)
    assert killed and killed[0] < 66, f"no worker was killed in the middle: {killed}"
    for name in ("sweep.csv", "section.csv"):
        assert (remote / name).read_bytes() == (tmp_path / "local" / name).read_bytes(), name
    rows = [
        tuple(line.split(",")[:2]) for line in (remote / "sweep.csv").read_text().splitlines()[1:]
    ]
    assert len(rows) == 66 == len(set(rows))
    assert found.data["rows"] == local.data["rows"]


def test_a_study_that_was_stopped_goes_on_on_a_cluster(client, tmp_path):
    options = {"values": [0.1, 0.101, 0.102, 0.103], "start": ["up"], "settle": 50, "cycles": 20}
    whole = stickslip.sweep("belt_velocity", output=tmp_path / "whole", **options)
    begun = tmp_path / "begun"
    stickslip.sweep("belt_velocity", output=begun, **options)
    # Two rows of the one chain are left, and their points and end states.
    for name, keep in (("sweep.csv", 3), ("states.csv", 3)):
        lines = (begun / name).read_text().splitlines(keepends=True)
        (begun / name).write_text("".join(lines[:keep]))
    found = stickslip.dask.sweep(client, "belt_velocity", output=begun, **options)
    assert found.data["rows"] == whole.data["rows"]
    for name in ("sweep.csv", "section.csv"):
        assert (begun / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_diagnoses_are_the_local_ones_also_when_a_worker_dies(client, small, tmp_path):
    local = stickslip.diagnose(small)
    begun = threading.Event()

    def kill_one():
        # Both workers are at it: the one that is killed has a diagnosis in work.
        while sum(len(keys) for keys in client.processing().values()) < 2:
            time.sleep(0.01)
        time.sleep(0.5)
        os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
        begun.set()

    killer = threading.Thread(target=kill_one, daemon=True)
    killer.start()
    found = stickslip.dask.diagnose(
        client, {"a": small, "b": small.folder}, output=tmp_path / "out"
    )
    assert begun.wait(60), "no worker was killed"
    assert list(found) == ["a", "b"]
    for name, diagnosis in found.items():
        assert same_but_cost(diagnosis.data) == same_but_cost(local.data)
        assert (
            diagnosis.fmu.exists()
            and diagnosis.folder == tmp_path / "out" / name
            and str(diagnosis) == str(local)
        )
    # What is there is not done again.
    again = stickslip.dask.diagnose(None, {"a": small, "b": small}, output=tmp_path / "out")
    assert again["b"].data == found["b"].data


def test_gains_by_chance_are_the_local_ones(client, small, tmp_path):
    local = stickslip.diagnose(small, null=2)
    found = stickslip.dask.null(client, small, 2, shares=2, output=tmp_path / "out")
    assert [len(gains) for gains in found.gains_by_chance] == [2] * len(local.gains_by_chance)
    assert found.gains_by_chance == local.gains_by_chance
    assert same_but_cost(found.data) == same_but_cost(local.data)
    assert not (tmp_path / "out" / "unfinished.fits").exists()


def test_a_blind_test_counts_the_same(client, small, tmp_path):
    folder = tmp_path / "blind"
    answers = [
        {"campaign": "001", "effects": ["viscous_friction"]},
        {"campaign": "002", "effects": []},
    ]
    for answer in answers:
        shutil.copytree(small.folder, folder / answer["campaign"])
    (folder / "truth.json").write_text(json.dumps(answers))
    local = stickslip.blind_test(folder, only=["001"])
    heard = []
    found = stickslip.dask.blind_test(
        client, folder, output=tmp_path / "out", progress=lambda *news: heard.append(news)
    )
    # The same data under two names and with two answers: the first is what was computed here.
    own = ("seconds", "processor_s", "provenance")
    answer = ("campaign", "hidden", "kind", "right", "outcome", "power")

    def without(case, *keys):
        return {key: value for key, value in case.items() if key not in keys}

    assert without(found.campaigns[0], *own) == without(local.campaigns[0], *own)
    assert without(found.campaigns[1], *own, *answer) == without(local.campaigns[0], *own, *answer)
    assert [case["campaign"] for case in found.campaigns] == ["001", "002"]
    assert "2 of 2 tasks" in [what for what, _ in heard]
    # What the workers found was taken over, not computed here: it names their folders.
    places = [case["provenance"]["inputs"][0]["file"] for case in found.campaigns]
    assert not any(str(folder) in place for place in places), places
    assert len(found.to_pandas()) == 2
