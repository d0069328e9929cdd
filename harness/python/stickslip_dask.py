"""`stickslip sweep` on a Dask cluster; the FMU is the unit of work.

    python stickslip_dask.py --scheduler tcp://HOST:8786 -- --parameter belt_velocity --from 0.096 --to 0.112 --points 17 -o DIR

Options behind `--` are those of `stickslip sweep`. The command prepares the folder and lists the points; workers evaluate
them in the .fmu (through FMPy; they need this file's requirements, not `stickslip`), and the command draws the pictures in
the end. Each chain of points is one task, keyed by the study and its number: Dask repeats it elsewhere if its worker
dies. Results are appended here, as the local run does, in this process alone, so nothing is doubled; a stopped
study goes on with the same command line. The tables are those of the local run to the last digit.
"""

import argparse
import ctypes
import csv
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile

STATUS = ["ok", "settling", "dies_out", "rest", "no_section", "unresolved"]
MAX_STATES = 24
HEAD = 11 + MAX_STATES


def number(value):
    """A number as Rust writes it: the shortest digits that read back the same, without exponent."""
    import numpy

    if value != value:
        return ""
    if value in (float("inf"), float("-inf")):
        return "inf" if value > 0 else "-inf"
    return numpy.format_float_positional(value, unique=True, trim="-")


class Fmu:
    """An unzipped FMU with one instance."""

    def __init__(self, content):
        import fmpy
        from fmpy.fmi2 import FMU2Slave

        self.folder = tempfile.mkdtemp(prefix="stickslip-")
        path = os.path.join(self.folder, "model.fmu")
        with open(path, "wb") as file:
            file.write(content)
        unzipped = fmpy.extract(path, os.path.join(self.folder, "fmu"))
        description = fmpy.read_model_description(unzipped)
        self.variables = {v.name: v for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=unzipped,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="sweep",
        )
        self.slave.instantiate()
        self.function = self.slave.dll.stickslipEvaluate
        doubles = ctypes.POINTER(ctypes.c_double)
        self.function.argtypes = [ctypes.c_void_p, doubles, ctypes.c_size_t, doubles, ctypes.c_size_t,
                                  ctypes.POINTER(ctypes.c_size_t), ctypes.c_char_p, ctypes.c_size_t]
        self.function.restype = ctypes.c_int

    def close(self):
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)

    def set(self, values):
        for name, value in values.items():
            variable = self.variables[name]
            if variable.type == "Real":
                self.slave.setReal([variable.valueReference], [value])
            else:
                self.slave.setInteger([variable.valueReference], [int(value)])

    def evaluate(self, request):
        """The answer's numbers, or a reason."""
        capacity = 4096
        while True:
            numbers = (ctypes.c_double * len(request))(*request)
            answers, written = (ctypes.c_double * capacity)(), ctypes.c_size_t()
            reason = ctypes.create_string_buffer(2000)
            status = self.function(self.slave.component, numbers, len(request), answers, capacity, ctypes.byref(written), reason, 2000)
            if status != 0:
                raise RuntimeError(f"stickslipEvaluate returned {status}")
            if written.value == 0:
                return reason.value.decode()
            if written.value <= capacity:
                return list(answers[: written.value])
            capacity = written.value


_LOADED = {}


def evaluate_chain(content, guid, plan, chain, carried):
    """Runs on a worker: the lines of sweep.csv, section.csv and states.csv of each point of a chain."""
    # One copy of the FMU per worker process and study.
    if guid not in _LOADED:
        _LOADED[guid] = Fmu(content)
    fmu, rule, out = _LOADED[guid], plan["rule"], []
    for task in chain:
        fmu.slave.reset()
        fmu.set(plan["set"])
        fmu.set(task["set"])
        head = [rule["settle"], rule["cycles"], rule["patience"], rule["section"], rule["strobe_period"]]
        found = fmu.evaluate(head + task["start"] + [float(plan["start_is_given"])] + (carried or [0.0]))
        out.append(lines(task, found))
        if not isinstance(found, str) and found[7] == 1.0:
            carried = [1.0] + found[8:HEAD]
    return out


