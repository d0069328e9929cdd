"""The study on a LocalCluster gives the local run's tables, also when a worker is killed in the middle.

    python test_stickslip_dask.py PATH_OF_STICKSLIP
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time

from dask.distributed import Client, LocalCluster

import stickslip_dask

OPTIONS = ["--parameter", "belt_velocity", "--from", "0.096", "--to", "0.112", "--points", "33",
           "--start", "fixed,up", "--settle", "2000", "--cycles", "300"]


def tables(folder):
    return {name: open(os.path.join(folder, name), "rb").read() for name in ("sweep.csv", "section.csv")}


def main():
    command = sys.argv[1]
    with tempfile.TemporaryDirectory() as scratch:
        fmu = os.path.join(scratch, "model.fmu")
        subprocess.run([command, "pack", "-o", fmu], check=True)
        local = os.path.join(scratch, "local")
        subprocess.run([command, "sweep", *OPTIONS, "--fmu", fmu, "-o", local], check=True, stdout=subprocess.DEVNULL)
        remote, killed = os.path.join(scratch, "remote"), []
        cluster = LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None)
        client = Client(cluster)

        def kill_one():
            table = os.path.join(remote, "sweep.csv")
            while not (os.path.exists(table) and open(table).read().count("\n") > 3):
                time.sleep(0.01)
            pid = next(iter(client.run(os.getpid).values()))
            os.kill(pid, signal.SIGKILL)
            killed.append(open(table).read().count("\n") - 1)

        killer = threading.Thread(target=kill_one, daemon=True)
        killer.start()
        stickslip_dask.sweep(client, [*OPTIONS, "-o", remote], command, fmu)
        killer.join(timeout=60)
        rows = 66
        assert killed and killed[0] < rows, f"no worker was killed in the middle: {killed}"
        found = tables(remote)
        for name, wanted in tables(local).items():
            assert found[name] == wanted, f"{name} differs"
        keys = [tuple(line.split(",")[:2]) for line in found["sweep.csv"].decode().splitlines()[1:]]
        assert len(keys) == rows == len(set(keys))
        print(f"same tables, {rows} rows; a worker was killed after {killed[0]} of them", flush=True)
        # On a busy machine worker processes may take longer to end than Dask waits; the result is there already.
        with contextlib.suppress(TimeoutError):
            client.close()
            cluster.close()


if __name__ == "__main__":
    main()
