"""The studio's page in a real headless Chromium: what a user does, step by step, and what must be seen then.

    page.py STICKSLIP CAMPAIGN AXE_JS FOLDER

FOLDER receives screenshots, and latency.json with the time in ms from a moved slider to the drawn answer.
"""

import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

PROGRAM, CAMPAIGN, AXE, FOLDER = sys.argv[1:5]
FOLDER = Path(FOLDER)
WAIT = 120_000
# Holds every prediction back for as long as a click takes.
SLOW = """() => {
  window.atOnce = window.fetch;
  window.fetch = async (...call) => {
    const response = await window.atOnce(...call);
    if (String(call[0]).includes('predict')) await new Promise((done) => { setTimeout(done, 1000); });
    return response;
  };
}"""


class Studio:
    """A server; `end` kills it as a crash would."""

    running = []

    def __init__(self, output: Path):
        line = [PROGRAM, "studio", CAMPAIGN, "--no-open", "-o", str(output)]
        self.process = subprocess.Popen(line, stdout=subprocess.PIPE, text=True)
        Studio.running.append(self)
        self.address = self.process.stdout.readline().split()[1]

    def end(self):
        self.process.kill()
        self.process.wait()


def until(page: Page, holds: str):
    """Waits until an expression holds. Playwright's own way compiles it in the page, whose policy forbids that."""
    deadline = time.monotonic() + WAIT / 1e3
    while not page.evaluate(holds):
        assert time.monotonic() < deadline, f"not within {WAIT} ms: {holds}"
        time.sleep(0.004)


def settled(page: Page):
    """Waits until the page shows the careful answer to its last question."""
    until(page, "document.body.dataset.settled === 'true'")


def error(page: Page) -> float:
    text = page.locator("#error").inner_text()
    return float(re.sub(r"[^\d.e-]", "", text))


def free_of_errors(page: Page, seen: list):
    page.on("pageerror", lambda failure: seen.append(str(failure)))
    said = lambda message: f"{message.text} {message.location['url']}"
    page.on("console", lambda message: seen.append(said(message)) if message.type == "error" else None)


def picture(page: Page, name: str):
    page.screenshot(path=FOLDER / f"{name}.png", full_page=True)


def curve(page: Page) -> list:
    """The first samples of the model's curve in the picture of the motion."""
    script = "document.getElementById('motion').data.find(t => t.name === 'model').y.filter(v => v !== null).slice(0, 200)"
    return page.evaluate(script)


def accessible(page: Page, where: str):
    # The policy of the page lets no script in but its own; the test puts this one in as the browser's own.
    page.evaluate(Path(AXE).read_text() + "; null")
    found = page.evaluate(
        "axe.run({exclude: [['.js-plotly-plot']]}, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa']})"
    )
    breaches = [f"{v['id']}: {v['nodes'][0]['html'][:120]}" for v in found["violations"]]
    assert not breaches, f"{where}: {breaches}"


def narrow(page: Page, where: str):
    wide = page.evaluate("document.documentElement.scrollWidth")
    width = page.evaluate("window.innerWidth")
    assert wide <= width, f"{where}: {wide} px on a screen of {width} px"


