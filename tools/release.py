"""Make a release in a folder: sdist, a wheel built from it, the bill of materials and checksums of the three.

    python tools/release.py [FOLDER]

The bill of materials (CycloneDX, JSON) lists the wheel and all that it needs, with the versions of constraints.txt,
as they are installed into an environment of its own. benchmarks/environments.py tries the wheel with other versions,
tools/advisories.py looks the versions up in a folder of advisories. Every sentence of the reports has to be translated,
every fragment of the changelog joined (tools/changes.py), and every table of the benchmarks made of the code as it is
(tools/stale.py), with a number for each promise of docs/known.md (tools/promises.py).
"""

import hashlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLOTLY = ROOT / "src" / "allanite" / "web" / "static" / "plotly-basic.min.js"


def run(*words: object, folder: Path = ROOT) -> None:
    """Run a command that has to succeed."""
    subprocess.run([str(word) for word in words], cwd=folder, check=True)  # noqa: S603  our own words


def unfinished() -> list[str]:
    """What has to be done before a release, a line each."""
    import allanite
    import catalogues
    import changes
    import promises
    import stale

    found = catalogues.templates()
    english = (catalogues.english(catalogues.renewed(lang, found)) for lang in catalogues.languages())
    lines = [f"{line}: run make catalogues, and translate them" for line in english if line]
    if changes.fragments() or f"\n## {allanite.__version__} (" not in changes.LOG.read_text("utf-8"):
        lines.append(f"CHANGELOG.md lacks changes of {allanite.__version__}: run python tools/changes.py")
    return lines + promises.waiting() + stale.unfit()


def built(folder: Path) -> tuple[Path, Path]:
    """The sdist, and the wheel that is built of what it unpacks to."""
    hatch = (sys.executable, "-m", "hatchling", "build", "-d", folder, "-t")
    run(*hatch, "sdist")
    (archive,) = folder.glob("*.tar.gz")
    with tempfile.TemporaryDirectory() as name:
        shutil.unpack_archive(archive, name, filter="data")
        run(*hatch, "wheel", folder=next(Path(name).iterdir()))
    (wheel,) = folder.glob("*.whl")
    return archive, wheel


def materials(wheel: Path, target: Path) -> Path:
    """The bill of materials of a wheel and of what is installed with it."""
    with tempfile.TemporaryDirectory() as name:
        own = Path(name, "bin", "python")
        run(sys.executable, "-m", "venv", name)
        run(own, "-m", "pip", "install", "-q", "-c", ROOT / "constraints.txt", wheel)
        run(own, "-m", "pip", "uninstall", "-q", "-y", "pip", "setuptools")
        about = ("--pyproject", ROOT / "pyproject.toml", "--mc-type", "library", "--output-reproducible")
        run(sys.executable, "-m", "cyclonedx_py", "environment", *about, "-o", target, own)
    return target


def completed(text: str, version: str) -> str:
    """A bill of materials with the version of allanite, and the library of the page, which comes with the wheel."""
    bill = json.loads(text)
    bill["metadata"]["component"]["version"] = version
    with PLOTLY.open(encoding="utf-8") as script:
        (found,) = re.findall(r"\* plotly\.js \(basic - minified\) v([\d.]+)", script.read(200))
    name = "plotly.js-basic-dist-min"
    bill["components"].append(
        {
            **{"type": "library", "bom-ref": f"{name}=={found}", "name": name, "version": found},
            **{"purl": f"pkg:npm/{name}@{found}", "licenses": [{"license": {"id": "MIT"}}]},
        }
    )
    return json.dumps(bill, indent=2, ensure_ascii=False) + "\n"


def sums(*paths: Path) -> str:
    """Lines as ``sha256sum --check`` reads them."""
    return "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in paths)


def main() -> None:
    """Make the release."""
    folder = Path(*sys.argv[1:2] or ("dist",)).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        sys.exit(f"{folder} is not empty; give another folder, or remove what is in it")
    if left := unfinished():
        sys.exit("\n".join(left))
    if lacking := [name for name in ("hatchling", "cyclonedx_py") if not importlib.util.find_spec(name)]:
        sys.exit(f"{', '.join(lacking)} cannot be imported: run make release, or pip install '.[release]'")
    archive, wheel = built(folder)
    name = archive.name.removesuffix(".tar.gz")
    bill = materials(wheel, folder / f"{name}.cdx.json")
    bill.write_text(completed(bill.read_text("utf-8"), name.rpartition("-")[2]), "utf-8")
    (folder / "SHA256SUMS").write_text(sums(archive, wheel, bill), "utf-8")


if __name__ == "__main__":
    main()
