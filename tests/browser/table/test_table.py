"""Play with many balls: showers, auto-drop, stakes, keys, other worlds, sound, ghosts."""

import re

import pytest
from playwright.sync_api import expect

from plinko.engine import drop
from plinko.engine.board.materials import GRAVITY
from tests.browser.conftest import Open, Quick, Run, quick_table
from tests.browser.looks import painted
from tests.browser.screen import COUNT_FRAMES, Screen
from tests.kit.address import Address


def test_several_balls_of_one_push_have_one_seed_after_the_other(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_role("radio", name="5 balls").check()
    screen.seed.fill("18446744073709551613")
    screen.drop.click()
    expect(screen.rows).to_have_count(5)
    expect(screen.page.locator("#staked")).to_have_text("0.00")  # chosen seeds are practice
    assert [message["seed"] for message in screen.drops_sent] == [
        "18446744073709551613",
        "18446744073709551614",
        "18446744073709551615",
        "0",
        "1",
    ]
    expect(screen.result).to_contain_text(re.compile(r"^5 practice balls: [\d.]+x on average$"))


def auto(screen: Screen, **fields: str) -> None:
    """Choose auto-drop, and fill its fields by name."""
    screen.page.get_by_role("radio", name="Auto").check()
    for name, value in fields.items():
        field = screen.page.locator(f"#auto-{name}")
        field.select_option(value) if name == "rate" else field.fill(value)


def test_auto_drop_drops_its_count_and_reports_the_net(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    auto(screen, count="6", rate="2")
    expect(screen.drop).to_contain_text("Start auto")
    screen.drop.click()
    expect(screen.drop).to_contain_text("Stop")
    expect(screen.drop).to_contain_text("Start auto")
    expect(screen.result).to_have_text(re.compile(r"^Auto finished: 6 balls, [+−]?[\d.]+$"))
    expect(screen.page.locator("#staked")).to_have_text("6.00")
    assert len(screen.drops_sent) == 6
    screen.shot("auto-drop")


def test_auto_drop_without_an_end_goes_on_until_it_is_stopped(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    auto(screen, count="")
    screen.drop.click()
    expect(screen.rows.nth(3)).to_be_attached()
    screen.drop.click()
    expect(screen.drop).to_contain_text("Start auto")
    sent = len(screen.drops_sent)
    screen.frames(60)
    assert len(screen.drops_sent) == sent >= 4


def number(text: str) -> float:
    return float(text.replace("−", "-").replace("+", "").replace(",", ""))


def test_every_panel_reports_a_stopped_auto_drop_alike(opened: Open, server: Address) -> None:
    screen = opened(quick_table(server, "triangle-8", pays=0.4).page).ready()
    screen.page.get_by_role("radio", name="Instant").check()
    auto(screen, count="", rate="16", loss="5")
    screen.drop.click()
    expect(screen.result).to_contain_text("Stopped at your loss limit")
    text = re.match(r"^.*: (\d+) balls?, (.*)$", screen.result.inner_text())
    assert text
    balls, profit = int(text[1]), number(text[2])
    assert -5 <= profit < -4, "never more than the limit, and near it"
    page = screen.page
    expect(page.locator("#balls")).to_have_text(str(balls))
    expect(page.locator("#staked")).to_have_text(f"{balls:.2f}")
    shown = {name: number(page.locator(name).inner_text()) for name in ("#net", "#balance")}
    assert shown == {"#net": profit, "#balance": pytest.approx(1000 + profit)}
    returned = number(page.locator("#returned").inner_text())
    assert returned == pytest.approx(balls + profit)
    assert screen.rows.count() == min(balls, 30)
    assert len(screen.drops_sent) == balls, (
        "every ball is reported, also those in flight at the limit"
    )


def test_a_stake_is_counted_and_paid_back_by_the_bin(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.page.get_by_label("Stake", exact=True).fill("2,5")
    screen.drop.click()
    expect(screen.page.locator("#staked")).to_have_text("2.50")
    expect(screen.rows).to_have_count(1)
    score = screen.last_dropped()["score"]
    expect(screen.page.locator("#returned")).to_have_text(f"{2.5 * score:.2f}")
    won = f"{2.5 * score - 2.5:+.2f}".replace("-", "−").replace("+0.00", "0.00")
    paid = f"{2.5 * score:.2f}"
    expect(screen.result).to_have_text(f"{score:g}x: staked 2.50, won {paid} ({won})")


def test_a_landed_ball_can_be_shared_from_its_result(opened: Open, quick: Quick) -> None:
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
    key.evaluate("""key => {
      const look = () => { window.hid ||= !key.checkVisibility(); };
      new MutationObserver(look).observe(document, { subtree: true, attributes: true });
    }""")
    screen.drop.click()
    screen.page.wait_for_function("() => window.hid")


def test_an_instant_drop_is_final_at_once_and_counts_once(opened: Open) -> None:
    screen = opened("/?room=triangle-16").ready()
    screen.page.get_by_role("radio", name="Instant").check()
    screen.drop.click()
    expect(screen.result).to_contain_text(re.compile(r"^[\d.]+x: staked 1.00, won "))
    expect(screen.page.locator("#staked")).to_have_text("1.00")
    expect(screen.rows).to_have_count(1)
    paid = screen.page.locator("#returned").inner_text()
    screen.state("live")
    screen.page.reload()  # in mid-flight
    screen.ready()
    expect(screen.rows).to_have_count(1)
    expect(screen.page.locator("#returned")).to_have_text(paid)
    expect(screen.page.locator("#balls")).to_have_text("1")
    expect(screen.page.get_by_role("radio", name="Instant")).to_be_checked()


def test_a_bad_stake_drops_nothing_is_marked_and_explained(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    field = screen.page.get_by_label("Stake", exact=True)
    fault = screen.page.locator("#fault")
    canvas = screen.page.get_by_role("img", name=re.compile("Plinko board"))
    for stake in ("0", "-5", "", "abc", "9e9"):
        said = f"“{stake}”" if stake else "missing"
        field.fill(stake)
        field.press("Enter")
        expect(fault).to_contain_text(said)
        expect(fault).to_contain_text("Stakes go from 0.01 to 1,000,000.")
        expect(field).to_have_attribute("aria-invalid", "true")
        expect(field).to_have_value(stake)
        screen.drop.click()
        canvas.click(position={"x": 200, "y": 20})
        expect(field).to_be_focused()
    assert screen.drops_sent == []
    field.fill("3")
    expect(fault).to_be_hidden()
    field.press("End")  # the keyboard's field, not a clicked one
    field.press("Space")
    expect(field).to_have_value("3")
    assert screen.drops_sent == []
    field.press("Enter")
    expect(screen.page.locator("#staked")).to_have_text("3.00")


def test_a_bad_field_of_auto_starts_nothing(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    for name, value, good in (
        *(("count", value, "2") for value in ("0", "-3", "abc")),
        ("loss", "-1", "1"),
        ("win", "x", ""),
    ):
        auto(screen, **{name: value})
        screen.drop.click()
        expect(screen.page.locator(f"#auto-{name}")).to_be_focused()
        expect(screen.page.locator("#fault")).to_contain_text(f"“{value}”")
        expect(screen.drop).to_contain_text("Start auto")
        auto(screen, **{name: good})
    assert screen.drops_sent == []


def test_back_closes_a_drawer_on_a_phone_before_it_leaves(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, viewport={"width": 390, "height": 844}).ready()
    screen.drawer("For the curious")
    screen.page.go_back()
    expect(screen.page.locator("#sheet")).to_be_hidden()
    assert screen.page.url.endswith(quick.page)


def test_space_presses_a_focused_button_and_drops_whatever_was_clicked(
    opened: Open, quick: Quick
) -> None:
    screen = opened(quick.page).ready()
    more = screen.page.locator("#more")
    keyboard = screen.page.keyboard
    more.focus()
    keyboard.press("Space")
    expect(more).to_have_attribute("aria-expanded", "true")
    keyboard.press("Space")
    expect(more).to_have_attribute("aria-expanded", "false")
    assert screen.drops_sent == []
    screen.page.get_by_role("radio", name="5 balls").check()
    keyboard.press("Space")  # the focused radio button is chosen already, so Space drops
    expect(screen.rows).to_have_count(5)
    screen.page.get_by_role("radio", name="1 ball", exact=True).check()
    for count, clicked in enumerate(("#stake-half", "#sound", "#stats-title"), start=6):
        screen.page.locator(clicked).click()
        keyboard.press("Space")
        expect(screen.rows).to_have_count(count)
    assert len(screen.drops_sent) == 8
    expect(screen.page.get_by_label("Stake", exact=True)).to_have_value("0.5")


def test_arrow_keys_go_from_slot_to_slot_of_classic_s_nine(opened: Open) -> None:
    screen = opened().ready()
    screen.page.get_by_label("Rows", exact=True).select_option("Classic")
    screen.drawer("Table")
    expect(screen.page.get_by_role("radio", name=re.compile("^Slot"))).to_have_count(9)
    screen.ready()
    screen.page.locator("#result").click()
    screen.page.keyboard.press("ArrowRight")
    expect(screen.page.get_by_role("radio", name="Slot 5")).to_be_checked()
    screen.page.keyboard.press("ArrowLeft")
    screen.page.keyboard.press("ArrowLeft")
    expect(screen.page.get_by_role("radio", name="Slot 3")).to_be_checked()
    expect(screen.page.locator("#start-words")).to_have_text("Slot 3.")


def test_the_table_is_locked_while_staked_balls_fall(opened: Open) -> None:
    screen = opened("/?room=triangle-16").ready()
    screen.staked(5)
    rows = screen.page.get_by_label("Rows", exact=True)
    expect(rows).to_be_disabled()
    expect(rows).to_have_attribute("title", "Locked until your balls land.")
    expect(screen.page.get_by_label("Risk", exact=True)).to_be_disabled()
    expect(screen.page.locator("#worlds").get_by_role("radio").first).to_be_disabled()
    expect(screen.page.locator("#staked")).to_have_text("0.00")  # nothing has landed
    expect(screen.rows).to_have_count(5)
    rows.select_option("8")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("House · 8")
    )
    assert screen.page.url.endswith("?room=triangle-8")


def test_balls_of_a_left_table_are_reported_with_its_board(opened: Open) -> None:
    screen = opened("/?room=triangle-16").ready()
    screen.page.evaluate("history.pushState(null, '', '?room=triangle-9')")
    screen.page.evaluate("history.back()")
    screen.staked(5)
    screen.page.evaluate("history.forward()")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("House · 9")
    )
    said = re.compile(r"^On House · 16: 5 balls, staked 5\.00, won [\d.]+ \([+−]?[\d.]+\)$")
    expect(screen.result).to_have_text(said)
    expect(screen.rows).to_have_count(5)


def test_another_language_finds_the_drawer_open(opened: Open) -> None:
    screen = opened("/?room=triangle-8").ready()
    screen.drawer("Settings").get_by_label("Language").select_option("Deutsch")
    expect(screen.page.locator("html[lang=de]")).to_be_attached()
    expect(screen.page.locator("#settings")).to_be_visible()


def test_a_win_of_five_stakes_has_a_moment_and_less_has_none(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    watch = """() => {
      window.moment = null;
      const banner = document.getElementById("banner");
      const see = () => { window.moment = banner.textContent; };
      new MutationObserver(see).observe(banner, { attributeFilter: ["hidden"] });
    }"""
    scores = {seed: drop(quick.whole, seed).score for seed in range(100)}
    less = next(seed for seed, score in scores.items() if score < 5)
    more = next(seed for seed, score in scores.items() if score >= 5)
    screen.page.evaluate(watch)
    for seed, words in ((less, None), (more, f"{scores[more]:g}x")):
        screen.seed.fill(str(seed))
        screen.drop.click()
        expect(screen.result).to_have_text(f"{scores[seed]:g}x (practice)")
        screen.frames(6)
        expected = "moment !== null" if words else "moment === null"
        screen.page.wait_for_function(f"() => {expected}")
        assert screen.page.evaluate("moment") == words


def test_a_world_is_a_table_of_its_own_with_its_payouts(opened: Open) -> None:
    screen = opened("/?room=triangle-16-high").ready()
    page = screen.page
    house = page.locator("#worlds").get_by_role("radio", name="House")
    expect(house).to_be_checked()
    page.locator("#worlds").get_by_role("radio", name="Moon").check()
    expect(page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("Moon · 16 · High")
    )
    assert page.url.endswith("?room=moon-16-high")
    (odds,) = screen.api("boards/moon-16-high/odds")["aims"]
    expect(page.locator("#odds-note")).to_contain_text(f"Average return {odds['return']:.2%}"[:-2])
    expect(screen.root).to_have_attribute("data-ground", "craters")
    expect(screen.root).not_to_have_attribute("data-practice", re.compile(""))
    screen.drop.click()
    expect(page.locator("#staked")).to_have_text("1.00")
    # The risk and the rows stay in the world.
    screen.ready()
    page.get_by_label("Risk", exact=True).select_option("low")
    moving = page.locator("#board-moving")
    expect(moving).to_have_attribute("aria-label", re.compile("Moon · 16 · Low"))
    house.check()
    expect(moving).to_have_attribute("aria-label", re.compile("House · 16 · Low"))


def test_what_is_not_solved_says_practice(opened: Open) -> None:
    screen = opened("/?room=galton").ready()
    expect(screen.root).to_have_attribute("data-practice", "unsolved")
    expect(screen.page.locator("#practice-note")).to_have_text("Practice: no stakes on this board")
    expect(screen.page.locator("#odds-note")).to_have_text("")
    screen.drop.click()
    expect(screen.page.locator("#balance")).to_have_text("1,000.00")


def test_a_fortune_moves_nothing(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, viewport={"width": 1280, "height": 800}).ready()
    places = """() => ["drop", "stake", "worlds", "net"].map((id) => {
      const { x, y, height } = document.getElementById(id).getBoundingClientRect();
      return [id, x, y, height];
    })"""
    before = screen.page.evaluate(places)
    screen.page.evaluate("""() => {
      for (const id of ["balance", "staked", "returned", "net"]) {
        const field = document.getElementById(id);
        field.textContent = "1,000,000,000.00";
        field.style.setProperty("--letters", "16");
      }
      document.getElementById("result").textContent = "20 balls: staked 20, won 23.20 (+3.20)";
    }""")
    assert screen.page.evaluate(places) == before
    balance = screen.page.locator("#balance").bounding_box()
    assert balance is not None
    assert balance["x"] + balance["width"] <= 1280


def test_another_gravity_and_material_make_a_table_of_their_own(opened: Open) -> None:
    screen = opened("/?room=triangle-8").ready()
    screen.drawer("Table")
    screen.page.get_by_text("Custom gravity and material").click()
    screen.page.get_by_label("Gravity").select_option("Jupiter")
    expect(screen.root).to_have_attribute("data-state", "asleep")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("House · 8 · Jupiter")
    )
    expect(screen.root).to_have_attribute("data-ground", "bands")
    expect(screen.root).to_have_attribute("data-practice", "unsolved")
    screen.page.get_by_label("Material").select_option("Rubber on concrete")
    expect(screen.page.locator("#board-moving")).to_have_attribute(
        "aria-label", re.compile("House · 8 · Jupiter · Rubber on concrete")
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

    # A friend who opens the link sees the same table and the same choice.
    friend = opened(f"/?room={room}").ready()
    expect(friend.page.get_by_label("Gravity")).to_have_value("Jupiter")
    expect(friend.page.get_by_label("Material")).to_have_value("Rubber on concrete")
    expect(friend.page.get_by_label("Rows", exact=True)).to_have_value("8")
    expect(friend.root).to_have_attribute("data-ground", "bands")

    # The page finds the table again instead of creating a second one.
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
window.sounds = { contexts: 0, voices: 0, now: 0, most: 0 };
const Real = window.AudioContext;
window.AudioContext = class extends Real {
  constructor(...all) { super(...all); sounds.contexts += 1; window.speaker = this; }
  createOscillator() {
    const voice = super.createOscillator();
    sounds.voices += 1;
    sounds.now += 1;
    sounds.most = Math.max(sounds.most, sounds.now);
    voice.addEventListener("ended", () => { sounds.now -= 1; });
    return voice;
  }
};
"""


def test_sound_is_offered_once_and_off_until_asked_for(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=_LISTEN).ready()
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    assert screen.page.evaluate("sounds") == {"contexts": 0, "voices": 0, "now": 0, "most": 0}

    button = screen.page.get_by_role("button", name="Sound")
    expect(button).to_have_attribute("aria-pressed", "false")
    screen.page.get_by_label("Volume").first.fill("35")
    screen.page.get_by_role("button", name="Yes").click()
    screen.page.wait_for_function("() => window.speaker?.currentTime > 0")
    expect(screen.page.locator("#offer")).to_be_hidden()
    expect(button).to_have_attribute("aria-pressed", "true")
    screen.page.get_by_role("radio", name="20 balls").check()
    screen.drop.click()
    expect(screen.rows).to_have_count(21)
    sounds = screen.page.evaluate("sounds")
    assert sounds["contexts"] == 1
    assert sounds["voices"] > 20
    assert sounds["most"] <= 16

    button.click()
    before = screen.page.evaluate("sounds.voices")
    screen.page.get_by_role("radio", name="1 ball", exact=True).check()
    screen.drop.click()
    expect(screen.rows).to_have_count(22)
    assert screen.page.evaluate("sounds.voices") == before

    button.click()
    screen.page.reload()
    screen.ready()
    expect(button).to_have_attribute("aria-pressed", "true")
    expect(screen.page.locator("#volume")).to_have_value("35")
    assert screen.page.evaluate("sounds.contexts") == 0, "nobody has touched this page yet"
    screen.page.keyboard.press("Space")
    expect(screen.rows).to_have_count(23)
    assert screen.page.evaluate("sounds.voices") > 0
    expect(screen.page.locator("#offer")).to_be_hidden()


def test_sound_is_asked_for_once_a_visit_however_many_tabs(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.drop.click()
    expect(screen.page.locator("#offer")).to_be_visible()
    second = screen.page.context.new_page()
    second.goto(screen.page.url)
    expect(second.locator("html")).to_have_attribute("data-state", re.compile("live|asleep"))
    second.locator("#drop").click()
    expect(second.locator("#drops > li")).to_have_count(2)  # one of them in the first tab
    expect(second.locator("#offer")).to_be_hidden()
    second.get_by_role("button", name="Sound").click()
    expect(screen.page.locator("#offer")).to_be_hidden()
    expect(screen.page.get_by_role("button", name="Sound")).to_have_attribute(
        "aria-pressed", "true"
    )
    second.close()


def test_the_harder_the_impact_the_louder_the_sound(run: Run) -> None:
    sounds = run(
        "play/sound/sound.js",
        """async ({ Sound }) => {
          const ends = { walls: [], ball: { radius: 0.01 }, bins: { edges: [-1, 1] } };
          const board = { name: "", drop: { x: 0 }, ...ends };
          const sounds = [];
          for (const speed of [0.1, 0.3, 1, 3, 6]) {
            const context = new OfflineAudioContext(2, 9600, 48000);
            const sound = new Sound(context, { on: (name, heard) => heard({ hello: { board } }) });
            sound.on = true;
            sound.hear([{ kind: 0, speed, x: 0, t: 0 }], 0);
            const rendered = await context.startRendering();
            const data = rendered.getChannelData(0);
            sounds.push(Math.sqrt(data.reduce((sum, one) => sum + one * one, 0) / data.length));
          }
          return sounds;
        }""",
    )
    assert sounds[0] == 0, "a soft impact makes no sound"
    assert sounds == sorted(sounds)
    assert sounds[-1] > 5 * sounds[1] > 0


def test_light_or_dark_as_the_player_says_on_every_page(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    ground = "getComputedStyle(document.documentElement).getPropertyValue('--page')"
    light = screen.page.evaluate(ground)
    screen.drawer("Settings").get_by_role("radio", name="Dark").check()
    dark = screen.page.evaluate(ground)
    assert dark != light
    screen.page.goto(f"{screen.url}/verify.html")
    screen.page.wait_for_function(f"dark => {ground} === dark", arg=dark)


def test_ghost_trails_stay_and_can_be_turned_off(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page, before=COUNT_FRAMES).ready()
    screen.page.get_by_role("button", name="Pile", exact=True).click()  # discs would move for long
    ghost = screen.page.locator("#board-ghost")
    assert painted(screen, "board-ghost") == 0
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    screen.ready().at_rest()
    after_one = painted(screen, "board-ghost")
    assert after_one > 200
    size = ghost.evaluate("canvas => canvas.width * canvas.height")
    screen.drop.click()
    expect(screen.rows).to_have_count(2)
    screen.ready().at_rest()
    assert painted(screen, "board-ghost") > after_one
    assert ghost.evaluate("canvas => canvas.width * canvas.height") == size
    screen.shot("ghost-trails")

    button = screen.drawer("For the curious").get_by_role("button", name="Ghost trails")
    button.click()
    expect(ghost).to_be_hidden()
    screen.page.reload()
    screen.ready()
    screen.drawer("For the curious")
    expect(button).to_have_attribute("aria-pressed", "false")
    landed = screen.rows.count()
    screen.drop.click()
    expect(screen.rows).to_have_count(landed + 1)
    screen.ready().at_rest()
    assert painted(screen, "board-ghost") == 0
    button.click()
    expect(ghost).to_be_visible()
