"""Vessels and bleedings around an object, as they are told and drawn."""

from __future__ import annotations

import time
from pathlib import Path

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_geometry.volume import Volume
from shapery_geometry.volume_io.nifti import write_nifti
from shapery_segmentation.phantoms import vessel_tree_phantom
from tests.e2e.dashboard.conftest import OpenPage
from tests.support.browser import eventually, picture, share_of

pytestmark = [pytest.mark.server, pytest.mark.browser, pytest.mark.slow]

COLORS = {
    "object": {"red": (120, 255), "green": (70, 180), "blue": (10, 90)},
    "vessels": {"red": (110, 255), "green": (20, 100), "blue": (30, 125)},
    "bleedings": {"red": (80, 200), "green": (60, 160), "blue": (140, 255)},
}


def test_vessels_and_bleedings_are_told_and_drawn(open_page: OpenPage, api: httpx.Client, tmp_path: Path) -> None:
    phantom = vessel_tree_phantom(
        np.random.default_rng(5), (64, 64, 64), polarity="dark", tumor_radius=7.0, microhemorrhages=2, snr=12.0
    )
    inside = phantom.truth.data == 1
    noise = np.random.default_rng(6).normal(0.0, 0.05, inside.shape)
    write_nifti(Volume((1.0 + inside + noise).astype(np.float32), phantom.truth.affine), tmp_path / "post.nii")
    write_nifti(phantom.volume, tmp_path / "swi.nii")
    inputs = {}
    for role, name in (("post", "post.nii"), ("vessels", "swi.nii")):
        answer = api.post("/v1/assets", files={"file": (name, (tmp_path / name).read_bytes())})
        inputs[role] = answer.json()["id"]
    seed = phantom.truth.to_world(np.argwhere(inside).mean(axis=0)).tolist()
    params = {"mode": "object", "seeds": [seed], "register_volumes": False}
    job = api.post("/v1/jobs", json={"kind": "segmentation", "inputs": inputs, "params": params}).json()
    end = time.monotonic() + 240
    while job["state"] in {"queued", "running"}:
        assert time.monotonic() < end
        time.sleep(0.3)
        job = api.get(f"/v1/jobs/{job['id']}").json()
    assert job["state"] == "succeeded", job["error"]
    page = open_page(f"/jobs/{job['id']}")
    bleedings = len(job["result"]["microhemorrhages"])
    assert bleedings >= 1
    page.get_by_role("heading", name=f"{bleedings} microhemorrhage").wait_for()
    page.get_by_role("button", name="Vessel 1", exact=True).wait_for()
    for name in ("Volume", "Surface"):
        page.locator(f"section[aria-label={name}][data-status=ready]").wait_for()
    page.get_by_text("3D", exact=True).click()
    for canvas in ("volume", "surface"):
        eventually(lambda canvas=canvas: check_colors(picture(page.get_by_test_id(canvas)), canvas))


def check_colors(pixels: NDArray[np.uint8], canvas: str) -> None:
    for what, box in COLORS.items():
        assert share_of(pixels, **box).sum() > 60, f"{what} in the {canvas}'s picture"
