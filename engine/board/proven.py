"""Digests of the presets, which are known to be playable and skip the check.

The check takes tens of milliseconds, and its result for a preset is always the same. A test checks
every preset, and that this table has exactly their digests. After changing or adding a preset,
copy the row that the failing test prints. Those of the worlds are next to their payouts.
"""

from types import MappingProxyType
from typing import Final

from plinko.engine.board import worlds

DIGESTS: Final = MappingProxyType(
    {
        **{name: table.digest for name, table in worlds.tables().items()},
        "triangle-8": "01b3cd064f62e669bda026694b4120e8f03c69b797d60085ef1fb508eabdf817",
        "triangle-8-low": "ba9bd5387afc752d03e3cd61bb7c245702533a732a8f622e498d67c306131ac7",
        "triangle-8-high": "7193976bb580397df5923b073dd430bae1ca1894f9a785e0c9ddf2418dfa81e1",
        "triangle-9": "ae5f022015b48ad7eb180b8e4977f536cee4185b36519db89175826d47ab9d19",
        "triangle-9-low": "344a4b6392172a79d815aca97010dd418650fc821da61a18258c296c2334bc03",
        "triangle-9-high": "031cd74b3eae661ae103673c1a3f108d0ae425373817787cc47f53cd1f04a1df",
        "triangle-10": "df2c2d58b0aa0851548a2ab8942edd5b03a135069c4b148449b125504ce9fbd9",
        "triangle-10-low": "ec9719c83daecaa4a4b9e502aa764be2b4a9ce3302b58a96569826fa541b4799",
        "triangle-10-high": "0999a1cbe65d2d9cb66bd967bf8f1d06573be31ad4f678ee0d462755899cb828",
        "triangle-11": "798a5696f68e2ddfa8191da10d35411b6396147e4d6814cea66f48bb60bcd246",
        "triangle-11-low": "c1395af3176c2c2c3dc7ffbf7e570fff5e957cf45d8913f8b04d7404a3ed3721",
        "triangle-11-high": "4fa0dd13c50d94cf90dcbdb5fea8a0d7084de4b20c3427705e10a517b7b8919b",
        "triangle-12": "e7bc27b9bc80c968009242e5afe195a1cfb6afaa01e75b33bb21efb111a1c1e5",
        "triangle-12-low": "ba5c3a4d9664b5b2abb3e6c66547715a2291f65e94e6d6e97809a2c8fe05a906",
        "triangle-12-high": "fefb58d21863902e6629e2f8d598bff158fe97dd6a4ba15dd5afd218d5d00996",
        "triangle-13": "792891954dfa1b2a55d2b80a7b57614efd0aee352ef0aa7f2cc0e592a56240ee",
        "triangle-13-low": "60f3685324f960ac783813f23c831471a42249001d22008f12eed39953a1573f",
        "triangle-13-high": "9984d1242e0a6349b4fe847569ee093a208496d29b68d5c7901247250118882b",
        "triangle-14": "bca1675cd4aa65f3ffab31122ad83cdf6000b7e4dd4e55ff7f8a3ccda048b55e",
        "triangle-14-low": "32df83acdf77c29a9bed55853cdecdf8f3e36e5cf977cc8e9717cf0444a3f5fe",
        "triangle-14-high": "e4c5a48e3303c36e2c1c5a08ebbfb1376d57898c9548f1e2a08587a60e7783de",
        "triangle-15": "f1b2b290c32a09aec77a1ec694205a9f69b1c304f55840801283f9c6c06d2669",
        "triangle-15-low": "2195b808f862d3cd68f31c3cffe20135226a0e0b09b26c49acf411361fb8b9af",
        "triangle-15-high": "cba4114e2c0ecb569ae24eb2ea9bca6ca098311758fb3f06ed9dad5f6a62a1a7",
        "triangle-16": "46df2ec3ccda88b8deb45aafc0dc4e7ab959333753ada9795b391cfa2cbebc7a",
        "triangle-16-low": "744c095bb2c116ad79de247277b025d57713577c552c35d32465f357cd401d88",
        "triangle-16-high": "5448706eedb6d1c6b0b7896db4ccba8dac3a4c03373b06b2d4aa541bb8ce5f67",
        "classic": "aaf52121db6f4c6aeac12f847f083a3815d7af34527a691a1947e7954a29eefb",
        "galton": "e3f699a1b3b822869235e1f2f224a0a860b4c0bdada983beb38dec6c51346c3e",
    }
)
"""Name of each preset: SHA-256 of its content, 64 hex digits."""

NAMES: Final = MappingProxyType({digest: name for name, digest in DIGESTS.items()})
"""The name of each preset, by digest."""
