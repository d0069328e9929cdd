"""Makes studio.png: the studio with the demonstration, the hidden effect as the score test saw it, fitted.

    pip install playwright; python docs/figures/studio.py target/release/stickslip

Needs a Chromium of the system.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

HERE = Path(__file__).resolve().parent
WAIT = 120_000

with tempfile.TemporaryDirectory() as output, sync_playwright() as playwright:
    line = [sys.argv[1], "studio", str(HERE / "../../reference-data/demo"), "--no-open", "-o", output]
    server = subprocess.Popen(line, stdout=subprocess.PIPE, text=True)
    try:
        address = server.stdout.readline().split()[1]
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1360, "height": 980})
        page.goto(address)
        settled = page.locator("body[data-settled=true]")
        settled.wait_for(timeout=WAIT)
        page.locator("#score").click()
        page.get_by_role("button", name="Switch on belt_periodic_friction").click(timeout=WAIT)
        settled.wait_for(timeout=WAIT)
        page.locator("#runs button").nth(0).click()
        page.locator("#fit").click()
        page.locator("#ladder tbody tr").nth(1).wait_for(timeout=WAIT)
        settled.wait_for(timeout=WAIT)
        page.get_by_role("button", name="Close").first.click()
        page.mouse.move(0, 0)
        page.wait_for_timeout(1500)
        page.screenshot(path=HERE / "studio.png")
        browser.close()
    finally:
        server.kill()
