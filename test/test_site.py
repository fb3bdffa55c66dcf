"""The documentation as a site: built without a warning; every page in it, reached and found; no link leads nowhere; in
a real browser, axe finds nothing serious, as on the report page."""

from __future__ import annotations

import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

pytest.importorskip("mkdocs", reason="the extra `docs` is not installed")
pytest.importorskip("material", reason="the extra `docs` is not installed")
ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "docs").glob("*.md"))
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site") / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    done = subprocess.run(
        command,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "NO_COLOR": "1", "NO_MKDOCS_2_WARNING": "1"},
    )
    assert done.returncode == 0, done.stderr
    assert not re.findall(r"^WARNING.*", done.stderr, re.M)
    return folder


class Page(html.parser.HTMLParser):
    """What a page refers to, and what can be referred to in it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.ids: set[str] = set()
        self.fetched: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.ids |= {given[key] for key in ("id", "name") if given.get(key)}
        self.links += [given[key] for key in ("href", "src") if given.get(key)]
        if tag in ("script", "img", "link") and given.get("rel") != "canonical":
            self.fetched += [given[key] for key in ("href", "src") if given.get(key)]


@pytest.fixture(scope="module")
def pages(site):
    return {path: Page(path) for path in sorted(site.rglob("*.html")) if path.name != "404.html"}


def test_every_page_is_there_and_reached_from_the_first(site, pages):
    expected = {site / f"{page.stem}.html" for page in SOURCES} | {
        site / f"{n}.html" for n in ("index", "contributing", "changes")
    }
    assert expected == set(pages)
    reached, waiting = set(), [site / "index.html"]
    while waiting:
        path = waiting.pop()
        if path in pages and path not in reached:
            reached.add(path)
            waiting += [(path.parent / urlsplit(link).path).resolve() for link in pages[path].links if ":" not in link]
    assert reached == set(pages)


def test_links_lead_somewhere_on_the_site(pages):
    wrong = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or link.startswith("//"):
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists() or (parts.fragment and target in pages and parts.fragment not in pages[target].ids):
                wrong.append(f"{path.name}: {link}")
    assert not wrong


def test_nothing_is_fetched_from_elsewhere(pages):
    assert not [link for page in pages.values() for link in page.fetched if urlsplit(link).scheme in ("http", "https")]


@pytest.mark.parametrize(
    ("word", "page"), [("scene.plane", "field.html"), ("MultiDOFJointState", "node.html"), ("prepare", "commands.html")]
)
def test_the_search_knows_what_pages_tell(site, word, page):
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    assert any(entry["location"].startswith(page) and word in entry["text"] for entry in index["docs"])


def test_readme_and_changelog_are_pages_of_it(site):
    home, changes = ((site / f"{name}.html").read_text(encoding="utf-8") for name in ("index", "changes"))
    assert 'src="images/film.webp"' in home and "scripts/test" in home
    assert "<code>artrec inspect</code>" in changes and "``" not in changes


@pytest.fixture(scope="module")
def browser():
    sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if BROWSER is None:
        pytest.skip("no chromium here")
    with sync_api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield launched
        launched.close()


@pytest.mark.parametrize(("scheme", "named"), [("light", "default"), ("dark", "slate")])
@pytest.mark.parametrize("width", [1300, 500])
@pytest.mark.parametrize("name", ["index", "parameters", "replay", "tune"])
def test_pages_can_be_read_by_everybody(site, browser, name, width, scheme, named):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")
    page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    page.goto((site / f"{name}.html").as_uri())
    page.wait_for_selector(f"body[data-md-color-scheme={named}]")
    page.wait_for_timeout(500)  # the theme's script, and ours
    found = axe.Axe().run(page).response
    page.close()
    serious = [v for v in found["violations"] if v["impact"] in ("serious", "critical")]
    assert len(found["passes"]) > 20 and not serious, [f"{v['id']}: {v['nodes'][0]['html'][:120]}" for v in serious]
