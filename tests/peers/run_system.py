"""Runs belt_drive.ssp, beam and drive coupled both ways, in foreign masters, and writes what they read as JSON.

usage: run_system.py belt_drive.ssp JOBS.json RESULTS.json

JOBS: [{"master": "fmpy" | "fmpy, input derivatives" | "fmpy, SSP" | "libcosim" | "ecos", "step": s, "stop": s,
"every": s, "starts": {component: {variable: value}}}]; "starts" (fmpy only) overrides the parameter sets.
RESULTS: for each job {"time": [..], "tip_displacement": [..], "belt_velocity": [..]}, one row every "every" s.

All masters are of Jacobi's kind: both models do a step with the inputs of its begin, then outputs are exchanged.
"""
import json
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
COMPONENTS = {"beam": "StickSlipBeam.fmu", "drive": "BeltDrive.fmu"}
# (from component, variable, to component, variable), as in SystemStructure.ssd.
CONNECTIONS = [("drive", "belt_velocity", "beam", "belt_velocity"),
               ("beam", "friction_force", "drive", "friction_force")]
READ = [("beam", "tip_displacement"), ("drive", "belt_velocity")]


def parameters(folder, component):
    tree = ElementTree.parse(Path(folder) / "resources" / f"{component}.ssv")
    return {p.get("name"): float(p[0].get("value")) for p in tree.iter(f"{SSV}Parameter")}


class Component:
    """An FMU through FMPy's low-level interface."""

    def __init__(self, fmu, name, starts):
        import fmpy
        from fmpy.fmi2 import FMU2Slave

        description = fmpy.read_model_description(fmu)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(fmu),
                               modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        for variable, value in starts.items():
            self.set(variable, value)
        self.slave.enterInitializationMode()

    def get(self, variable):
        return self.slave.getReal([self.references[variable]])[0]

    def set(self, variable, value):
        self.slave.setReal([self.references[variable]], [value])

    def rate(self, variable):
        from ctypes import c_double, c_int, c_uint

        value = c_double()
        self.slave.fmi2GetRealOutputDerivatives(
            self.slave.component, (c_uint * 1)(self.references[variable]), 1, (c_int * 1)(1), (c_double * 1).from_buffer(value))
        return value.value

    def set_rate(self, variable, value):
        from ctypes import c_double, c_int, c_uint

        self.slave.fmi2SetRealInputDerivatives(
            self.slave.component, (c_uint * 1)(self.references[variable]), 1, (c_int * 1)(1), (c_double * 1)(value))


def rows(job):
    """Number of steps, and after how many of them a row is due."""
    return round(job["stop"] / job["step"]), round(job["every"] / job["step"])


def empty():
    return {"time": [], **{variable: [] for _, variable in READ}}


def run_fmpy(ssp, folder, job, derivatives):
    starts = job.get("starts", {})
    parts = {name: Component(str(Path(folder) / "resources" / file), name,
                             {**parameters(folder, name), **starts.get(name, {})})
             for name, file in COMPONENTS.items()}

    def exchange(rates):
        values = [(parts[to], into, parts[of].get(out), parts[of].rate(out) if rates else None)
                  for of, out, to, into in CONNECTIONS]
        for part, variable, value, rate in values:
            part.set(variable, value)
            if rates:
                part.set_rate(variable, rate)

    # The belt's velocity does not depend on the force at once: two passes settle the start.
    exchange(False)
    exchange(False)
    for part in parts.values():
        part.slave.exitInitializationMode()
    out = empty()
    count, every = rows(job)
    for k in range(count):
        exchange(derivatives)
        for part in parts.values():
            part.slave.doStep(k * job["step"], job["step"])
        if (k + 1) % every == 0:
            out["time"].append((k + 1) * job["step"])
            for name, variable in READ:
                out[variable].append(parts[name].get(variable))
    for part in parts.values():
        part.slave.terminate()
        part.slave.freeInstance()
    return out


def run_fmpy_ssp(ssp, folder, job):
    """FMPy's own SSP loop. It takes parameters from outside only, begins with inputs of 0, and writes the results of a
    step's end beside the time of its begin."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import Parameter, ParameterSet

    values = [Parameter(name=f"{component}.{name}", type="Real", value=value)
              for component in COMPONENTS for name, value in parameters(folder, component).items()]
    # Half a step less, as its loop goes by a sum of steps.
    result = simulate_ssp(ssp, stop_time=job["stop"] - 0.5 * job["step"], step_size=job["step"],
                          parameter_set=ParameterSet(name="system", parameters=values))
    out = empty()
    count, every = rows(job)
    for k in range(every, count + 1, every):
        out["time"].append(k * job["step"])
        for name, variable in READ:
            out[variable].append(float(result[f"{name}.{variable}"][k - 1]))
    return out


def run_libcosim(ssp, folder, job):
    import fmpy
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(ssp_path=ssp, step_size=round(job["step"] * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    references = {}
    for name, file in COMPONENTS.items():
        description = fmpy.read_model_description(str(Path(folder) / "resources" / file))
        references[name] = {v.name: v.valueReference for v in description.modelVariables}
    out = empty()
    count, every = rows(job)
    for k in range(count):
        assert execution.step(), k
        if (k + 1) % every == 0:
            out["time"].append((k + 1) * job["step"])
            for name, variable in READ:
                index = execution.slave_index_from_instance_name(name)
                out[variable].append(observer.last_real_values(index, [references[name][variable]])[0])
    return out


def run_ecos(ssp, folder, job):
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=ssp, step_size=job["step"]) as simulation:
        simulation.init(parameter_set="initialValues")
        out = empty()
        count, every = rows(job)
        for k in range(count):
            simulation.step()
            if (k + 1) % every == 0:
                out["time"].append((k + 1) * job["step"])
                for name, variable in READ:
                    out[variable].append(simulation.get_real(f"{name}::{variable}"))
        simulation.terminate()
    return out


MASTERS = {
    "fmpy": lambda *a: run_fmpy(*a, derivatives=False),
    "fmpy, input derivatives": lambda *a: run_fmpy(*a, derivatives=True),
    "fmpy, SSP": run_fmpy_ssp,
    "libcosim": run_libcosim,
    "ecos": run_ecos,
}


def main():
    ssp, jobs, results = sys.argv[1:]
    with open(jobs) as text:
        jobs = json.load(text)
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(ssp).extractall(folder)
        done = [MASTERS[job["master"]](ssp, folder, job) for job in jobs]
    with open(results, "w") as text:
        json.dump(done, text)


main()
