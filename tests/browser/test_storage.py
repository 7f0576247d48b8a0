"""A browser that stores nothing: every page works, and the first refused write is reported."""

import re

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Complaints, Open, Quick
from tests.long import tries

# Run before the page: the visitor has blocked all storage of the site.
BLOCKED = """
for (const name of ["localStorage", "sessionStorage", "indexedDB", "caches"]) {
  Object.defineProperty(window, name, {
    get() { throw new DOMException("The user denied permission.", "SecurityError"); },
  });
}
"""

# Firefox with `dom.storage.enabled` off.
ABSENT = """
for (const name of ["localStorage", "sessionStorage"]) {
  Object.defineProperty(window, name, { get: () => null });
}
"""

# Nothing more fits. What was stored before can be read.
FULL = """
Storage.prototype.setItem = () => { throw new DOMException("Full.", "QuotaExceededError"); };
"""

REFUSALS = {"blocked": BLOCKED, "absent": ABSENT, "full": FULL}

# Each page, and what shows that it has started.
STARTED = {
    "/": "[data-state=asleep] #drop:enabled",
    "/sandbox.html": "[data-state=live] #throw, [data-state=asleep] #throw",
    "/replay.html?board=triangle-8&seed=1": "[data-state=replay] #play",
    "/replay.html?board=triangle-8&seed=1&compare": "[data-state=replay] #play",
    "/editor.html?board=triangle-8": "[data-state=asleep] #test",
    "/today.html": "[data-state=replay] .pick",
    "/class.html": "[data-state=live] #drop",
    "/verify.html": "[data-ready=true] #file",
    "/replay.html?board=triangle-8&seed=1&embed": "[data-state=replay] #drop:enabled",
    "/stage.html": "[data-state=asleep], [data-state=live]",
    "/no-such-page": ".lost",
}


# All pages store by js/util/storage.js, whose own tests have every kind of refusal.
@pytest.mark.parametrize("page", STARTED)
def test_every_page_starts(opened: Open, complaints: Complaints, page: str) -> None:
    if page == "/no-such-page":
        complaints.allow("404")
    screen = opened(page, before=BLOCKED)
    expect(screen.page.locator(STARTED[page]).first).to_be_attached()
    if page.startswith("/replay"):  # it stores nothing
        expect(screen.page.locator(".unstored")).to_have_count(0)


@pytest.mark.long
@pytest.mark.parametrize("refusal", tries(["blocked"], [*REFUSALS]))
def test_the_table_plays_and_says_once_that_nothing_is_kept(
    opened: Open, quick: Quick, refusal: str
) -> None:
    screen = opened(quick.page, before=REFUSALS[refusal]).ready()
    page = screen.page
    notice = page.get_by_role("alert").filter(has_text="stores nothing here")
    expect(notice).to_be_visible()
    screen.shot("storage-refused")
    notice.get_by_role("button", name="Close").click()
    page.get_by_label("Stake", exact=True).fill("2")
    screen.drop.click()
    expect(page.locator("#drops > li")).to_have_count(1)
    expect(page.locator("#staked")).to_have_text("2.00")
    net = float(page.locator("#net").inner_text().replace("\N{MINUS SIGN}", "-").replace(",", ""))
    expect(page.locator("#balance")).to_have_text(f"{1000 + net:,.2f}")
    screen.drawer("Fairness").get_by_role("button", name="Reveal", exact=False).click()
    expect(page.locator("#fair-verdict")).to_have_attribute("data-tone", "good")
    screen.drawer("Table")  # a drawer that the tab remembers
    expect(notice).to_have_count(0)


def test_the_notice_is_in_the_visitor_s_language(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=FULL, locale="de-CH").ready()
    expect(screen.page.locator(".unstored")).to_contain_text("speichert hier nichts")


# The visitor has blocked cookies: writes are ignored.
NO_COOKIES = """
Object.defineProperty(Document.prototype, "cookie", { get: () => "", set: () => {} });
"""


def test_a_chosen_language_stays_without_cookies(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=NO_COOKIES).ready()
    room = screen.page.url.partition("?")[2]
    screen.drawer("Settings").locator("#language").select_option("de")
    expect(screen.root).to_have_attribute("lang", "de")
    assert room in screen.page.url
    screen.page.reload()
    expect(screen.root).to_have_attribute("lang", "de")


def test_the_maker_of_a_room_owns_it(opened: Open) -> None:
    screen = opened("/sandbox.html", before=BLOCKED).state("live", "asleep")
    screen.page.locator("#share").click()
    screen.page.wait_for_url(re.compile("room="))
    expect(screen.root).to_have_attribute("data-locked", "false")
    assert "token" not in screen.page.url


# In the page's service worker: nothing more fits into its cache.
WORKER_FULL = """
() => {
  Cache.prototype.put = () => Promise.reject(new DOMException("Full.", "QuotaExceededError"));
}
"""


def test_a_full_cache_takes_no_page_away(opened: Open) -> None:
    screen = opened("/replay.html?board=triangle-8&seed=1", service_workers="allow")
    screen.state("replay")
    screen.page.evaluate("navigator.serviceWorker.ready.then(() => null)")
    screen.until(lambda: screen.page.context.service_workers)
    (worker,) = screen.page.context.service_workers
    worker.evaluate(WORKER_FULL)
    screen.page.goto(f"{screen.url}/verify.html?key")
    expect(screen.root).to_have_attribute("data-ready", "true")