def lines(task, found):
    """What one point adds to the three files."""
    key = task["key"]
    record = io.StringIO()
    writer = csv.writer(record, lineterminator="\n")
    if isinstance(found, str):
        writer.writerow(key.split(",") + ["", "", "", "", "", f"failed: {found}"])
        return {"id": task["id"], "table": record.getvalue(), "section": "", "states": ""}
    status = STATUS[int(found[0])]
    period = "" if found[1] < 0 else str(int(found[1]))
    exponent = "" if status == "rest" else number(found[5])
    writer.writerow(key.split(",") + [period, number(found[2]), number(found[3]), number(found[4]), exponent, status])
    points = [found[i : i + 3] for i in range(HEAD, len(found), 3)]
    section = "".join(f"{key},{k},{number(t)},{number(w)},{number(v)}\n" for k, (t, w, v) in enumerate(points))
    states = ""
    if found[7] == 1.0:
        modes, dimension = int(found[8]), int(found[9])
        state = " ".join(number(x) for x in found[11 : 11 + dimension])
        states = f"{task['id']},{modes},{dimension},{number(found[10])},{state}\n"
    return {"id": task["id"], "table": record.getvalue(), "section": section, "states": states}


def done_keys(folder, keys):
    """Keys of the rows that are there, and the states carried from them."""
    with open(os.path.join(folder, "sweep.csv"), newline="") as file:
        rows = list(csv.reader(file))[1:]
    done = {",".join(row[:keys]) for row in rows if row}
    carried = {}
    with open(os.path.join(folder, "states.csv")) as file:
        for line in file.read().splitlines()[1:]:
            number_, modes, dimension, travel, state = line.split(",")
            values = [float(x) for x in state.split()]
            carried[int(number_)] = [1.0, float(modes), float(dimension), float(travel)] + values + [0.0] * (MAX_STATES - len(values))
    return done, carried


def sweep(client, options, command="stickslip", fmu=None):
    """Runs the study `options` (a list, as for `stickslip sweep`) on a Dask client; returns the folder."""
    from dask.distributed import as_completed

    with tempfile.TemporaryDirectory() as scratch:
        if fmu is None:
            fmu = os.path.join(scratch, "StickSlipBeam.fmu")
            subprocess.run([command, "pack", "-o", fmu], check=True, stdout=subprocess.DEVNULL)
        with open(fmu, "rb") as file:
            content = file.read()
        options = list(options) + ["--fmu", fmu]
        plan = json.loads(subprocess.run([command, "sweep", *options, "--plan"], check=True, capture_output=True, text=True).stdout)
        folder = plan["folder"]
        done, carried = done_keys(folder, plan["keys"])
        shared = client.scatter(content, broadcast=True, hash=True)
        futures = []
        small = {key: plan[key] for key in ("set", "start_is_given", "rule")}
        for chain in plan["chains"]:
            before = None
            for task in chain:
                if task["key"] in done:
                    before = carried.get(task["id"], before)
                else:
                    break
            rest = [task for task in chain if task["key"] not in done]
            if rest:
                name = f"stickslip-{plan['fmu_guid']}-{rest[0]['id']}-{rest[-1]['id']}"
                futures.append(client.submit(evaluate_chain, shared, plan["fmu_guid"], small, rest, before, key=name, retries=3, pure=False))
        names = ["section", "states", "table"]
        files = dict(zip(names, (open(os.path.join(folder, n), "a", newline="") for n in ("section.csv", "states.csv", "sweep.csv"))))
        written = set()
        try:
            for future in as_completed(futures):
                for part in future.result():
                    if part["id"] in written:
                        continue
                    written.add(part["id"])
                    # The table's line comes last: it says that the others are there.
                    for name in names:
                        files[name].write(part[name])
                        files[name].flush()
                future.release()
        finally:
            for file in files.values():
                file.close()
        # Nothing is left to compute: sorts the tables, draws and prints.
        subprocess.run([command, "sweep", *options], check=True)
    return folder


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scheduler", help="address of a Dask scheduler; without one a LocalCluster is started")
    parser.add_argument("--workers", type=int, default=None, help="processes of the LocalCluster")
    parser.add_argument("--command", default="stickslip", help="path of the program stickslip")
    parser.add_argument("--fmu", help="FMU to study [default: the program's own]")
    parser.add_argument("options", nargs=argparse.REMAINDER, help="-- and the options of `stickslip sweep`")
    arguments = parser.parse_args()
    from dask.distributed import Client, LocalCluster

    options = [o for i, o in enumerate(arguments.options) if not (i == 0 and o == "--")]
    if arguments.scheduler:
        client = Client(arguments.scheduler)
    else:
        client = Client(LocalCluster(n_workers=arguments.workers, threads_per_worker=1, processes=True))
    with client:
        sweep(client, options, arguments.command, arguments.fmu)


if __name__ == "__main__":
    sys.exit(main())
