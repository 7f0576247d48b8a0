"""Published test vectors of the scheme's building blocks."""

import hmac

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.fairness.seeds import drop_mac, drop_seed
from plinko.app.fairness.signing import Signer
from plinko.engine import merkle
from tools.fairness.sessions import Log

RFC_8032 = [  # secret, public, message, signature: 7.1, tests 1 to 3
    (
        "9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60",
        "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a",
        "",
        "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe24655141438e7a100b",
    ),
    (
        "4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb",
        "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c",
        "72",
        "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00",
    ),
    (
        "c5aa8df43f9f837bedb7442f31dcb7b166d38535076f094b85ce3a2e0b4458f7",
        "fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025",
        "af82",
        "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28dc027beceea1ec40a",
    ),
]
RFC_6962_LEAVES = [  # the leaves of Certificate Transparency's own tests
    bytes.fromhex(leaf)
    for leaf in (
        "", "00", "10", "2021", "3031", "40414243", "5051525354555657",
        "606162636465666768696a6b6c6d6e6f",
    )
]  # fmt: skip
RFC_6962_ROOTS = [
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
    "6e340b9cffb37a989ca544e6bb780a2c78901d3fb33738768511a30617afa01d",
    "fac54203e7cc696cf0dfcb42c92a1d9dbaf70ad9e621f4bd8d98662f00e3c125",
    "aeb6bcfe274b70a14fb067a5e5578264db0fa9b51af5e0ba159158f329e06e77",
    "d37ee418976dd95753c1c73862b9398fa2a2cf9b4ff0fdfe8b30cd95209614b7",
    "4e3bbb1f7b478dcfe71fb631631519a3bca12c9aefca1612bfce4c13a86264d4",
    "76e67dadbcdf1e10e1b74ddc608abd2f98dfb16fbce75277b5232a127f2087ef",
    "ddb89be403809e325750d3d263cd78929c2942b7942a34b77e122c9594a74c8c",
    "5dc9da79a70659a9ad559cb701ded9a2ab9d823aad2f4960cfe370eff4604328",
]


@pytest.mark.parametrize(("secret", "public", "message", "signature"), RFC_8032)
def test_signatures_are_those_of_rfc_8032(
    secret: str, public: str, message: str, signature: str
) -> None:
    signer = Signer(bytes.fromhex(secret))
    assert signer.public.hex() == public
    assert signer._key.sign(bytes.fromhex(message)).hex() == signature


def test_a_start_is_the_hmac_that_the_page_says() -> None:
    """The test computes the start from the formula in docs/fairness.md."""
    server, client, board = b"\x01" * 32, b"\x02" * 32, b"\x03" * 32
    message = b"plinko drop 1\n" + client + (5).to_bytes(8, "big") + board
    expected = hmac.new(server, message, "sha256").digest()
    assert drop_mac(server, client, 5, board) == expected
    assert drop_seed(server, client, 5, board) == int.from_bytes(expected[:8], "big")


def grown(leaves: list[bytes]) -> tuple[Log, list[bytes]]:
    log = Log()
    return log, [merkle.root(0, log.lookup), *map(log.add, leaves)]


def test_roots_and_proofs_are_those_of_certificate_transparency() -> None:
    log, roots = grown(RFC_6962_LEAVES)
    assert [root.hex() for root in roots] == RFC_6962_ROOTS
    assert [node.hex() for node in merkle.inclusion(0, 8, log.lookup)] == [
        "96a296d224f285c67bee93c30f8a309157f0daa35dc5b87e410b78630a09cfc7",
        "5f083f0a1a33ca076a95279832580db3e0ef4584bdff1f54c8a360f50de3031e",
        "6b47aaf29ee3c2af9af889bc1fb9254dabd31177f16232dd6aab035ca39bf6e4",
    ]
    assert [node.hex() for node in merkle.consistency(6, 8, log.lookup)] == [
        "0ebc5d3437fbe2db158b9f126a1d118e308181031d0a949f8dededebc558ef6a",
        "ca854ea128ed050b41b35ffc1b87b8eb2bde461e9e3b5596ece6b9d5975a0ae0",
        "d37ee418976dd95753c1c73862b9398fa2a2cf9b4ff0fdfe8b30cd95209614b7",
    ]


@given(st.integers(1, 40), st.data())
def test_each_proof_holds_and_no_other(size: int, data: st.DataObject) -> None:
    leaves = [bytes([i]) for i in range(size)]
    log, roots = grown(leaves)
    index = data.draw(st.integers(0, size - 1))
    proof = merkle.inclusion(index, size, log.lookup)
    assert merkle.is_included(leaves[index], index, size, proof, roots[size])
    assert not merkle.is_included(b"other", index, size, proof, roots[size])
    assert not merkle.is_included(leaves[index], index, size, [*proof, b"x" * 32], roots[size])
    for other in {0, size - 1} - {index}:
        assert not merkle.is_included(leaves[index], other, size, proof, roots[size])
    first = index + 1
    grew = merkle.consistency(first, size, log.lookup)
    assert merkle.is_consistent(first, size, roots[first], roots[size], grew)
    assert not merkle.is_consistent(first, size, b"\0" * 32, roots[size], grew)
    assert not merkle.is_consistent(first, size, roots[first], b"\0" * 32, grew)
    if grew:
        assert not merkle.is_consistent(first, size, roots[first], roots[size], grew[:-1])
