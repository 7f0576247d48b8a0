"""The engine compared with the literature: each figure, the published figure, and the error."""

from collections.abc import Callable
from dataclasses import asdict
from math import sqrt
from typing import Any

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.literature import galton, lorentz, siam, textbook
from benchmarks.literature.finding import Finding, statistical, table
from benchmarks.literature.galton import GaltonBoard
from benchmarks.literature.gas import cost_of_an_impact
from benchmarks.literature.lorentz import LorentzGas

MACHTA_ZWANZIG = "Machta and Zwanzig, Phys. Rev. Lett. 50, 1959 (1983)"
CHERNOV = "Chernov, J. Stat. Phys. 88, 1 (1997): π · area / perimeter"
CHERNOV_DOLGOPYAT = "Chernov and Dolgopyat, J. Amer. Math. Soc. 22, 821 (2009)"
BORNEMANN = "Bornemann et al., The SIAM 100-Digit Challenge (2004), problem 2"

DIGITS = (10, 30, 100, 1000)
"""Numbers of digits to prove."""


def run(effort: Effort) -> Section:
    section = Section("literature")
    _textbook(section, effort)
    _siam(section, effort)
    gases = [
        lorentz.measure(gap, effort.size(2000, 60), effort.size(600, 6), effort)
        for gap in lorentz.GAPS
    ]
    _lorentz(section, gases)
    _galton(section, galton.measure(effort.size(1000, 200), effort.size(10_000, 1000), effort))
    cost_of_an_impact(section, effort)
    return section


def _textbook(section: Section, effort: Effort) -> None:
    """Cases that should be right up to rounding."""
    findings = [
        *(textbook.orbit_multiplier(spacing, 1.0) for spacing in (2.5, 3.0, 6.0, 20.0)),
        *(textbook.slider_leaves(speed) for speed in (0.01, 0.3, 1.0)),
        *(textbook.roller_leaves(friction, 0.01) for friction in (0.1, 0.3, 1.0, 3.0, 10.0)),
        *(textbook.falls_with_drag(k, t) for k, t in ((5.0, 0.01), (0.3, 2.0), (2.0, 30.0))),
        *(textbook.bounces_end(e, 1.0) for e in (0.2, 0.5, 0.8, 0.95)),
        textbook.cradle(5, 2.0),
    ]
    effort.step("textbook")
    notes = [
        "Off by: the relative difference, for what rolls off with friction the difference to the "
        "limit of much friction, which falls as one over the friction."
    ]
    _add(section, "textbook", "To rounding", findings, notes)


def _siam(section: Section, effort: Effort) -> None:
    """Problem 2, in double precision and with proof; the proof needs python-flint."""
    found = siam.in_double_precision()
    rows = [
        ["published", _shown(siam.TRUTH), "", ""],
        ["double precision", f"{found.distance:.16f}", f"{found.error:.1e}", ""],
        ["its own estimate", "", f"{found.estimate:.1e}", ""],
    ]
    data: dict[str, Any] = {"double": asdict(found), "certified": []}
    try:
        from benchmarks.literature import photon
    except ImportError as error:
        section.absent.append(f"proven digits: {error}; pip install '.[certify]'")
    else:
        for digits in DIGITS:
            proven = photon.with_digits(digits)
            data["certified"].append(asdict(proven) | {"asked": digits})
            bound = f"proven < {0.5 * 10.0**-digits:.0e}" if digits < 300 else "proven"
            rows.append(
                [
                    f"certified, {digits} digits",
                    _shown(proven.text),
                    bound,
                    f"{1e3 * proven.seconds:.0f} ms",
                ]
            )
        section.plots["bench-digits.png"] = _digits_plotter(section, effort)
    section.data["siam"] = data
    section.tables.append(
        Table(
            "SIAM 100-Digit Challenge, problem 2: where the photon is at t = 10",
            ["", "distance from the origin", "off by", "time"],
            rows,
            [
                f"{found.reflections} reflections off mirrors of radius 1/3 multiply what rounding "
                "does to the first: double precision keeps five of its sixteen digits. Time: from "
                f"nothing, precision doubled until all are proven. {BORNEMANN}."
            ],
        )
    )


