"""What every page owes every screen: no sideways scrolling, targets that a finger hits."""

from tests.browser.screen import Screen

# Width, height, colours: the smallest and the commonest in both, the others in one.
SCREENS = [
    (360, 740, "light"),
    (360, 740, "dark"),
    (390, 844, "dark"),
    (768, 1024, "light"),
    (1280, 800, "light"),
    (1280, 800, "dark"),
    (1920, 1080, "light"),
    (3840, 2160, "dark"),
]

# Fingers need 44 CSS pixels. The target of a radio button or a checkbox is the chip it fills.
_SMALL_TARGETS = """
[...document.querySelectorAll("button, input, select, textarea, a:not(.skip)")]
  .filter((element) => element.offsetParent !== null)
  .map((element) => [element.id || element.name || element.textContent,
                     element.getBoundingClientRect()])
  .filter(([, box]) => box.height < 43.9 || box.width < 30)
  .map(([name, box]) => `${name}: ${box.width} x ${box.height}`)
"""


def context_for(width: int, height: int, scheme: str) -> dict[str, object]:
    """Options of a browser context for a screen of this size; narrow ones are phones."""
    phone = width < 700
    return {
        "viewport": {"width": width, "height": height},
        "color_scheme": scheme,
        "device_scale_factor": 2 if phone else 1,
        "is_mobile": phone,
        "has_touch": phone,
    }


def check_fit(screen: Screen) -> None:
    """Nothing sticks out at the side, and everything can be hit."""
    overflow = screen.page.evaluate(
        "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    )
    assert overflow <= 0, "no sideways scrolling"
    assert screen.page.evaluate(_SMALL_TARGETS) == []


def painted(screen: Screen, canvas: str) -> int:
    """How many pixels of a canvas are not clear."""
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
