"""Swagger UI draws the page `/docs` under the server's content security policy."""

import httpx
from playwright.sync_api import Browser, expect

from tests.browser.conftest import Complaints
from tests.kit.address import Address
from tests.kit.waiting import LIMIT


def test_the_docs_show_every_operation_and_nothing_is_blocked(
    server: Address, browser: Browser, complaints: Complaints
) -> None:
    page = browser.new_page()
    page.set_default_timeout(1000 * LIMIT)
    complaints.watch(page)
    page.goto(f"{server.url}/docs")
    page.locator(".opblock").first.wait_for()
    document = httpx.get(f"{server.url}/openapi.json", timeout=LIMIT).json()
    count = sum(len(operations) for operations in document["paths"].values())
    expect(page.locator(".opblock")).to_have_count(count)
    assert count > 40
    complaints.leave(page)
    page.close()