def _shown(digits: str) -> str:
    return digits if len(digits) <= 34 else f"{digits[:34]}…"


def _digits_plotter(section: Section, effort: Effort) -> Callable[[str], None]:
    """Measure error against cost now; the returned function draws it later."""
    from benchmarks.literature import digits, digits_plot

    drops, photon = digits.of_drops(effort), digits.of_the_photon(effort)
    section.data["digits"] = {
        "drops": [asdict(point) for point in drops],
        "photon": [asdict(point) for point in photon],
    }
    return lambda path: digits_plot.draw(drops, photon, path)


def _lorentz(section: Section, gases: list[LorentzGas]) -> None:
    paths = [
        statistical(
            f"w = {gas.gap:.4g}: mean free path",
            lorentz.mean_free_path(gas.gap),
            6,
            gas.path,
            CHERNOV,
        )
        for gas in gases
    ]
    exponents = [_lyapunov(gas) for gas in gases]
    walks = [_diffusion(gas) for gas in gases]
    drift = max(gas.speed_drift for gas in gases)
    impacts = sum(gas.impacts for gas in gases)
    notes = [
        f"Points of speed 1 among discs of radius 1, 2 + w apart; {impacts:,} impacts in all, "
        "standard errors over balls in brackets. σ: standard errors of both sides together. The "
        "estimate of Machta and Zwanzig is exact as w goes to 0; what the true coefficient "
        "differs by from it is known (Klages and Dellago, J. Stat. Phys. 101, 145 (2000)) and no "
        f"error of ours. No ball's speed changed by more than {drift:.0e}."
    ]
    _add(section, "lorentz", "The triangular Lorentz gas", [*paths, *exponents, *walks], notes)
    section.data["lorentz_diffusion"] = [
        {"gap": gas.gap, "value": gas.diffusion.value, "error": gas.diffusion.error}
        for gas in gases
    ]


def _lyapunov(gas: LorentzGas) -> Finding:
    value, error = lorentz.LYAPUNOV[gas.gap]
    off = abs(gas.lyapunov.value - value) / sqrt(gas.lyapunov.error**2 + error**2)
    return Finding(
        f"w = {gas.gap:.4g}: Lyapunov exponent", f"{value:.4f}({round(error * 1e4)})",
        str(gas.lyapunov), f"{off:.1f} σ", "an independent program", off,
    )  # fmt: skip


def _diffusion(gas: LorentzGas) -> Finding:
    wanted = lorentz.machta_zwanzig(gas.gap)
    ratio = gas.diffusion.value / wanted - 1.0
    return Finding(
        f"w = {gas.gap:.4g}: diffusion coefficient", f"≈ {wanted:.4f}", str(gas.diffusion),
        f"{ratio:+.0%}", MACHTA_ZWANZIG, ratio,
    )  # fmt: skip


def _galton(section: Section, found: GaltonBoard) -> None:
    findings = [
        statistical(
            "speed grows as t to the", 1.0 / 3.0, 4, found.speed_exponent, CHERNOV_DOLGOPYAT
        ),
        statistical(
            "depth grows as t to the", 2.0 / 3.0, 4, found.depth_exponent, CHERNOV_DOLGOPYAT
        ),
    ]
    notes = [
        f"{found.depths.shape[1]:,} elastic points that start with speed 1 in a lattice of discs, "
        f"w = {galton.GAP:g}, under gravity {galton.GRAVITY:g}, to t = {found.times[-1]:,.0f}: "
        f"{found.impacts:,} impacts. Exponents of the mean, over the last hundredfold of time. "
        f"{found.returned:.0%} of the balls came back up to half of their depth in it. Energy, "
        f"relative to the largest kinetic energy: within {found.energy_drift:.0e}."
    ]
    _add(section, "galton", "The elastic Galton board", findings, notes)
    section.plots["bench-galton-board.png"] = lambda path: _plot(found, path)


def _add(section: Section, key: str, title: str, findings: list[Finding], notes: list[str]) -> None:
    section.tables.append(table(title, findings, notes))
    section.data[key] = [finding.to_dict() for finding in findings]


def _plot(found: GaltonBoard, path: str) -> None:
    from benchmarks.literature import galton_plot

    galton_plot.draw(found, path)
