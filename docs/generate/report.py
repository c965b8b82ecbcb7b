"""The picture of a report in the README: ``python -P docs/generate/report.py`` takes it by a browser."""

import io
import shutil
import sys
import tempfile
from pathlib import Path

import allanite as al

ROOT = Path(__file__).parents[2]
SAMPLE, PICTURE = ROOT / "examples" / "tactical_gyro.csv", ROOT / "docs" / "figures" / "report.png"
COLORS = 256


def main() -> None:
    """Its first screen, 1280 pixels wide, in as many colours as a palette holds."""
    from PIL import Image
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as place, sync_playwright() as play:
        page = Path(place, "report.html")
        al.report(al.analyze(SAMPLE), page)
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        view = browser.new_page(viewport={"width": 1280, "height": 1000})
        view.goto(page.as_uri())
        shot = view.screenshot()
        browser.close()
    Image.open(io.BytesIO(shot)).convert("RGB").quantize(COLORS).save(PICTURE, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