def main():
    output = FOLDER / "out"
    shutil.rmtree(output, ignore_errors=True)
    studio = Studio(output)
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or shutil.which("google-chrome")
        options = {"executable_path": chromium} if chromium else {}
        browser = playwright.chromium.launch(args=["--no-sandbox"], **options)
        context = browser.new_context(viewport={"width": 1360, "height": 900})
        page = context.new_page()
        seen = []
        free_of_errors(page, seen)
        asked = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(studio.address)
        settled(page)
        given = error(page)
        assert given > 5, f"as given {given} %"
        picture(page, "given")

        # A click on the map, and a run by the keyboard.
        page.locator("#runs button").nth(1).focus()
        page.keyboard.press("Enter")
        expect(page.locator("#run-name")).to_have_text("run02")
        settled(page)

        # An effect on: error and curve change.
        before = curve(page)
        page.locator("#effect-belt_periodic_friction").check()
        settled(page)
        on = error(page)
        assert abs(on - given) > 0.1 and curve(page) != before, f"{given} % -> {on} %"
        slider = page.locator("input[type=range][data-name='belt_periodic_friction.amplitude']")
        before = curve(page)
        slider.focus()
        for _ in range(40):
            page.keyboard.press("ArrowRight")
        until(page, "document.body.dataset.settled === 'false'")
        settled(page)
        moved = error(page)
        assert abs(moved - on) > 1e-2 and curve(page) != before, f"{on} % -> {moved} %"
        picture(page, "effect")

        # How fast it follows.
        times = []
        for step in range(40):
            page.evaluate("document.body.dataset.latency = ''")
            page.keyboard.press("ArrowLeft" if step % 2 else "ArrowRight")
            until(page, "document.body.dataset.latency !== ''")
            times.append(float(page.evaluate("document.body.dataset.latency")))
        times.sort()
        latency = {"median_ms": statistics.median(times), "p95_ms": times[int(0.95 * len(times))]}
        (FOLDER / "latency.json").write_text(json.dumps(latency))
        print("latency", latency)

        # Score: effects with gains, the best one can be switched on.
        settled(page)
        page.locator("#effect-belt_periodic_friction").uncheck()
        settled(page)
        page.locator("#score").click()
        expect(page.locator("#scores tr").first).to_be_visible(timeout=WAIT)
        best = [row.inner_text().split()[0] for row in page.locator("#scores tr").all()]
        print("scores", best)
        assert "belt_periodic_friction" in best[:5], best
        picture(page, "score")
        page.locator("#scores tr", has_text="belt_periodic_friction").first.get_by_role("button").click()
        settled(page)

        # A fit, live.
        page.locator("#fit").click()
        expect(page.locator("#work")).to_be_visible(timeout=WAIT)
        until(page, "document.getElementById('work-words').textContent.includes('iteration')")
        expect(page.locator("#ladder tbody tr")).to_have_count(2, timeout=WAIT)
        settled(page)
        fitted = error(page)
        print("fit", on, "->", fitted)
        assert fitted < 0.8 * on, f"{on} % -> {fitted} %"
        kept = float(page.locator("#ladder tbody tr").nth(1).locator("td").nth(2).inner_text().split()[0])
        assert abs(fitted - kept) < 1e-2 * kept, f"{fitted} % on the page, {kept} % on the ladder"
        picture(page, "fit")

        # A fit is stopped and keeps where it stood.
        page.locator("#effect-viscous_friction").check()
        settled(page)
        page.locator("#fit").click()
        until(page, "document.getElementById('work-words').textContent.includes('iteration 1')")
        page.locator("#cancel").click()
        expect(page.locator("#ladder tbody tr")).to_have_count(3, timeout=WAIT)
        expect(page.locator("#outcome")).to_contain_text("Stopped")

        # Back to the first rung, and two side by side; the answer about another rung, still on its way, is not taken for it.
        page.evaluate(SLOW)
        page.locator("#ladder tbody tr").nth(1).get_by_role("button").first.click()
        page.get_by_role("button", name="as given", exact=True).click()
        settled(page)
        page.evaluate("window.fetch = window.atOnce; null")
        assert abs(error(page) - given) < 1e-3 * given, f"{error(page)} % restored, {given} % then"
        expect(page.locator("#effect-belt_periodic_friction")).not_to_be_checked()
        page.locator("input[name=side-A]").nth(0).check()
        page.locator("input[name=side-B]").nth(1).check()
        expect(page.locator("#beside")).to_contain_text("belt_periodic_friction.amplitude")
        until(page, "document.getElementById('motion').data.length > 3")
        picture(page, "beside")

        # Export.
        page.get_by_role("button", name=re.compile("^Export fit")).first.click()
        expect(page.locator("#outcome a", has_text="report.html")).to_be_visible(timeout=WAIT)
        files = sorted(path.name for path in (output / "export").rglob("*") if path.is_file())
        for name in ["StickSlipBeam.fmu", "StickSlipBeam.ssv", "campaign.toml", "model.toml", "report.html"]:
            assert name in files, files
        expect(page.locator("#outcome pre")).to_contain_text("stickslip compare")
        with context.expect_page() as opened:
            page.locator("#outcome a", has_text="report.html").click()
        expect(opened.value.locator("h1")).to_be_visible()
        opened.value.close()

        # Zoom is linked: a stretch of the motion is all that the phase portrait shows.
        whole = page.evaluate("document.getElementById('phase').data[0].x.length")
        page.evaluate("Plotly.relayout('motion', {'xaxis.range': [0.1, 0.102]})")
        until(page, f"document.getElementById('phase').data[0].x.length < {whole} / 4")
        page.evaluate("Plotly.relayout('motion', {'xaxis.autorange': true})")

        # A value that is none is refused beside its field, and by the server.
        box = page.locator("#nuisance-box")
        box.locator("summary").click()
        number = box.locator("input[type=number]").first
        number.fill("1e9")
        number.press("Tab")
        assert number.evaluate("n => !n.validity.valid")

        # Reload in the middle of work.
        page.locator("#score").click()
        page.reload()
        settled(page)
        expect(page.locator("#ladder tbody tr")).to_have_count(3, timeout=WAIT)

        # Two tabs: the other follows.
        second = context.new_page()
        free_of_errors(second, seen)
        second.goto(studio.address)
        settled(second)
        expect(second.locator("#score")).to_be_enabled(timeout=WAIT)
        page.locator("#effect-quadratic_drag").check()
        settled(page)
        expect(second.locator("#effect-quadratic_drag")).to_be_checked(timeout=WAIT)
        second.close()

        # Diagnose, the whole: what was found is said, has its files and is a rung.
        page.locator("#diagnose").click()
        expect(page.locator("#work")).to_be_visible(timeout=WAIT)
        expect(page.locator("#outcome a", has_text="diagnosis.json")).to_be_visible(timeout=WAIT)
        expect(page.locator("#outcome")).to_contain_text("Missing: belt_periodic_friction")
        expect(page.locator("#ladder tbody tr")).to_have_count(4)
        expect(page.locator("#effect-belt_periodic_friction")).to_be_checked()
        expect(page.locator("#effect-quadratic_drag")).not_to_be_checked()
        settled(page)
        assert error(page) < 1, f"diagnosed {error(page)} %"
        picture(page, "diagnosed")

        # A file is dropped on the page; the dialog leads to a campaign.
        data = Path(CAMPAIGN, "run01.csv").read_text()
        page.evaluate(
            """text => {
                const list = new DataTransfer();
                list.items.add(new File([text], 'dropped run.csv'));
                document.dispatchEvent(new DragEvent('drop', {dataTransfer: list, bubbles: true, cancelable: true}));
            }""",
            data,
        )
        expect(page.locator("#import table")).to_be_visible(timeout=WAIT)
        page.locator("#import-go").click()
        expect(page.locator("#import-error")).to_contain_text("Give belt velocity")
        page.get_by_label("belt velocity in m/s").fill("0.04")
        page.get_by_label("normal force in N").fill("36")
        page.get_by_label("Structure").select_option("beam-on-belt")
        page.get_by_label("Measured at the tip").select_option("velocity")
        assert "mm/s" in page.get_by_label("Its unit").inner_text()
        page.locator("#import-go").click()
        expect(page.locator("#import-error")).to_contain_text("Choose the channel of the velocity")
        page.get_by_label("Measured at the tip").select_option("displacement")
        picture(page, "import")
        accessible(page, "import")
        page.locator("#import-go").click()
        expect(page.locator("#import pre")).to_contain_text("stickslip import", timeout=WAIT)
        page.get_by_role("button", name="Close").last.click()
        expect(page.locator("#runs button")).to_have_count(1, timeout=WAIT)
        settled(page)

        # Phone and dark mode; accessibility.
        accessible(page, "wide")
        page.set_viewport_size({"width": 360, "height": 740})
        page.wait_for_timeout(500)
        narrow(page, "light")
        accessible(page, "narrow")
        picture(page, "narrow")
        page.emulate_media(color_scheme="dark")
        page.wait_for_timeout(500)
        accessible(page, "dark")
        picture(page, "narrow-dark")
        page.set_viewport_size({"width": 1360, "height": 900})
        page.wait_for_timeout(500)
        picture(page, "dark")

        # Nothing but this server was asked for anything.
        others = {url for url in asked if not url.startswith((studio.address, "data:", "blob:"))}
        assert not others, others
        wrong = [text for text in seen if "favicon" not in text]
        assert not wrong, wrong

        # A server that is killed is told, and the next one goes on.
        studio.end()
        expect(page.locator("#trouble")).to_contain_text("server is gone", timeout=WAIT)
        again = Studio(output)
        fresh = context.new_page()
        fresh.goto(again.address)
        settled(fresh)
        again.end()
        browser.close()


if __name__ == "__main__":
    os.makedirs(FOLDER, exist_ok=True)
    try:
        main()
    finally:
        for studio in Studio.running:
            studio.end()
