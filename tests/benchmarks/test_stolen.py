"""Time stolen by the host is separated from other processor time."""

from benchmarks.harness.stolen import Stolen, share_between


def test_stolen_time_is_its_part_of_all_that_passed() -> None:
    before = [100, 0, 50, 800, 5, 0, 5, 40]
    after = [150, 0, 60, 820, 5, 0, 5, 60]  # differences 50 + 10 + 20 + 20; the last is stolen
    assert share_between(before, after) == 0.2
    assert share_between(before, before) == 0.0


def test_this_machine_reports_stolen_time() -> None:
    stolen = Stolen()
    sum(range(10**6))
    assert 0.0 <= stolen.share() <= 1.0
