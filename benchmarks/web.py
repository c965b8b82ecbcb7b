"""How long the page waits: from the end of an upload to the trace and the curve, and for a part of the trace.

    python benchmarks/web.py [--samples 10000000] [--rounds 3] [--write PATH]

A file of one channel is uploaded as CSV and as .npy to a server in a process of its own, and analyzed as the page does
it. Each round has a noise of its own. Memory is that of the server and of its largest worker; where Chromium and
Playwright are installed, the same file is dropped on the page, and the memory of the tab is measured. Ends with exit
code 1 if a bound is missed.
"""

from table import ROOT, begin, markdown

import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import csv

import allanite as al

sys.path.insert(0, str(ROOT / "tests" / "web"))

from served import Client, served

RATE = 1000.0
BOUNDS = {"trace": 2.0, "curve": 3.0, "part of the trace": 0.2}
"""Bounds, s."""

REFIT = 0.5
"""Bound of a refit of a million samples, s."""

MEMORY = ("server MB", "worker MB")

PARTS = 40
"""Parts of the trace that are asked for, of different lengths."""


def main() -> int:
    """Measure, and print the table."""
    run = begin(__doc__, samples=10_000_000, rounds=3)
    for library in ("OMP", "ARROW", "NUMBA"):  # the server runs with nothing set, as users do
        os.environ.pop(f"{library}_NUM_THREADS", None)
    rows, worst = [], dict.fromkeys(BOUNDS, 0.0)
    with (
        tempfile.TemporaryDirectory() as folder,
        served(folder, "--quota", "100GB") as (process, link),
        Client(link) as client,
    ):
        prepare(client)
        for form in ("csv", "npy"):
            for seed in range(run.asked.rounds):
                data = made(form, seed, run.asked.samples, Path(folder))
                found = round_of(client, data, form, seed, process.pid)
                worst = {name: max(worst[name], found[name]) for name in BOUNDS}
                rows.append([form, str(seed), *(f"{v:.0f}" if k in MEMORY else f"{v:.3f}" for k, v in found.items())])
        refits = [refit(client, Path(folder), seed) for seed in range(run.asked.rounds)]
        memory = tab(client, Path(folder), run.asked.samples)
    heads = ["file", "seed", *found]
    title = "What the page waits for"
    refitted = f"A refit of a million samples: {', '.join(f'{t:.2f} s' for t in refits)}."
    body = [*markdown(heads, rows), refitted, "", memory]
    run.publish(title, ["seeds: as in the table; times in s, from the end of the upload"], body)
    missed = [name for name in BOUNDS if worst[name] > BOUNDS[name]] + (["refit"] if max(refits) > REFIT else [])
    print("missed:", ", ".join(missed) or "nothing")
    return 1 if missed else 0


def prepare(client: Client) -> None:
    """Analyze a file before anything is measured: the workers are ready then."""
    workspace = client.workspace()
    answer = client.post(f"/api/workspaces/{workspace}/example", {"name": "mems"}).json()
    client.run(workspace, "analyze", [answer["id"]])


def upload(client: Client, workspace: str, data: bytes, name: str) -> str:
    """Upload bytes."""
    path = f"/api/workspaces/{workspace}/files"
    return str(client.http.post(path, params={"name": name}, content=data).json()["id"])


def made(form: str, seed: int, samples: int, folder: Path) -> bytes:
    """A file of white noise and a random walk."""
    rng = np.random.default_rng(seed)
    values = rng.normal(0.0, 20.0, samples) + np.cumsum(rng.normal(0.0, 1e-3, samples))
    path = folder / f"made.{form}"
    if form == "npy":
        np.save(path, values)
    else:
        csv.write_csv(pa.table({"gx [deg/h]": np.round(values, 4)}), path)
    data = path.read_bytes()
    path.unlink()
    return data


