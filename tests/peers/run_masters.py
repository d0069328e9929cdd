"""Runs an FMU in foreign masters and writes what they read as JSON.

usage: run_masters.py StickSlipBeam.fmu CASES.json RESULTS.json

CASES: [{"name": .., "stop": s, "step": s, "starts": {variable: value}}]
RESULTS: {case: {"fmpy": {"time": [..], variable: [..]}, "fmpy, model exchange": {..}, "libcosim": {..}, "ecos": {..},
"resumed": {..}}}
"resumed" is FMPy's low-level interface: half the run in one process, the state serialised, the rest
in another process.
"""
import base64
import json
import subprocess
import sys
import tempfile

OUTPUTS = [
    "tip_displacement", "tip_velocity", "tip_acceleration", "friction_force", "relative_velocity",
    "power_into_beam", "last_transition_time", "measured_displacement", "belt_travel", "dwell_time",
    "contact_mode", "transition_count",
]
INTEGERS = {"contact_mode", "transition_count"}
INTEGER_PARAMETERS = {"mode_count", "friction.law", "start.contact", "start.effects"}


def run_fmpy(fmu, case):
    import fmpy

    out = fmpy.simulate_fmu(
        fmu, validate=True, stop_time=case["stop"], output_interval=case["step"],
        start_values=case["starts"], output=OUTPUTS,
    )
    return {name: out[name].tolist() for name in out.dtype.names}


def run_model_exchange(fmu, case):
    """CVode, at the tightest tolerance that it takes; irregular motion forgets its start, so not too long."""
    import fmpy

    out = fmpy.simulate_fmu(
        fmu, fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-12, stop_time=min(case["stop"], 0.12),
        output_interval=case["step"], start_values=case["starts"], output=OUTPUTS, record_events=False,
    )
    return {name: out[name].tolist() for name in out.dtype.names}


def run_ecos(fmu, case):
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("beam", fmu)
        starts = {f"beam::{name}": int(value) if name in INTEGER_PARAMETERS else float(value)
                  for name, value in case["starts"].items()}
        structure.add_parameter_set("initialValues", starts)
        with EcosSimulation(structure=structure, step_size=case["step"]) as simulation:
            simulation.init(parameter_set="initialValues")
            # ecos knows no enumerations.
            out = {name: values for name, values in empty().items() if name != "contact_mode"}
            for k in range(round(case["stop"] / case["step"])):
                simulation.step()
                out["time"].append((k + 1) * case["step"])
                for name in out:
                    if name != "time":
                        read = simulation.get_integer if name in INTEGERS else simulation.get_real
                        out[name].append(read(f"beam::{name}"))
            simulation.terminate()
    return out


def open_fmpy(fmu):
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    description = fmpy.read_model_description(fmu)
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=fmpy.extract(fmu),
        modelIdentifier=description.coSimulation.modelIdentifier, instanceName="peer",
    )
    slave.instantiate()
    return slave, {v.name: v.valueReference for v in description.modelVariables}


def start(slave, references, case):
    slave.setupExperiment(tolerance=1e-9, startTime=0.0)
    for name, value in case["starts"].items():
        if name in INTEGER_PARAMETERS:
            slave.setInteger([references[name]], [int(value)])
        else:
            slave.setReal([references[name]], [value])
    slave.enterInitializationMode()
    slave.exitInitializationMode()


def steps(slave, references, case, first, last, out):
    for k in range(first, last):
        slave.doStep(k * case["step"], (k + 1) * case["step"] - k * case["step"])
        out["time"].append((k + 1) * case["step"])
        for name in OUTPUTS:
            read = slave.getInteger if name in INTEGERS else slave.getReal
            out[name].append(read([references[name]])[0])


def empty():
    return {name: [] for name in ["time", *OUTPUTS]}


def run_resumed(fmu, case):
    slave, references = open_fmpy(fmu)
    start(slave, references, case)
    out = empty()
    count = round(case["stop"] / case["step"])
    steps(slave, references, case, 0, count // 2, out)
    state = slave.getFMUState()
    data = slave.serializeFMUState(state)
    slave.freeFMUState(state)
    slave.terminate()
    slave.freeInstance()
    job = {"fmu": fmu, "case": case, "first": count // 2, "last": count,
           "state": base64.b64encode(bytes(data)).decode()}
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(job, file)
        file.flush()
        second = subprocess.run([sys.executable, __file__, "--resume", file.name],
                                check=True, stdout=subprocess.PIPE, text=True)
    for name, values in json.loads(second.stdout.splitlines()[-1]).items():
        out[name] += values
    return out


def resume(file):
    with open(file) as text:
        job = json.load(text)
    slave, references = open_fmpy(job["fmu"])
    state = slave.deSerializeFMUstate(base64.b64decode(job["state"]))
    slave.setFMUState(state)
    slave.freeFMUState(state)
    out = empty()
    steps(slave, references, job["case"], job["first"], job["last"], out)
    slave.terminate()
    slave.freeInstance()
    print(json.dumps(out))


def run_libcosim(fmu, case):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(case["step"] * 1e9))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="beam"))
    for name, value in case["starts"].items():
        reference = REFERENCES[name]
        if name in INTEGER_PARAMETERS:
            ok = execution.integer_initial_value(index, reference, int(value))
        else:
            ok = execution.real_initial_value(index, reference, value)
        assert ok, name
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    # libcosim knows no enumerations.
    out = {name: values for name, values in empty().items() if name != "contact_mode"}
    reals = [name for name in OUTPUTS if name not in INTEGERS]
    integers = ["transition_count"]
    for k in range(round(case["stop"] / case["step"])):
        assert execution.step(), k
        out["time"].append((k + 1) * case["step"])
        values = observer.last_real_values(index, [REFERENCES[n] for n in reals])
        for name, value in zip(reals, values):
            out[name].append(value)
        values = observer.last_integer_values(index, [REFERENCES[n] for n in integers])
        for name, value in zip(integers, values):
            out[name].append(value)
    return out


def main():
    global REFERENCES
    if sys.argv[1] == "--resume":
        return resume(sys.argv[2])
    import fmpy

    fmu, cases, results = sys.argv[1:]
    REFERENCES = {v.name: v.valueReference
                  for v in fmpy.read_model_description(fmu).modelVariables}
    with open(cases) as text:
        cases = json.load(text)
    done = {case["name"]: {"fmpy": run_fmpy(fmu, case), "fmpy, model exchange": run_model_exchange(fmu, case),
                           "libcosim": run_libcosim(fmu, case), "ecos": run_ecos(fmu, case),
                           "resumed": run_resumed(fmu, case)} for case in cases}
    with open(results, "w") as text:
        json.dump(done, text)


main()
