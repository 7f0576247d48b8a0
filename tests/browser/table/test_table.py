"""More than one ball at a time: showers, auto-drop, stakes, keys, other worlds, sound, ghosts."""

import re

import pytest
from playwright.sync_api import expect

from engine.board.materials import GRAVITY
from tests.browser.conftest import Open, Quick, Run, ServerProcess, quick_table
from tests.browser.looks import painted
from tests.browser.screen import COUNT_FRAMES


def test_several_balls_of_one_push_have_one_seed_after_the_other(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_role("radio", name="5 balls").check()
    screen.seed.fill("18446744073709551613")
    screen.drop.click()
    expect(screen.rows).to_have_count(5)
    expect(screen.page.locator("#staked")).to_have_text("0")  # chosen seeds are practice
    assert [message["seed"] for message in screen.drops_sent] == [
        "18446744073709551613",
        "18446744073709551614",
        "18446744073709551615",
        "0",
        "1",
    ]
    expect(screen.result).to_contain_text(re.compile(r"^5 practice balls: [\d.]+x on average\.$"))


def test_auto_drop_gives_so_many_and_ends_by_itself(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_text("Auto-drop").click()
    screen.page.get_by_label("How many").fill("6")
    screen.page.get_by_label("Drops a second").select_option("8")
    button = screen.page.locator("#auto")
    button.click()
    expect(button).to_contain_text("Stop")
    expect(button).to_have_text("Start")
    expect(screen.page.locator("#staked")).to_have_text("6")
    assert len(screen.drops_sent) == 6
    screen.shot("auto-drop")


def test_auto_drop_without_an_end_goes_on_until_it_is_stopped(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_text("Auto-drop").click()
    screen.page.get_by_label("How many").fill("")
    button = screen.page.locator("#auto")
    button.click()
    expect(screen.rows.nth(3)).to_be_visible()
    button.click()
    expect(button).to_have_text("Start")
    sent = len(screen.drops_sent)
    screen.frames(60)
    assert len(screen.drops_sent) == sent >= 4


def test_a_stake_is_counted_and_paid_back_by_the_bin(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_label("Stake").fill("2.5")
    screen.drop.click()
    expect(screen.page.locator("#staked")).to_have_text("2.5")
    score = screen.last_dropped()["score"]
    expect(screen.page.locator("#returned")).to_have_text(f"{2.5 * score:.2f}")
    expect(screen.result).to_contain_text(f"{2.5 * score:.2f} for 2.5")


def test_a_ball_that_landed_is_handed_on_from_where_it_is_told(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    key = screen.page.get_by_role("link", name="Share this ball")
    expect(key).to_be_hidden()
    screen.drop.click()
    expect(key).to_be_visible()
    screen.page.evaluate("() => { navigator.share = async (given) => { window.given = given; }; }")
    key.click()
    given = screen.page.evaluate("given")["url"]
    seed = screen.last_dropped()["seed"]
    assert f"seed={seed}" in given
    assert given.endswith("&guess")

    screen.page.evaluate("""() => {
      navigator.share = undefined;
      const writeText = async (text) => { window.copied = text; };
      Object.defineProperty(navigator, "clipboard", { value: { writeText } });
    }""")
    key.click()
    expect(screen.result).to_have_text("The link to this ball is copied.")
    assert screen.page.evaluate("copied") == given
    screen.drop.click()
    expect(key).to_be_hidden()


def test_an_instant_drop_is_told_at_once_and_counts_when_the_table_s_ball_is_down(
    opened: Open,
) -> None:
    screen = opened("/?room=triangle-8").ready()
    screen.page.get_by_text("Auto-drop and speed").click()
    screen.page.get_by_role("radio", name="Instant").check()
    screen.drop.click()
    expect(screen.result).to_contain_text(re.compile(r"^Bin \d pays"))
    expect(screen.page.locator("#staked")).to_have_text("0")
    screen.state("live")
    screen.page.reload()  # in mid-flight
    expect(screen.rows).to_have_count(1)
    expect(screen.page.locator("#staked")).to_have_text("1")
    expect(screen.page.locator("#paces input:checked")).to_have_value("instant")


def test_what_is_no_stake_drops_nothing(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    field = screen.page.get_by_label("Stake")
    for stake in ("0", "-1", ""):
        field.fill(stake)
        screen.drop.click()
        expect(field).to_be_focused()
        field.blur()
    assert screen.drops_sent == []


def test_arrow_keys_aim_and_say_where(opened: Open, server: ServerProcess) -> None:
    quick = quick_table(server, "triangle-9")
    screen = opened(quick.page).ready()
    words = screen.page.locator("#start-words")
    for _ in range(3):
        screen.page.keyboard.press("ArrowRight")
    expect(words).to_have_text(re.compile(r"0\.\d+ m right of the middle"))
    screen.page.keyboard.press("Shift+ArrowLeft")
    screen.page.keyboard.press("Space")
    expect(screen.rows).to_have_count(1)
    link = screen.rows.first.get_by_role("link").get_attribute("href") or ""
    found = re.search(r"aim=([\d.]+)", link)
    assert found
    reach = screen.api(f"boards/{quick.board}")["board"]["drop"]["aim"]
    assert float(found[1]) == pytest.approx(2 * reach * (3 / 24 - 1 / 240), abs=2e-4)


def test_arrow_keys_go_from_slot_to_slot(opened: Open) -> None:
    screen = opened("/?room=classic").ready()
    screen.page.keyboard.press("ArrowRight")
    expect(screen.page.get_by_role("radio", name="Slot 5")).to_be_checked()
    screen.page.keyboard.press("ArrowLeft")
    screen.page.keyboard.press("ArrowLeft")
    expect(screen.page.get_by_role("radio", name="Slot 3")).to_be_checked()
    expect(screen.page.locator("#start-words")).to_have_text("Slot 3.")


def test_another_gravity_and_material_make_a_table_of_their_own(opened: Open) -> None:
    screen = opened("/?room=triangle-8").ready()
    screen.drawer("Table").get_by_role("radio", name="Jupiter").check()
    expect(screen.root).to_have_attribute("data-state", "asleep")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("triangle-8 · Jupiter")
    )
    expect(screen.root).to_have_attribute("data-ground", "bands")
    screen.page.get_by_text("by the numbers").click()
    screen.page.get_by_label("Material").select_option("Rubber on concrete")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("triangle-8 · Jupiter · Rubber on concrete")
    )
    screen.ready()
    room = screen.page.url.rsplit("=", 1)[1]
    digest = screen.api(f"rooms/{room}")["board_digest"]
    board = screen.api(f"boards/{digest}")["board"]
    plain = screen.api("boards/triangle-8")["board"]
    assert board["gravity"] == GRAVITY["Jupiter"]
    materials = [board["ball"], board["peg_material"], board["wall_material"]]
    assert {one["restitution"] for one in materials} == {0.8}
    assert board["pegs"] == plain["pegs"]
    screen.seed.fill("3")
    screen.drop.click()
    screen.landed(screen.api(f"drops/{digest}/3")["bin"])
    screen.shot("jupiter")

    # A friend with the link sees the same table, and the same choice.
    friend = opened(f"/?room={room}").ready()
    expect(friend.page.get_by_label("Gravity")).to_have_value("Jupiter")
    expect(friend.page.get_by_label("Material")).to_have_value("Rubber on concrete")
    expect(friend.page.get_by_label("Rows", exact=True)).to_have_value("8")
    expect(friend.root).to_have_attribute("data-ground", "bands")

    # The table is found again rather than opened twice.
    screen.drawer("Table").get_by_label("Material").select_option("own")
    expect(screen.page.locator("#board-moving")).not_to_have_attribute(
        "aria-label", re.compile("Rubber")
    )
    screen.ready()
    screen.page.get_by_label("Material").select_option("Rubber on concrete")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("Rubber")
    )
    assert screen.page.url.rsplit("=", 1)[1] == room


_LISTEN = """
window.heard = { contexts: 0, voices: 0, now: 0, most: 0 };
const Real = window.AudioContext;
window.AudioContext = class extends Real {
  constructor(...all) { super(...all); heard.contexts += 1; }
  createOscillator() {
    const voice = super.createOscillator();
    heard.voices += 1;
    heard.now += 1;
    heard.most = Math.max(heard.most, heard.now);
    voice.addEventListener("ended", () => { heard.now -= 1; });
    return voice;
  }
};
"""


def test_sound_is_offered_once_off_until_asked_for_limited_and_remembered(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page, before=_LISTEN).ready()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    assert screen.page.evaluate("heard") == {"contexts": 0, "voices": 0, "now": 0, "most": 0}

    button = screen.page.get_by_role("button", name="Sound")
    expect(button).to_have_attribute("aria-pressed", "false")
    screen.page.get_by_label("How loud").fill("35")
    screen.page.get_by_role("button", name="Yes").click()
    expect(screen.page.locator("#offer")).to_be_hidden()
    expect(button).to_have_attribute("aria-pressed", "true")
    screen.page.get_by_role("radio", name="20 balls").check()
    screen.drop.click()
    expect(screen.rows).to_have_count(21)
    heard = screen.page.evaluate("heard")
    assert heard["contexts"] == 1
    assert heard["voices"] > 20
    assert heard["most"] <= 16

    button.click()
    before = screen.page.evaluate("heard.voices")
    screen.page.get_by_role("radio", name="1 ball", exact=True).check()
    screen.drop.click()
    expect(screen.rows).to_have_count(22)
    assert screen.page.evaluate("heard.voices") == before

    button.click()
    screen.page.reload()
    screen.ready()
    expect(button).to_have_attribute("aria-pressed", "true")
    expect(screen.page.locator("#volume")).to_have_value("35")
    assert screen.page.evaluate("heard.contexts") == 0, "nobody has touched this page yet"
    screen.page.keyboard.press("Space")
    expect(screen.rows).to_have_count(23)
    assert screen.page.evaluate("heard.voices") > 0
    expect(screen.page.locator("#offer")).to_be_hidden()


def test_the_harder_the_impact_the_louder_the_sound(run: Run) -> None:
    loud = run(
        "play/sound/voice.js",
        """async ({ strike }) => {
          const { toneOf } = await import("/js/play/sound/tones.js");
          const heard = [];
          for (const speed of [0.3, 1, 3, 6]) {
            const context = new OfflineAudioContext(2, 9600, 48000);
            const tone = toneOf({ kind: 0, speed, x: 0 }, { left: -1, right: 1 });
            strike(context, context.destination, tone, 0, () => {});
            const sound = await context.startRendering();
            const data = sound.getChannelData(0);
            heard.push(Math.sqrt(data.reduce((sum, one) => sum + one * one, 0) / data.length));
          }
          const soft = toneOf({ kind: 0, speed: 0.1, x: 0 }, { left: -1, right: 1 });
          return { heard, soft };
        }""",
    )
    assert loud["soft"] is None
    assert loud["heard"] == sorted(loud["heard"])
    assert loud["heard"][-1] > 5 * loud["heard"][0] > 0


def test_light_or_dark_as_the_player_says_on_every_page(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    ground = "getComputedStyle(document.documentElement).getPropertyValue('--page')"
    light = screen.page.evaluate(ground)
    screen.drawer("Settings").get_by_role("radio", name="Dark").check()
    dark = screen.page.evaluate(ground)
    assert dark != light
    screen.page.goto(f"{screen.url}/map.html")
    screen.page.wait_for_function(f"dark => {ground} === dark", arg=dark)


def test_ghost_trails_stay_where_balls_have_been_and_can_be_turned_off(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page, before=COUNT_FRAMES).ready()
    ghost = screen.page.locator("#board-ghost")
    assert painted(screen, "board-ghost") == 0
    screen.page.get_by_role("radio", name="5 balls").check()
    screen.drop.click()
    expect(screen.rows).to_have_count(5)
    screen.ready().at_rest()
    after_five = painted(screen, "board-ghost")
    assert after_five > 1000
    size = ghost.evaluate("canvas => canvas.width * canvas.height")
    screen.drop.click()
    expect(screen.rows).to_have_count(10)
    screen.ready().at_rest()
    assert painted(screen, "board-ghost") > after_five
    assert ghost.evaluate("canvas => canvas.width * canvas.height") == size
    screen.shot("ghost-trails")

    button = screen.drawer("Lab").get_by_role("button", name="Ghost trails")
    button.click()
    expect(ghost).to_be_hidden()
    screen.page.reload()
    screen.ready()
    screen.drawer("Lab")
    expect(button).to_have_attribute("aria-pressed", "false")
    landed = screen.rows.count()
    screen.drop.click()
    expect(screen.rows).to_have_count(landed + 5)
    screen.ready().at_rest()
    assert painted(screen, "board-ghost") == 0
    button.click()
    expect(ghost).to_be_visible()


def test_a_shower_of_results_is_told_in_one_sentence(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_role("radio", name="20 balls").check()
    screen.drop.click()
    expect(screen.result).to_contain_text(re.compile(r"^20 balls: [\d.]+ back for 20\.$"))
    expect(screen.page.locator("#staked")).to_have_text("20")
