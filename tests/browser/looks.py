"""Screens for pages' tests, and checks for all: no sideways scrolling, targets for fingers."""

from collections.abc import Callable, Iterator
from typing import Any

from tests.browser.screen import Screen
from tests.long import tries

# Width, height, colour scheme: the smallest, the most common and the largest screens.
SCREENS = {
    "phone": [(360, 740, "light"), (390, 844, "dark"), *tries([], [(360, 740, "dark")])],
    "desk": [
        (768, 1024, "light"),
        (1280, 800, "dark"),
        *tries(
            [(1920, 1080, "dark")],
            [(1280, 800, "light"), (1920, 1080, "light"), (3840, 2160, "dark")],
        ),
    ],
}

# Fingers need targets of 44 CSS pixels. A radio button or a checkbox fills its whole chip.
_SMALL_TARGETS = """
[...document.querySelectorAll("button, input, select, textarea, a:not(.skip)")]
  .filter((element) => element.offsetParent !== null)
  .map((element) => [element.id || element.name || element.textContent,
                     element.getBoundingClientRect()])
  .filter(([, box]) => box.height < 43.9 || box.width < 30)
  .map(([name, box]) => `${name}: ${box.width} x ${box.height}`)
"""


def context_for(device: str) -> dict[str, Any]:
    """Options of a browser context for a "phone" or a "desk", with the first of its screens."""
    width, height, scheme = SCREENS[device][0]
    phone = device == "phone"
    return {
        "viewport": {"width": width, "height": height},
        "color_scheme": scheme,
        "device_scale_factor": 2 if phone else 1,
        "is_mobile": phone,
        "has_touch": phone,
    }


def each_screen(
    screen: Screen, device: str, wanted: Callable[[str], bool] = lambda name: True
) -> Iterator[str]:
    """Show the open page on each screen of the device whose name is `wanted`; gives the names."""
    for width, height, scheme in SCREENS[device]:
        name = f"{width}x{height}-{scheme}"
        if not wanted(name):
            continue
        screen.page.set_viewport_size({"width": width, "height": height})
        screen.page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        screen.frames(2)  # the layout changes in the next frame, which the one after shows
        yield name


def check_fit(screen: Screen) -> None:
    """Check that the page does not scroll sideways, and that fingers can hit every control."""
    overflow = screen.page.evaluate(
        "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    )
    assert overflow <= 0, "no sideways scrolling"
    small = screen.page.evaluate(_SMALL_TARGETS)
    assert small == [], (small, screen.page.viewport_size)


def painted(screen: Screen, canvas: str) -> int:
    """How many pixels of a canvas are not transparent, after the frames already requested."""
    screen.frames(4)
    count: int = screen.page.evaluate(
        """(id) => {
          const canvas = document.getElementById(id);
          const ctx = canvas.getContext("2d");
          const { data } = ctx.getImageData(0, 0, canvas.width, canvas.height);
          let count = 0;
          for (let i = 3; i < data.length; i += 4) count += data[i] > 0;
          return count;
        }""",
        canvas,
    )
    return count
