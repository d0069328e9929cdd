"""Long work on a Dask cluster, with the results of local runs to the last digit.

    from dask.distributed import Client
    import stickslip.dask

    client = Client("tcp://HOST:8786")
    study = stickslip.dask.sweep(client, "belt_velocity", values=[0.1, 0.12], output="study")
    diagnoses = stickslip.dask.diagnose(client, ["rig_a", "rig_b"], output="diagnoses")

Workers need this package, of the same version, and no common file system: a task carries its files,
and returns those that it wrote. Each task is one chain of points, one campaign or one share of the
simulated campaigns. Dask repeats it elsewhere where its worker dies. This process alone writes
results, each once, so that nothing is lost or doubled; what is finished in `output` is not done
again.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from stickslip import _native
from stickslip._progress import Progress, Told
from stickslip._result import Folder
from stickslip._words import FMU, Path
from stickslip.blind import PROGRAM, BlindTest, blind_words
from stickslip.blind import blind_test as _blind_test
from stickslip.campaign import Campaign, folder_of
from stickslip.diagnosis import Diagnosis, diagnose_words
from stickslip.study import Study, StudyOptions, study_words

if TYPE_CHECKING:
    from typing_extensions import Unpack

Client = Any
"""dask.distributed.Client, which has no types."""

Files = dict[str, bytes]
"""Names within a folder, with contents."""

RETRIES = 3
"""How often Dask repeats a task that fails otherwise than by the death of its worker."""


def sweep(
    client: Client,
    parameter: str,
    *,
    output: Path | None = None,
    progress: Progress = None,
    **options: Unpack[StudyOptions],
) -> Study:
    """As `stickslip.sweep`, each chain of points on one worker."""
    folder = Folder(output)
    line = study_words(parameter, folder.path, options)
    plan = json.loads(_native.plan(line))
    done = _done(folder.path, plan["keys"])
    chains = [
        (k, chain)
        for k, chain in enumerate(plan["chains"])
        if any(task["key"] not in done for task in chain)
    ]
    # Chains that are begun go on from what is there.
    begun = _read(folder.path, STUDY) if done else {}
    fmu = _given_fmu(options.get("fmu"))
    jobs = [
        (k, study_words(parameter, "study", {**options, "fmu": "model.fmu"}), begun)
        for k, _ in chains
    ]
    written = {row: True for row in done}
    with Told(progress) as tell:
        for _, files in _results(client, _chain, fmu, jobs, tell):
            _append(folder.path, files, plan["keys"], written)
        # Nothing is left to compute: this sorts the tables and draws.
        return Study(_native.perform(line, tell), folder)


STUDY = ["sweep.json", "section.csv", "states.csv", "sweep.csv"]
"""Files of a study in the order in which they are written: a row counts as done by its line in
sweep.csv."""


def _chain(fmu: bytes, job: tuple[int, list[str], Files]) -> Files:
    """On a worker: the files of a study of which one chain is computed."""
    number, line, begun = job
    with _room({"model.fmu": fmu, **_below("study", begun)}) as room:
        _native.sweep_chain(_inside(room, line, "study", "model.fmu"), number)
        return _read(room / "study", STUDY)


def _done(folder: FilePath, keys: int) -> set[str]:
    """Keys of the rows that are there."""
    lines = (folder / "sweep.csv").read_text(encoding="utf-8").splitlines()[1:]
    return {_key(line, keys) for line in lines}


def _key(line: str, keys: int) -> str:
    return ",".join(line.split(",")[:keys])


def _append(folder: FilePath, files: Files, keys: int, written: dict[str, bool]) -> None:
    """Adds the rows of a chain that are not there yet; their lines in sweep.csv come last."""
    tables = {name: files[name].decode().splitlines(keepends=True)[1:] for name in STUDY[1:]}
    rows = [line for line in tables["sweep.csv"] if _key(line, keys) not in written]
    new = {_key(line, keys) for line in rows}
    numbers = {line.split(",")[0] for line in tables["states.csv"]} - _numbers(folder)
    tables["sweep.csv"] = rows
    tables["section.csv"] = [line for line in tables["section.csv"] if _key(line, keys) in new]
    tables["states.csv"] = [line for line in tables["states.csv"] if line.split(",")[0] in numbers]
    for name in STUDY[1:]:
        with open(folder / name, "a", encoding="utf-8", newline="") as file:
            file.writelines(tables[name])
    written.update(dict.fromkeys(new, True))


def _numbers(folder: FilePath) -> set[str]:
    """Numbers of the points whose end states are there."""
    lines = (folder / "states.csv").read_text(encoding="utf-8").splitlines()[1:]
    return {line.split(",")[0] for line in lines}


def diagnose(
    client: Client,
    campaigns: Mapping[str, Campaign | Path] | Iterable[Campaign | Path],
    *,
    output: Path | None = None,
    fmu: Path | None = None,
    hold_out: str | None = None,
    library: Path | None = None,
    force: bool = False,
    progress: Progress = None,
) -> dict[str, Diagnosis]:
    """Diagnoses many campaigns, each on one worker; results by the names of the mapping, or by
    those of the folders. Each has a folder of its own name in `output`."""
    named = _named(campaigns)
    folder = Folder(output)
    jobs, found = [], {}
    for name, campaign in named.items():
        into = folder.path / name
        if (into / "diagnosis.json").exists():
            found[name] = Diagnosis.read(into)
            continue
        line = diagnose_words(
            "campaign",
            "out",
            fmu="model.fmu",
            hold_out=hold_out,
            library=_if(library),
            null=0,
            force=force,
        )
        jobs.append((name, line, _campaign_files(campaign), _library_files(library)))
    with Told(progress) as tell:
        for name, (text, files) in _results(client, _diagnosis, _given_fmu(fmu), jobs, tell):
            _write_whole(folder.path / name, files)
            found[name] = Diagnosis.read(folder.path / name, text)
    for diagnosis in found.values():
        # The temporary folder of all goes with the last of them.
        diagnosis._folder.temporary = folder.temporary
    return {name: found[name] for name in named}


def _diagnosis(fmu: bytes, job: tuple[str, list[str], Files, Files]) -> tuple[str, Files]:
    """On a worker: the summary and the files of one diagnosis."""
    _, line, campaign, library = job
    files = {"model.fmu": fmu, **_below("campaign", campaign), **_below("library", library)}
    with _room(files) as room:
        found = _native.perform(
            _inside(room, line, "campaign", "out", "model.fmu", "library"), None, True
        )
        return found["text"], _read(room / "out")


def null(
    client: Client,
    campaign: Campaign | Path,
    count: int,
    *,
    shares: int | None = None,
    output: Path | None = None,
    fmu: Path | None = None,
    hold_out: str | None = None,
    library: Path | None = None,
    force: bool = False,
    progress: Progress = None,
) -> Diagnosis:
    """As `stickslip.diagnose(campaign, null=count)`: the search runs here, the `count` simulated
    campaigns on the workers, in so many shares [default: two for each thread of the cluster]."""
    folder = Folder(output)
    line = diagnose_words(
        campaign, folder.path, fmu=fmu, hold_out=hold_out, library=library, null=0, force=force
    )
    with Told(progress) as tell:
        _native.diagnose_later(line, tell)
        fits = _read(folder.path, [FITS])
        there = diagnose_words(
            "campaign",
            "out",
            fmu="model.fmu",
            hold_out=hold_out,
            library=_if(library),
            null=0,
            force=True,
        )
        threads = sum(client.nthreads().values())
        bounds = _shares(count, shares or 2 * max(threads, 1))
        files = {
            **_below("campaign", _campaign_files(campaign)),
            **_below("library", _library_files(library)),
        }
        files |= _below("out", fits)
        jobs = [(share, there, files) for share in bounds]
        gains = dict(_results(client, _gains, _given_fmu(fmu), jobs, tell))
        steps = len(next(iter(gains.values()), []))
        by_step = [
            [gain for share in bounds for gain in gains[share][step]] for step in range(steps)
        ]
        data, text = _native.diagnose_known(line, by_step, tell)
    return Diagnosis(json.loads(data), text, folder)


FITS = "unfinished.fits"
"""Fits of a diagnosis, which need not be made again."""


def _gains(fmu: bytes, job: tuple[tuple[int, int], list[str], Files]) -> list[list[float]]:
    """On a worker: gains by chance in a share of the simulated campaigns."""
    (first, end), line, files = job
    with _room({"model.fmu": fmu, **files}) as room:
        return _native.null_gains(
            _inside(room, line, "campaign", "out", "model.fmu", "library"), first, end
        )


def _shares(count: int, shares: int) -> list[tuple[int, int]]:
    """The numbers up to `count` in shares of nearly the same size."""
    shares = min(shares, count)
    bounds = [count * k // shares for k in range(shares + 1)] if shares else [0]
    return list(zip(bounds, bounds[1:]))


def blind_test(
    client: Client,
    folder: Path,
    *,
    only: Iterable[str] | None = None,
    fmu: Path | None = None,
    output: Path | None = None,
    force: bool = False,
    progress: Progress = None,
) -> BlindTest:
    """As `stickslip.blind_test`, each campaign on one worker."""
    into = Folder(output)
    source = FilePath(folder)
    chosen = set(only) if only is not None else None
    names = [
        p.name
        for p in sorted(source.iterdir())
        if p.is_dir() and (chosen is None or p.name in chosen)
    ]
    line = blind_words("blind", "out", only=None, fmu="model.fmu", force=force)
    truth = _read(source, ["truth.json"])
    jobs = [
        (name, line, {**truth, **_below(name, _campaign_files(source / name))})
        for name in names
        if not (into.path / name / "blind-case.json").exists()
    ]
    with Told(progress) as tell:
        for name, files in _results(client, _case, _given_fmu(fmu), jobs, tell):
            _write_whole(into.path / name, files)
    # All is there: this counts. What is of another program or campaign is done anew.
    return _blind_test(folder, only=only, fmu=fmu, output=into.path, force=force, progress=progress)


def _case(fmu: bytes, job: tuple[str, list[str], Files]) -> Files:
    """On a worker: the files of one campaign of a blind test."""
    name, line, files = job
    with _room({"model.fmu": fmu, **_below("blind", files)}) as room:
        one = _inside(room, line, "blind", "out", "model.fmu")
        _native.perform([one[0], f"--only={name}", *one[1:]], None, True, PROGRAM)
        return _read(room / "out" / name)


def _results(
    client: Client,
    work: Callable[[bytes, Any], Any],
    fmu: bytes,
    jobs: Sequence[tuple[Any, ...]],
    tell: Callable[[str, float], object] | None,
) -> Iterator[tuple[Any, Any]]:
    """The results of the jobs as they come, each once, with the first item of its job."""
    import dask.distributed

    as_completed: Any = dask.distributed.as_completed
    if not jobs:
        return
    shared = client.scatter(fmu, broadcast=True, hash=True)
    futures = {
        client.submit(work, shared, job, pure=False, retries=RETRIES): job[0] for job in jobs
    }
    try:
        for done, (future, result) in enumerate(as_completed(futures, with_results=True), start=1):
            if tell:
                tell(f"{done} of {len(jobs)} tasks", done / len(jobs))
            yield futures[future], result
            future.release()
    finally:
        client.cancel(list(futures))


class _room:
    """A temporary folder with these files."""

    def __init__(self, files: Files) -> None:
        self.files = files

    def __enter__(self) -> FilePath:
        self.folder = FilePath(tempfile.mkdtemp(prefix="stickslip-"))
        for name, content in self.files.items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return self.folder

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)


def _inside(room: FilePath, line: list[str], *names: str) -> list[str]:
    """A command line with the names of files and folders within the room."""

    def placed(word: str) -> str:
        option, _, value = word.rpartition("=")
        return (
            f"{option}={room / value}"
            if option and value in names
            else str(room / word)
            if word in names
            else word
        )

    return [placed(word) for word in line]


def _read(folder: FilePath, names: Iterable[str] | None = None) -> Files:
    """The files of a folder, or those named."""
    if names is None:
        paths = [p for p in sorted(folder.rglob("*")) if p.is_file()]
        return {p.relative_to(folder).as_posix(): p.read_bytes() for p in paths}
    return {name: (folder / name).read_bytes() for name in names}


def _below(folder: str, files: Files) -> Files:
    return {f"{folder}/{name}": content for name, content in files.items()}


def _write_whole(folder: FilePath, files: Files) -> None:
    """Writes a folder, all or nothing."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    beside = FilePath(tempfile.mkdtemp(prefix=".stickslip-", dir=folder.parent))
    try:
        for name, content in files.items():
            path = beside / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        beside.chmod(0o755)
        if folder.exists():
            shutil.rmtree(folder)
        os.replace(beside, folder)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def _campaign_files(campaign: Campaign | Path) -> Files:
    """campaign.toml and the files of the runs, under the names that it has for them."""
    given = FilePath(folder_of(campaign))
    folder = given if given.is_dir() else given.parent
    return {
        ("campaign.toml" if folder / name == given else name): c
        for name, c in _read(folder).items()
    }


def _library_files(library: Path | None) -> Files:
    return {} if library is None else _read(FilePath(library))


def _if(library: Path | None) -> str | None:
    return None if library is None else "library"


def _given_fmu(fmu: Path | None) -> bytes:
    return FilePath(FMU if fmu is None else fmu).read_bytes()


def _named(
    campaigns: Mapping[str, Campaign | Path] | Iterable[Campaign | Path],
) -> dict[str, Campaign | Path]:
    """Campaigns by name; those without are called as their folders."""
    if isinstance(campaigns, Mapping):
        return dict(campaigns)
    named: dict[str, Campaign | Path] = {}
    for campaign in campaigns:
        name = FilePath(folder_of(campaign)).name
        if name in named:
            raise ValueError(
                f"two campaigns are called '{name}'; give them as a mapping with names"
            )
        named[name] = campaign
    return named
