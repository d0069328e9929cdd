"""The study on a LocalCluster gives the local run's tables, also when a worker is killed in the middle.

    python test_stickslip_dask.py PATH_OF_STICKSLIP
"""

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
           "--start", "fixed,up", "--settle", "300", "--cycles", "300"]


def tables(folder):
    return {name: open(os.path.join(folder, name), "rb").read() for name in ("sweep.csv", "section.csv")}


def main():
    command = sys.argv[1]
    with tempfile.TemporaryDirectory() as scratch:
        fmu = os.path.join(scratch, "model.fmu")
        subprocess.run([command, "pack", "-o", fmu], check=True)
        local = os.path.join(scratch, "local")
        subprocess.run([command, "sweep", *OPTIONS, "--fmu", fmu, "-o", local], check=True, stdout=subprocess.DEVNULL)
        with LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster) as client:
            remote = os.path.join(scratch, "remote")
            killed = []

            def kill_one():
                table = os.path.join(remote, "sweep.csv")
                while not (os.path.exists(table) and open(table).read().count("\n") > 3):
                    time.sleep(0.01)
                pid = next(iter(client.run(os.getpid).values()))
                os.kill(pid, signal.SIGKILL)
                killed.append(open(table).read().count("\n") - 1)

            killer = threading.Thread(target=kill_one)
            killer.start()
            stickslip_dask.sweep(client, [*OPTIONS, "-o", remote], command, fmu)
            killer.join()
        rows = 66
        assert killed and killed[0] < rows, f"no worker was killed in the middle: {killed}"
        for name, wanted in tables(local).items():
            found = tables(remote)[name]
            assert found == wanted, f"{name} differs"
        keys = [line.split(",")[:2] for line in tables(remote)["sweep.csv"].decode().splitlines()[1:]]
        assert len(keys) == rows == len({tuple(k) for k in keys})
        print(f"same tables, {rows} rows; a worker was killed after {killed[0]} of them")


if __name__ == "__main__":
    main()
