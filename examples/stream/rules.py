"""The rules of a show: one TOML file, parsed once. README.md explains them."""

import sys
import tomllib
from pathlib import Path
from typing import Annotated, Any

import msgspec

Count = Annotated[int, msgspec.Meta(ge=0, le=1000)]
Positive = Annotated[float, msgspec.Meta(gt=0)]


class Part(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """A table of the rules."""


class Game(Part):
    server: str = "http://127.0.0.1:8000"
    board: str = "triangle-12-high"  # a preset, or a board's JSON file
    every: Positive = 0.3  # s between two balls
    falling: Annotated[int, msgspec.Meta(ge=1, le=100)] = 20  # balls at the same time
    journal: str = "kit.db"
    texts: str = ""  # the folder of the text files
    port: Annotated[int, msgspec.Meta(ge=0, le=65535)] = 8020  # of the address for other programs


class Twitch(Part):
    client_id: str
    client_secret: str = ""  # or TWITCH_SECRET in the environment
    api: str = "https://api.twitch.tv/helix/"
    auth: str = "https://id.twitch.tv/oauth2/"
    socket: str = "wss://eventsub.wss.twitch.tv/ws"


class Obs(Part):
    address: str = "ws://127.0.0.1:4455"
    password: str = ""  # or OBS_PASSWORD in the environment
    stage: str = ""  # the browser source that shows the stage
    sounds: str = ""  # the media source that plays sounds
    folder: str = "sounds"  # of their files


class Effects(Part):
    timer: float = 0.0  # s added
    pause: bool | None = None  # stops the timer, or starts it again
    goals: dict[str, float] = {}  # added, by goal
    jackpot: float = 0.0  # added
    pay: bool = False  # the jackpot begins again
    again: Annotated[int, msgspec.Meta(ge=0, le=100)] = 0  # balls for the same viewer
    say: str = ""  # with {name}, {jackpot}, and after a landing {bin} and {score}
    scene: str = ""
    source: str = ""  # of the current scene
    seconds: Positive = 8.0  # until the former scene, or until the source is hidden
    sound: str = ""  # a file


class Input(Effects):
    balls: Count = 1
    per: Positive | None = None  # bits or money that `balls` cost; the rest is kept
    every: float = 0.0  # s for each viewer
    mods: bool = False  # only for moderators


class Landing(Effects):
    bin: list[int] | None = None
    label: str | None = None
    least: float = 0.0  # multipliers
    most: float = float("inf")

    def fits(self, landed: dict[str, Any]) -> bool:
        return (
            landed["bin"] is not None
            and (self.bin is None or landed["bin"] in self.bin)
            and (self.label is None or landed.get("label") == self.label)
            and self.least <= landed["score"] <= self.most
        )


class Figure(Part):
    start: float = 0.0
    label: str = ""
    unit: str = ""


class Goal(Part):
    target: Positive
    reached: Effects = msgspec.field(default_factory=Effects)


class Looks(Part):
    panel: str | None = None
    ink: str | None = None
    accent: str | None = None
    font: str | None = None
    logo: str | None = None  # a file
    options: str = ""  # of the stage's address
    faces: bool = True  # avatars and emoji as balls


class Rules(Part):
    game: Game = msgspec.field(default_factory=Game)
    twitch: Twitch | None = None
    obs: Obs | None = None
    inputs: dict[str, Input] = msgspec.field(default_factory=dict, name="in")
    timer: Figure | None = None
    jackpot: Figure | None = None
    goals: dict[str, Goal] = {}
    landing: list[Landing] = []
    looks: Looks = msgspec.field(default_factory=Looks)

    def __post_init__(self) -> None:
        if len(self.goals) > 4:
            raise ValueError(f"{len(self.goals)} goals: the stage shows at most 4")
        for effects in (*self.inputs.values(), *self.landing):
            for goal in effects.goals.keys() - self.goals.keys():
                raise ValueError(f'no goal has the name "{goal}": add [goals."{goal}"]')
            effects.say.format(name="", jackpot="", bin="", score="")
        for name in self.inputs.keys() & {"bits", "donation"}:
            if self.inputs[name].per is None:
                raise ValueError(f"[in.{name}] needs `per`: how much a ball costs")


def read_rules(file: Path) -> Rules:
    """The rules; exits with the line and the value that is wrong."""
    lines = file.read_text("utf-8").splitlines()
    try:
        return rules_of(lines)
    except tomllib.TOMLDecodeError as error:  # names the line
        sys.exit(f"{file}: {error}")
    except (msgspec.ValidationError, LookupError) as error:
        at = wrong_line(lines, str(error))
        sys.exit(f"{file}, line {at}, {lines[at - 1].strip()}: {error}")


def rules_of(lines: list[str]) -> Rules:
    return msgspec.convert(tomllib.loads("\n".join(lines)), Rules)


def wrong_line(lines: list[str], error: str) -> int:
    """The line from which on the rules have this error."""
    for at in range(len(lines) - 1, 0, -1):
        try:
            rules_of(lines[:at])
        except tomllib.TOMLDecodeError:
            continue  # a value of several lines
        except (msgspec.ValidationError, LookupError) as other:
            if str(other) == error:
                continue
        return at + 1
    return 1
