"""Swagger UI draws the page `/docs` under the server's content security policy."""

import httpx
from playwright.sync_api import Browser

from tests.browser.conftest import Complaints
from tests.kit.process import ServerProcess


def test_the_docs_show_every_operation_and_nothing_is_blocked(
    server: ServerProcess, browser: Browser, complaints: Complaints
) -> None:
    page = browser.new_page()
    complaints.watch(page)
    page.goto(f"{server.url}/docs")
    page.locator(".opblock").first.wait_for()
    document = httpx.get(f"{server.url}/openapi.json").json()
    count = sum(len(operations) for operations in document["paths"].values())
    assert page.locator(".opblock").count() == count > 40
    complaints.leave(page)
    page.close()
