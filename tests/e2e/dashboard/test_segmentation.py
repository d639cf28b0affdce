"""The main walk from the user's side: two files dropped, a tumor seen; and that what is drawn is where it belongs."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_geometry.mesh_io import read_mesh
from shapery_geometry.volume import Volume
from shapery_geometry.volume_io import read_volume
from shapery_segmentation.evolution import read_evolution
from tests.e2e.dashboard.conftest import OpenPage
from tests.e2e.dashboard.left_behind import check_nothing_is_left
from tests.e2e.dashboard.segmentation_pictures import (
    box,
    check_slice,
    crosshair,
    silhouette,
    to_border,
    tumor_colored,
    vertices_of,
    wait_for_pictures,
)
from tests.e2e.dashboard.test_accessibility import check_open_to_everyone
from tests.support.browser import Watch, eventually, keep_picture, picture, until
from tests.support.volumes import write_series

pytestmark = [pytest.mark.server, pytest.mark.browser, pytest.mark.slow]

WORK = 240_000
"""Milliseconds that a segmentation may take when every kernel is compiled first, on a machine that is busy."""


@pytest.fixture(scope="module")
def segmented(chrome: Any, api: httpx.Client, phantom: Path) -> dict[str, Any]:
    """The job of a segmentation that was started in the browser: uploaded, chosen, watched over a reload."""
    page = chrome.new_context(viewport={"width": 1280, "height": 720}).new_page()
    page.set_default_timeout(WORK)
    watch = Watch(page)
    page.goto(f"{str(api.base_url).rstrip('/')}/upload")
    page.get_by_test_id("files").set_input_files([phantom / "pre.nii.gz", phantom / "post.nii.gz"])
    for name in ("pre.nii.gz", "post.nii.gz"):
        page.locator("li[data-state=done]", has_text=name).get_by_text("NIfTI").wait_for()
    # the names tell which is which
    wait_for_value(page, "After contrast", "post.nii.gz")
    wait_for_value(page, "Before contrast", "pre.nii.gz")
    page.get_by_role("button", name="Segment", exact=True).click()
    page.wait_for_url("**/jobs/*")
    job_id = page.url.rsplit("/", 1)[1]
    page.get_by_role("listitem").filter(has_text="Calibrate").wait_for()
    page.reload()
    page.locator("[data-state=succeeded], [data-state=failed], [data-state=crashed]").first.wait_for()
    job = api.get(f"/v1/jobs/{job_id}").json()
    assert job["state"] == "succeeded", job["error"]
    wait_for_pictures(page)
    assert watch.unexpected == []
    page.context.close()
    return dict(job)


@pytest.fixture
def labels(segmented: dict[str, Any], api: httpx.Client, tmp_path: Path) -> Volume:
    path = tmp_path / "labels.nii.gz"
    path.write_bytes(api.get(f"/v1/jobs/{segmented['id']}/artifacts/labels.nii.gz").content)
    return read_volume(path)


def wait_for_value(page: Any, label: str, value: str) -> None:
    field = page.get_by_role("combobox", name=re.compile(label))
    field.wait_for()
    page.wait_for_function("([field, value]) => field.value === value", arg=[field.element_handle(), value])


def test_a_folder_of_slices_is_segmented_and_drawn(open_page: OpenPage, api: httpx.Client, tmp_path: Path) -> None:
    """A bright ball in a DICOM series: the slices under the colored labels are those of the folder."""
    shape, center, radius = (48, 56, 40), np.array([20.0, 34.0, 18.0]), 9.0
    at = np.moveaxis(np.indices(shape), 0, -1)
    noise = np.random.default_rng(4).normal(0, 12, shape)
    inside = np.linalg.norm(at - center, axis=-1) < radius
    volume = Volume((300 + 600 * inside + noise).astype(np.int16), np.diag([1.0, 1.0, 1.0, 1.0]))
    write_series(tmp_path / "slices of a ball", volume)
    page = open_page("/upload")
    page.set_default_timeout(WORK)
    page.get_by_test_id("folder").set_input_files(tmp_path / "slices of a ball")
    page.locator("li[data-state=done]", has_text="slices of a ball.zip").get_by_text("DICOM series").wait_for()
    page.get_by_role("radiogroup", name="What is looked for").get_by_text("Any object", exact=True).click()
    page.get_by_role("combobox", name=re.compile("^Volume")).click()
    page.get_by_role("option", name=re.compile("slices of a ball.zip")).click()
    page.get_by_role("textbox", name="Seed points", exact=True).fill("20, 34, 18")
    page.get_by_role("button", name="Segment", exact=True).click()
    page.wait_for_url("**/jobs/*")
    page.get_by_role("heading", name="slices of a ball.zip").wait_for()
    page.locator("[data-state=succeeded], [data-state=failed], [data-state=crashed]").first.wait_for()
    job = api.get(f"/v1/jobs/{page.url.rsplit('/', 1)[1]}").json()
    assert job["state"] == "succeeded", job["error"]
    wait_for_pictures(page)
    page.get_by_text("Axial", exact=True).click()
    canvas = page.get_by_test_id("volume")
    height, width = picture(canvas).shape[:2]
    scale = min(width / shape[0], height / shape[1])
    middle = np.array(
        [height / 2 + scale * (shape[1] / 2 - center[1] - 0.5), width / 2 + scale * (shape[0] / 2 - center[0] - 0.5)]
    )
    reach = scale * radius
    expected = np.stack([middle - reach, middle + reach], axis=1)

    def check() -> None:
        pixels = picture(canvas)
        np.testing.assert_allclose(box(tumor_colored(pixels)), expected, atol=1.5 * scale)
        # beside the ball the slices are nearly black, and beside the slices there is nothing
        columns = np.mean(pixels.max(axis=2) > 3, axis=0) > 0.5
        assert columns.sum() == pytest.approx(scale * shape[0], abs=2 * scale)

    eventually(check)


def test_finds_what_is_there(segmented: dict[str, Any], phantom: Path) -> None:
    truth = json.loads((phantom / "truth.json").read_text())
    (tumor,) = truth["tumors"]
    found = segmented["result"]["objects"][0]
    assert np.linalg.norm(np.subtract(found["centroid"], tumor["center"])) < 5
    assert found["core_volume_mm3"] == pytest.approx(tumor["core_mm3"], rel=0.25)


def test_labels_lie_over_the_tumor(open_page: OpenPage, segmented: dict[str, Any], labels: Volume) -> None:
    """The colored pixels of each slice lie where the labels do, and the keyboard moves the crosshair."""
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)
    centroid = segmented["result"]["objects"][0]["centroid"]
    canvas = page.get_by_test_id("volume")
    eventually(lambda: np.testing.assert_allclose(crosshair(page), centroid, atol=0.06))
    for view, *axes in (("Axial", 0, 1), ("Coronal", 0, 2), ("Sagittal", 1, 2)):
        page.get_by_text(view, exact=True).click()
        eventually(lambda axes=axes: check_slice(picture(canvas), labels, centroid, *axes))

    canvas.focus()
    page.keyboard.press("ArrowRight")  # from between the voxels to the next one's center
    page.evaluate("new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))")
    at = np.array(crosshair(page))
    for key, step in {"ArrowRight": (-1, 0, 0), "ArrowUp": (0, 1, 0), "PageDown": (0, 0, -1)}.items():
        at = at + np.array(step) * labels.spacing
        page.keyboard.press(key)
        eventually(lambda at=at: np.testing.assert_allclose(crosshair(page), at, atol=0.11))
        at = np.array(crosshair(page))


def test_the_surface_is_drawn_as_it_is(open_page: OpenPage, segmented: dict[str, Any], api: httpx.Client) -> None:
    """Its silhouette is that of the mesh, seen from the front, a little from the right and above."""
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)
    canvas = page.get_by_test_id("surface")
    height, width = picture(canvas).shape[:2]
    points = np.concatenate(
        [
            vertices_of(api.get(f"/v1/jobs/{segmented['id']}/artifacts/{found['surface']}").content)
            for found in segmented["result"]["objects"]
        ]
    )
    expected = silhouette(points, points, (height, width))

    def seen() -> NDArray[np.bool_]:
        lit = tumor_colored(picture(canvas))
        np.testing.assert_allclose(box(lit), expected, atol=8)
        return lit

    lit = eventually(seen)
    keep_picture(page, "segmentation")
    canvas.focus()
    for _ in range(6):
        page.keyboard.press("ArrowLeft")
    until(lambda: differing(canvas, lit) > 0.1 * lit.sum(), "it is turned")
    page.keyboard.press("Home")
    until(lambda: differing(canvas, lit) < 0.02 * lit.sum(), "it is seen as at first")


def differing(canvas: Any, lit: NDArray[np.bool_]) -> int:
    """In how many pixels what is colored has changed."""
    return int((tumor_colored(picture(canvas)) != lit).sum())


def test_views_leave_nothing_behind(open_page: OpenPage, segmented: dict[str, Any]) -> None:
    check_nothing_is_left(open_page, f"/jobs/{segmented['id']}")


def test_viewers_are_as_new_on_the_next_page(open_page: OpenPage, segmented: dict[str, Any]) -> None:
    """Contexts are lent from page to page: nothing of the page before is seen, and no new ones are made."""
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)

    def pictures() -> list[NDArray[np.int_]]:
        return [picture(page.get_by_test_id(name)).astype(int) for name in ("volume", "surface")]

    def at_rest() -> list[NDArray[np.int_]]:
        before = pictures()
        assert all(tumor_colored(one.astype(np.uint8)).any() for one in before)
        page.wait_for_timeout(250)
        assert same(before, pictures())
        return before

    def same(one: list[NDArray[np.int_]], other: list[NDArray[np.int_]]) -> bool:
        return all(a.shape == b.shape and np.abs(a - b).mean() < 0.5 for a, b in zip(one, other, strict=True))

    first = eventually(at_rest)
    page.get_by_role("radiogroup", name="View").get_by_text("3D", exact=True).click()
    # the surface, through the volume, where the slices were
    volume = page.get_by_test_id("volume")
    until(lambda: np.abs(picture(volume).astype(int) - first[0]).mean() > 2, "the volume is seen as a whole")
    until(lambda: tumor_colored(picture(volume)).sum() > 200, "the surface is seen in it")
    for name in ("volume", "surface"):
        page.get_by_test_id(name).focus()
        for key in ("ArrowLeft", "PageUp"):
            page.keyboard.press(key)
    page.evaluate(
        """() => {
            window.made = 0;
            const get = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
                if (kind === "webgl2") window.made += 1;
                return get.call(this, kind, ...rest);
            };
        }"""
    )
    page.get_by_role("link", name="Jobs", exact=True).first.click()
    page.locator(f"tr[data-job='{segmented['id']}']").get_by_role("link").first.click()
    wait_for_pictures(page)
    until(lambda: same(first, pictures()), "it is as it was")
    assert page.evaluate("window.made") == 0

    # One that the driver has dropped is not lent again.
    page.evaluate(
        """() => document.querySelector("[data-testid=volume]").getContext("webgl2")
            .getExtension("WEBGL_lose_context").loseContext()"""
    )
    lost = page.locator("section[aria-label=Volume][data-status=lost]")
    lost.get_by_role("button", name="Draw it again").click()
    wait_for_pictures(page)
    until(lambda: same(first, pictures()), "it is as it was")


def test_how_it_grew_is_played_and_scrubbed(
    open_page: OpenPage, segmented: dict[str, Any], api: httpx.Client, tmp_path: Path
) -> None:
    """From a small surface to the one that was found; the picture covers as much as the frames do."""
    (tmp_path / "evolution.bin").write_bytes(api.get(f"/v1/jobs/{segmented['id']}/artifacts/evolution.bin").content)
    frames = read_evolution(tmp_path / "evolution.bin")
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)
    viewer = page.locator("section[aria-label=Surface]")
    viewer.get_by_role("button", name="Watch how it grew").click()
    viewer.get_by_text(f"{len(frames)} / {len(frames)}").wait_for()
    viewer.get_by_role("button", name="Play").wait_for()  # it has ended by itself
    canvas = page.get_by_test_id("surface")
    ends = {frame.object: frame.mesh.vertices for frame in frames}
    everything = np.concatenate(list(ends.values()))
    shape = picture(canvas).shape

    def covers(points: NDArray[np.float64]) -> None:
        expected = silhouette(points, everything, shape)
        np.testing.assert_allclose(box(tumor_colored(picture(canvas))), expected, atol=8)

    eventually(lambda: covers(everything))
    viewer.get_by_role("slider", name="Frame").press("Home")
    viewer.get_by_text(f"1 / {len(frames)}").wait_for()
    eventually(lambda: covers(frames[0].mesh.vertices))
    viewer.get_by_role("button", name="Watch how it grew").click()
    viewer.get_by_role("slider", name="Frame").wait_for(state="detached")
    until(lambda: tumor_colored(picture(canvas)).sum() > 500, "the surface is seen again")


def test_shows_what_was_measured_and_gives_the_files(
    open_page: OpenPage, segmented: dict[str, Any], api: httpx.Client, tmp_path: Path
) -> None:
    page = open_page(f"/jobs/{segmented['id']}")
    objects = segmented["result"]["objects"]
    rows = page.get_by_role("row").filter(has=page.get_by_role("button", name=re.compile("^Object")))
    rows.first.wait_for()
    assert rows.count() == len(objects)
    text = rows.first.text_content().replace("\u00a0", " ").replace("\u202f", " ")
    assert f"{objects[0]['core_volume_mm3'] / 1000:.3g} cm³" in text
    assert f"{objects[0]['faces']:,} faces, closed".replace(",", " ", 1) in text
    page.get_by_text("results kept until").wait_for()
    with page.expect_download() as coming:
        page.get_by_role("link", name="report.json").click()
    report = json.loads(Path(coming.value.path()).read_text())
    assert report["objects"] == objects
    page.get_by_role("button", name="STL, OBJ of surfaces-1").click()
    with page.expect_download() as coming:
        page.get_by_role("menuitem", name="STL").click()
    assert coming.value.suggested_filename == "surfaces-1.stl"
    printed = read_mesh(Path(coming.value.path()))
    (tmp_path / "1.ply").write_bytes(api.get(f"/v1/jobs/{segmented['id']}/artifacts/surfaces/1.ply").content)
    ours = read_mesh(tmp_path / "1.ply")
    np.testing.assert_allclose(printed.vertices[printed.faces], ours.vertices[ours.faces], atol=1e-4)
    page.get_by_role("link", name="Segment again").click()
    page.wait_for_url("**/upload?*")
    wait_for_value(page, "After contrast", "post.nii.gz")


def test_what_is_similar_to_the_tumor(open_page: OpenPage, segmented: dict[str, Any], api: httpx.Client) -> None:
    """One click sends the surface off as an example; how many are found depends on what is in the bank."""
    page = open_page(f"/jobs/{segmented['id']}")
    page.get_by_role("button", name="Find shapes like object 1").click()
    page.wait_for_url("**/shapes/search?asset=*")
    page.get_by_role("heading", name="Like post-object-1.ply").wait_for()
    page.get_by_test_id("searched").get_by_text("found").wait_for(timeout=WORK)
    surface = segmented["result"]["objects"][0]["surface"]
    asset = re.search(r"asset=([\w-]+)", page.url)[1]  # type: ignore[index]
    sent = api.get(f"/v1/assets/{asset}/content").content
    assert sent == api.get(f"/v1/jobs/{segmented['id']}/artifacts/{surface}").content


def test_says_that_it_cannot_draw_without_webgl(open_page: OpenPage, segmented: dict[str, Any]) -> None:
    page = open_page(
        f"/jobs/{segmented['id']}",
        before=lambda page: page.add_init_script(
            "const get = HTMLCanvasElement.prototype.getContext;"
            "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
            "  return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest); }"
        ),
    )
    page.get_by_role("alert").get_by_text("This browser cannot draw in 3D").wait_for()
    page.get_by_role("link", name="labels.nii.gz").wait_for()
    page.get_by_role("button", name="Object 1", exact=True).wait_for()
    check_open_to_everyone(page)


def test_a_file_that_cannot_be_fetched_is_told_and_fetched_again(
    open_page: OpenPage, segmented: dict[str, Any]
) -> None:
    def refuse(page: Any) -> None:
        page.watch.allowed.append("net::ERR")
        page.route("**/artifacts/surfaces/**", lambda route: route.abort())

    page = open_page(f"/jobs/{segmented['id']}", before=refuse)
    told = page.locator("section[aria-label=Surface]").get_by_role("alert")
    told.get_by_text("The server does not answer").wait_for()
    check_open_to_everyone(page)
    page.unroute("**/artifacts/surfaces/**")
    told.get_by_role("button", name="Draw it again").click()
    wait_for_pictures(page)
    until(lambda: tumor_colored(picture(page.get_by_test_id("surface"))).mean() > 0.01, "it is drawn after all")


def test_a_mask_is_compared_and_drawn(
    open_page: OpenPage, segmented: dict[str, Any], labels: Volume, phantom: Path, api: httpx.Client
) -> None:
    """The figures are those of the voxels, green appears in the slices, and the surface has the colors of distances."""
    truth = read_volume(phantom / "truth.nii.gz")
    with (phantom / "truth.nii.gz").open("rb") as file:
        api.post("/v1/assets", files={"file": ("drawn by hand.nii.gz", file)}).raise_for_status()
    ours, theirs = np.isin(labels.data, [1, 2]), truth.data > 0
    iou = (ours & theirs).sum() / (ours | theirs).sum()
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)

    def green() -> int:
        pixels = picture(volume).astype(int)
        return int(((pixels[..., 1] > pixels[..., 0] + 40) & (pixels[..., 1] > pixels[..., 2] + 20)).sum())

    volume = page.get_by_test_id("volume")
    until(lambda: bool(tumor_colored(picture(volume)).any()), "the slices are drawn")
    before = green()
    page.get_by_role("combobox", name="Reference mask").click()
    page.get_by_role("option", name="drawn by hand.nii.gz").click()
    shown = page.get_by_test_id("agreement").locator("dd").first.text_content()  # waits for it
    assert float(shown) == pytest.approx(iou, abs=0.0006)
    until(lambda: green() > before + 200, "the mask is drawn")

    found = segmented["result"]["objects"]
    files = [api.get(f"/v1/jobs/{segmented['id']}/artifacts/{item['surface']}").content for item in found]
    distances = np.abs(to_border(np.concatenate([vertices_of(data) for data in files]), truth))
    legend = page.get_by_test_id("distances").text_content().replace("\u00a0", " ")
    told = [float(value) for value in re.findall(r"(?:mean|within|at most) ([\d.]+) mm", legend)]
    expected = [distances.mean(), np.quantile(distances, 0.95, method="higher"), distances.max()]
    np.testing.assert_allclose(told, expected, atol=0.02, rtol=0.005)  # three digits are shown
    page.evaluate("scrollTo(0, 0)")
    keep_picture(page, "distances")
    surface = page.get_by_test_id("surface")
    colored = tumor_colored(picture(surface))
    page.get_by_role("button", name="Color by the distance to the mask").click()
    page.get_by_test_id("distances").wait_for(state="detached")
    until(lambda: (plain := tumor_colored(picture(surface))).sum() > 2 * (colored & plain).sum(), "it is plain again")


def test_a_seed_is_placed_and_run(open_page: OpenPage, segmented: dict[str, Any], api: httpx.Client) -> None:
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)
    page.get_by_role("button", name="Seed here").wait_for()
    at = crosshair(page)
    page.get_by_role("button", name="Seed here").click()
    job = started(page, api, "Segment from this point")
    assert job["inputs"] == segmented["inputs"]
    np.testing.assert_allclose(job["params"]["seeds"], [at], atol=0.06)


def test_a_box_is_drawn_and_run(
    open_page: OpenPage, segmented: dict[str, Any], labels: Volume, api: httpx.Client
) -> None:
    """Around what is colored in the axial slice; it is sent where the labels lie, as deep as it was at first."""
    page = open_page(f"/jobs/{segmented['id']}")
    wait_for_pictures(page)
    page.get_by_text("Axial", exact=True).click()
    canvas = page.get_by_test_id("volume")
    centroid = segmented["result"]["objects"][0]["centroid"]

    def axial() -> NDArray[np.float64]:
        pixels = picture(canvas)
        check_slice(pixels, labels, centroid, 0, 1)
        return box(tumor_colored(pixels))

    (top, bottom), (left, right) = eventually(axial)
    page.get_by_role("button", name="Draw a box").click()
    place = canvas.bounding_box()
    x, y = place["x"], place["y"]
    page.mouse.move(x + left - 40, y + top - 40)  # beside the box that is there at first
    page.mouse.down()
    page.mouse.move(x + left, y + top)
    page.mouse.move(x + right, y + bottom)
    page.mouse.up()
    # a corner is taken along
    page.mouse.move(x + left - 40, y + top - 40)
    page.mouse.down()
    page.mouse.move(x + left, y + top)
    page.mouse.up()
    drawn = page.get_by_test_id("box").locator("rect[data-cut]").bounding_box()
    np.testing.assert_allclose([drawn[k] for k in ("x", "y", "width", "height")],
                               [x + left, y + top, right - left, bottom - top], atol=2)  # fmt: skip
    page.get_by_role("textbox", name="Top").fill("60")
    check_open_to_everyone(page)
    job = started(page, api, "Segment what is in the box")
    assert job["params"]["mode"] == "object"
    assert job["inputs"] == {"post": segmented["inputs"]["post"]}
    slice_ = np.isin(labels.data[:, :, round(labels.to_index(centroid)[2])], [1, 2])
    inside = np.argwhere(slice_) * labels.spacing[:2] + labels.affine[:2, 3]
    half = labels.spacing[0] / 2
    low, high = np.reshape(job["params"]["box"], (2, 3))
    np.testing.assert_allclose([low[:2], high[:2]], [inside.min(0) - half, inside.max(0) + half], atol=2.5)
    assert (low[2] < centroid[2] < high[2], high[2]) == (True, 60)


def started(page: Any, api: httpx.Client, button: str) -> dict[str, Any]:
    """The job that a button starts, called off at once."""
    before = page.url
    page.get_by_role("button", name=button).click()
    page.wait_for_url(lambda url: "/jobs/" in url and url != before)
    job = api.get(f"/v1/jobs/{page.url.rsplit('/', 1)[1]}").json()
    api.post(f"/v1/jobs/{job['id']}/cancel")
    return dict(job)
