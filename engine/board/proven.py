"""Which boards are known to be playable: the presets, by the digests of their content.

Whether a board can be played takes tens of milliseconds to decide, and for a preset the answer is
always the same. A test makes every preset, checks it, and holds this table to exactly their
digests: whoever changes a preset, or adds one, copies the new row from what that test prints.
"""

from types import MappingProxyType
from typing import Final

DIGESTS: Final = MappingProxyType(
    {
        "triangle-8": "481ec8ac9961ffccebaf2d7fea5e230d6126fb05b44d6e32d7a8011841e4023d",
        "triangle-8-low": "c93c03698be04470b72c56f3f4cb544b80faa37d90019e1e175857523d22badb",
        "triangle-8-high": "e2d3eed0834f041b278535b908fb95f3c7bf1a47970268af1ef17694613b3dfe",
        "triangle-9": "337feb2f984c43213ffb07e5d51f62e8ec70809dcde6f9e0ec4cf750be135269",
        "triangle-9-low": "dfb7adf212cfb7e0c05cee28065c60a4dc1bf9f858e2e821ac96431f78901a3d",
        "triangle-9-high": "46e54420bcd67ae1db45c8742d6eb576aee9e2b0c51bb0c67ebe435299cdb9d6",
        "triangle-10": "9b4056da37e3e3c43c618c7b574ab47b7f8ba0e1adee743091e872590b4bab11",
        "triangle-10-low": "1878deb6a960c32fa14df4e6d2b5d1fe6ffef5765b2080817dfee1a7c6da2d73",
        "triangle-10-high": "e0228b18c15314fd2b5757523e5858836eb0da98f0bd51e7f2991a0572c1bf00",
        "triangle-11": "649b44c062a82c4e498f05abc43b4d506fd33ef245cbe52f8f70ab3d90f68804",
        "triangle-11-low": "7c27cbf010c7727b190b3488111aa6a2b8ae4b6c52320876034253fc34a2cb02",
        "triangle-11-high": "d48567a305e5dd3098796c90110f81cc960135220bc207125108d7dbf097cf88",
        "triangle-12": "e1d2833a132fb706fbbdccf40d5293b72097b70903290a358bd2ce4bf4141080",
        "triangle-12-low": "0d035e3ffd472d41ae05e00b29ffb4f1c8259558815e495f32bd4e4eabb0b265",
        "triangle-12-high": "5b13d9a9740862347985fe061b1d10e6862b63f241872347b69338b86997d3a3",
        "triangle-13": "ccb4779076382dabb01466afb993bc960b421d61631670773477f4bab8853430",
        "triangle-13-low": "367a789c36ef9bf34e1c828d3b5fe428c1cf1404b1752b76f7e1be1096d390e9",
        "triangle-13-high": "f92c5558a4a53936695d3b34591a4e468e4a09c0c0a9ea49bc4572cb08eb91fc",
        "triangle-14": "9220ae787af090d89292f7d3f7f981f8028552c46c08c9d0934864e08e6bb798",
        "triangle-14-low": "5073bd21508d6c769173046fa07f762e0aa8a3f921b122112e50c742c1aff6cc",
        "triangle-14-high": "b27218029ccb6e7f8f7f4aca9082b0cc5fcbed4b203bbb206b23af0ad330ef1b",
        "triangle-15": "b9cdff228c892330161af94b0d562a75e912e151702927ea22d18bec331996a7",
        "triangle-15-low": "c3b7f64563b0dc9be103f5927c96329033628c1150978b7e6a08660fddb10295",
        "triangle-15-high": "a45cbb040661b9d45ee67c3a6e68eb9392c3f3f9aaa1134938c06cbf3aa141f8",
        "triangle-16": "c4fb48c2dde382a7fad0d4900b68528ea4bdbcd178c738863b941f310d1131f8",
        "triangle-16-low": "9398a60e5786aa2876647acf7f13bf8ff460400e62de565b2a21ff0d709b74ac",
        "triangle-16-high": "6f549873002dd5f84ff5cc5bd56a491148dad9515ca23cd939b55558703fd7de",
        "classic": "7220f6a79d55febc8063642756d9b54096b43bd173377e12aa6455e32aefc1d0",
        "galton": "94f0c3b7db1ba93f81771ada4ccfb00f988dcf0c922a24a9019158b6d506b53f",
    }
)
"""Name of each preset: SHA-256 of its content, 64 hex digits."""
