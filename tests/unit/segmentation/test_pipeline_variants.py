"""Real heads as other scanners would have taken them: the tumor is found all the same."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.segmentation.cases import real_cases
from benchmarks.segmentation.variants import measure

pytestmark = [pytest.mark.data, pytest.mark.slow]


@pytest.mark.parametrize(
    ("variant", "least"),
    [
        ("slices of 3 mm", 0.80),
        ("blurred to 2.5 mm", 0.78),
        ("after contrast, power 1.4", 0.80),
        ("coils that differ", 0.76),
    ],
)
def test_a_tumor_near_a_sinus_is_kept_apart_from_it(shared_data: Path, variant: str, least: float) -> None:
    # Here the sinus and the meninges are as bright as the tumor, and a step away from it.
    (case,) = (case for case in real_cases(shared_data / "volumes") if case.name == "brats21_00006")
    row = measure(case, variant)
    assert row["false_objects"] == 0
    assert row["enhancing"]["iou"] >= least