def round_of(client: Client, data: bytes, form: str, seed: int, server: int) -> dict[str, float]:
    """Times of one file."""
    workspace = client.workspace()
    begun = time.perf_counter()
    file = upload(client, workspace, data, f"made.{form}")
    ended = time.perf_counter()
    recipe = {"rate": RATE, "unit": "deg/h"}
    job = client.begin(workspace, "analyze", [file], recipe)
    times = {}
    for kind, _ in client.events(job):
        if kind == "trace" and kind not in times:
            whole = client.get(f"/api/files/{file}/trace", points=2000).json()
        times.setdefault(kind, time.perf_counter() - ended)
    if "done" not in times:
        raise SystemExit(f"the job failed: {times}")
    channel = client.get(f"/api/jobs/{job}").json()["channels"][0]["name"]
    client.get(f"/api/jobs/{job}/deviation", channel=channel, statistic="oadev")
    band = time.perf_counter() - ended
    part = max(parts(client, file, whole["duration"], seed))
    memory = [resident(pid) for pid in (server, largest(server))]
    client.http.delete(f"/api/workspaces/{workspace}")
    found = {"upload": ended - begun, "trace": times["trace"], "curve": times["curves"]}
    found |= {"curve with band, model and terms": band, "part of the trace": part}
    return found | dict(zip(MEMORY, memory, strict=True))


def parts(client: Client, file: str, length: float, seed: int) -> list[float]:
    """Times of parts of the trace."""
    rng, found = np.random.default_rng(seed), []
    for share in np.geomspace(1e-6, 1.0, PARTS):
        start = rng.uniform(0.0, 1.0 - share) * length
        begun = time.perf_counter()
        where: dict[str, Any] = {"from": start, "to": start + share * length, "points": 2000}
        json.loads(client.get(f"/api/files/{file}/trace", **where).content)
        found.append(time.perf_counter() - begun)
    return found


def refit(client: Client, folder: Path, seed: int) -> float:
    """Time of a refit of a million samples, by the second of two."""
    workspace = client.workspace()
    file = upload(client, workspace, made("npy", seed, 1_000_000, folder), "made.npy")
    job, _ = client.run(workspace, "analyze", [file], {"rate": RATE, "unit": "deg/h"})
    channel = client.get(f"/api/jobs/{job}").json()["channels"][0]["name"]
    for terms in ("QN", "QNK"):
        begun = time.perf_counter()
        answer = client.post(f"/api/jobs/{job}/refit", {"channel": channel, "terms": terms, "statistics": ["oadev"]})
        answer.raise_for_status()
    return time.perf_counter() - begun


def tab(client: Client, folder: Path, samples: int) -> str:
    """Memory of a tab on which a file was dropped, when its curve and its result are shown."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        chromium = None
    if chromium is None:
        return "The memory of the tab was not measured: Playwright or Chromium is not installed."
    path = folder / "tab.npz"
    al.write(al.simulate(al.N(0.1, "deg/sqrt(h)"), samples, RATE, rng=np.random.default_rng(0)), path)
    address = str(client.http.base_url).rstrip("/")
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        context = browser.new_context()
        context.add_init_script(f"localStorage.setItem('secret', '{client.secret}')")
        page = context.new_page()
        page.goto(f"{address}/#{client.workspace()}")
        page.wait_for_selector("body[data-ready=true]")
        page.get_by_test_id("choose-file").set_input_files(str(path))
        page.wait_for_selector("#curve-plot[data-curves]", timeout=20_000)
        session = context.new_cdp_session(page)
        session.send("Performance.enable")
        metrics = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
        most = max(map(resident, renderers()))
        browser.close()
    return (
        f"A tab on which a file of {samples:.0e} samples was dropped: {metrics['JSHeapUsedSize'] / 1e6:.1f} MB of "
        f"JavaScript's heap, {most:.0f} MB in the process that draws it, at most."
    )


def renderers() -> list[int]:
    """Processes of the browser that draw pages."""
    return [pid for pid in descendants(os.getpid()) if b"--type=renderer" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def resident(pid: int) -> float:
    """Memory of a process, MB."""
    with open(f"/proc/{pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith("VmHWM"))


def largest(pid: int) -> int:
    """The descendant of a process that takes the most memory."""
    return max(descendants(pid), key=resident)


def descendants(pid: int) -> list[int]:
    """Processes below a process that have memory."""
    found = []
    for other in filter(str.isdigit, os.listdir("/proc")):
        try:
            parent = int(Path(f"/proc/{other}/stat").read_text("utf-8").rpartition(")")[2].split()[1])
            resident(int(other))
        except (OSError, StopIteration):
            continue
        if parent == pid:
            found += [int(other), *descendants(int(other))]
    return found


if __name__ == "__main__":
    sys.exit(main())
