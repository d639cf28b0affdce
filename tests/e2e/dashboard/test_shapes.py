"""The shape database as it is seen: a wall of pictures, a page for each shape, searches by shape, file and region."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.mesh_io import write_mesh
from tests.e2e.dashboard.conftest import OpenPage
from tests.e2e.dashboard.left_behind import check_nothing_is_left
from tests.e2e.dashboard.test_accessibility import AXE, check_open_to_everyone, overflow, serious
from tests.support.browser import eventually, keep_picture, picture, until
from tests.unit.retrieval.conftest import cylinder, egg, torus

pytestmark = [pytest.mark.server, pytest.mark.browser, pytest.mark.slow]

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
WORK = 120_000
"""Milliseconds that indexing may take on a machine that does other things as well."""


def turned(mesh: TriangleMesh) -> TriangleMesh:
    """The same in another size and orientation."""
    return mesh.with_vertices(2.5 * mesh.vertices @ TURN.T)


MESHES = {"egg": egg(), "egg turned": turned(egg()), "torus": torus(), "torus turned": turned(torus(44, 20))}


@pytest.fixture(scope="module")
def bank(chrome: Any, api: httpx.Client, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Ids of four shapes by name: two eggs and two tori, in the collection `bodies`."""
    folder = tmp_path_factory.mktemp("meshes")
    items = []
    for name, mesh in MESHES.items():
        path = folder / f"{name}.ply"
        write_mesh(mesh, path)
        asset = api.post("/v1/assets", files={"file": (path.name, path.read_bytes())}).json()["id"]
        items.append({"inputs": {"mesh": asset}, "params": {"labels": {"family": name.split()[0]}}})
    request = {"kind": "shape-index", "params": {"collection": "bodies"}, "items": items}
    batch = api.post("/v1/batches", json=request).json()["id"]
    end = time.monotonic() + WORK / 1000
    while not (state := api.get(f"/v1/batches/{batch}").json())["finished"]:
        assert time.monotonic() < end, state
        time.sleep(0.3)
    assert state["counts"]["succeeded"] == len(MESHES), state
    shapes = api.get("/v1/shapes", params={"collection": "bodies"}).json()["items"]
    return {shape["name"]: shape["id"] for shape in shapes}


def drawn(pixels: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where a viewer's picture shows something: its ground is black."""
    return pixels.max(axis=2) > 24


def hues(pixels: NDArray[np.uint8]) -> set[int]:
    """Which twelfths of the circle of hues cover at least a hundredth of what is drawn, in colors that are no gray."""
    there = pixels[drawn(pixels)].astype(float)
    red, green, blue = there.T
    chroma = there.max(axis=1) - there.min(axis=1)
    angle = np.degrees(np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue)) % 360
    vivid = chroma > 0.3 * there.max(axis=1)
    counts = np.bincount((angle[vivid] // 30).astype(int), minlength=12)
    return set(np.flatnonzero(counts > 0.01 * len(there)).tolist())


def wait_for_picture(page: Any, name: str) -> NDArray[np.uint8]:
    """A viewer's picture, once it shows something and no longer changes."""
    canvas = page.get_by_test_id(name)
    canvas.wait_for(timeout=WORK)
    before = picture(canvas)
    for _ in range(120):
        page.wait_for_timeout(250)
        now = picture(canvas)
        if drawn(now).any() and np.array_equal(now, before):
            return now
        before = now
    raise AssertionError(f"{name} does not come to rest")


def names(page: Any) -> list[str]:
    return list(
        page.locator("[data-testid=wall] > li").evaluate_all("items => items.map((item) => item.dataset.shape)")
    )


def hits(page: Any) -> list[str]:
    page.locator("[data-hit]").first.wait_for(timeout=WORK)
    return list(page.locator("[data-hit]").evaluate_all("items => items.map((item) => item.dataset.hit)"))


def test_views_leave_nothing_behind(open_page: OpenPage, bank: dict[str, str]) -> None:
    check_nothing_is_left(open_page, f"/shapes/{bank['egg']}")


def test_shapes_are_added_named_moved_and_deleted(
    open_page: OpenPage, bank: dict[str, str], api: httpx.Client, tmp_path: Path
) -> None:
    write_mesh(cylinder(), tmp_path / "rod.obj")
    (tmp_path / "notes.txt").write_text("no mesh at all")
    page = open_page("/shapes")
    page.watch.allowed += ["422.*/v1/uploads/", "404.*/v1/uploads/"]  # what is no mesh, and that it is gone then
    page.get_by_role("button", name="Add shapes").click()
    page.get_by_test_id("files").set_input_files([tmp_path / "rod.obj", tmp_path / "notes.txt"])
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("combobox", name="Collection").fill("new things")
    dialog.get_by_role("combobox", name="Labels").fill("family:rod")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Add 2 shapes").click()
    # the page is left while they are indexed
    begun = """() => {
        const key = Object.keys(localStorage).find((key) => key.startsWith("shapery.addition."));
        return key ? JSON.parse(localStorage.getItem(key)).batches.length : 0;
    }"""
    until(lambda: page.evaluate(begun) == 1, "the addition is not kept")
    page.reload()
    told = page.get_by_role("region", name="Shapes being added")
    told.get_by_text("1 of 2 added to new things.").wait_for(timeout=WORK)
    told.get_by_text("notes.txt:").wait_for()
    until(lambda: "rod" in names(page), "the wall does not show what was added")
    (shape,) = api.get("/v1/shapes", params={"collection": "new things"}).json()["items"]
    assert shape["labels"] == {"family": "rod"}

    # filters
    page.get_by_role("link", name="bodies").click()
    until(lambda: sorted(names(page)) == sorted(bank), "the collection is shown alone")
    page.get_by_role("searchbox", name="Text in the name").fill("turned")
    until(lambda: sorted(names(page)) == ["egg turned", "torus turned"], "names are filtered")
    page.get_by_role("combobox", name="Labels").click()
    page.get_by_role("option", name="family:egg").click()
    until(lambda: names(page) == ["egg turned"], "labels are filtered")
    page.reload()
    until(lambda: names(page) == ["egg turned"], "the address holds the filters")

    # a collection is renamed; a shape moved, and deleted
    page.goto(page.url.split("?")[0] + "?collection=new things")
    page.get_by_role("button", name="Change the collection new things").click()
    page.get_by_role("menuitem", name="Rename").click()
    page.get_by_role("textbox", name="Name").fill("rods")
    page.get_by_role("button", name="Rename").click()
    page.get_by_role("link", name="rods").wait_for()
    page.get_by_role("button", name="Choose", exact=True).click()
    page.get_by_role("checkbox", name="Choose rod").check()
    page.get_by_role("combobox", name="Move to").click()
    page.get_by_role("option", name="bodies").click()
    until(lambda: "rod" not in names(page), "it has moved")
    assert api.get(f"/v1/shapes/{shape['id']}").json()["collection"] == "bodies"
    page.get_by_role("button", name="Change the collection rods").click()
    page.get_by_role("menuitem", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_role("link", name="rods").wait_for(state="detached")
    page.goto(page.url.split("/shapes")[0] + f"/shapes/{shape['id']}")
    page.get_by_role("button", name="Delete").click()
    page.get_by_role("button", name="Delete for good").click()
    page.wait_for_url("**/shapes?collection=bodies")
    assert api.get(f"/v1/shapes/{shape['id']}").status_code == 404


def test_a_shape_is_shown_with_its_parts_and_its_graph(
    open_page: OpenPage, bank: dict[str, str], api: httpx.Client
) -> None:
    page = open_page(f"/shapes/{bank['torus']}")
    page.get_by_text("32 parts").click()
    until(lambda: len(hues(picture(page.get_by_test_id("shape")))) >= 5, "the parts are colored")
    colored = wait_for_picture(page, "shape")
    page.get_by_text("Plain").click()
    page.mouse.move(0, 0)
    until(lambda: hues(picture(page.get_by_test_id("shape"))) == set(), "the parts have no colors")
    plain = wait_for_picture(page, "shape")
    # the same silhouette, which fills the view; a ring lies
    assert np.mean(drawn(plain) != drawn(colored)) < 0.002
    rows = np.flatnonzero(drawn(plain).any(axis=1))
    columns = np.flatnonzero(drawn(plain).any(axis=0))
    assert max(np.ptp(rows) / plain.shape[0], np.ptp(columns) / plain.shape[1]) > 0.85
    assert np.ptp(columns) > 1.3 * np.ptp(rows)

    page.get_by_text("16 parts").click()
    page.get_by_role("button", name="Draw the graph of the parts").click()
    page.mouse.move(0, 0)
    shape = page.get_by_test_id("shape")
    until(lambda: (picture(shape).min(axis=2) > 225).sum() > 50, "the whole's node is drawn")
    graph = wait_for_picture(page, "shape")
    keep_picture(page, "shape")
    gold = (graph[..., 0] > 190) & (graph[..., 2] < graph[..., 0] * 0.62) & (graph[..., 1] > graph[..., 2])
    assert gold.sum() > 300  # what ties neighbours

    page.get_by_role("button", name="Edit").click()
    page.get_by_role("textbox", name="Name").fill("a ring")
    page.get_by_role("textbox", name="Metadata").fill('{"year": 2024}')
    page.get_by_role("button", name="Save", exact=True).click()
    page.get_by_role("heading", name="a ring").wait_for()
    page.get_by_text("2024").wait_for()
    check_open_to_everyone(page)
    detail = api.get(f"/v1/shapes/{bank['torus']}").json()
    assert (detail["name"], detail["metadata"], detail["labels"]) == ("a ring", {"year": 2024}, {"family": "torus"})
    api.patch(f"/v1/shapes/{bank['torus']}", json={"name": "torus", "metadata": {}})
    with page.expect_download() as coming:
        page.get_by_role("link", name="torus.ply").click()
    assert Path(coming.value.path()).read_bytes().startswith(b"ply")


def test_what_is_like_a_shape_is_shown_beside_it(open_page: OpenPage, bank: dict[str, str]) -> None:
    page = open_page(f"/shapes/{bank['egg']}")
    page.get_by_role("link", name="Find similar").click()
    page.wait_for_url("**/shapes/search?shape=*")
    assert hits(page)[0] == "egg turned"

    def alike() -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        query, found = wait_for_picture(page, "query"), wait_for_picture(page, "found")
        assert len(hues(query) & hues(found)) >= 3
        assert np.mean(drawn(query) != drawn(found)) < 0.06
        return query, found

    # matched parts have the same colors and lie in the same places, although the files have them in different poses
    _, found = eventually(alike)
    keep_picture(page, "search")
    # who turns one turns both
    page.get_by_test_id("query").focus()
    for _ in range(8):
        page.keyboard.press("ArrowDown")
    canvas = page.get_by_test_id("found")
    until(lambda: np.mean(drawn(picture(canvas)) != drawn(found)) > 0.01, "the other one turns, too")
    page.reload()
    assert hits(page)[0] == "egg turned"
    # another hit, and on from there
    page.locator("[data-hit='torus turned'] button").click()
    page.locator("section[aria-label='torus turned']").wait_for()
    page.get_by_role("link", name="Go on with shapes like torus turned").click()
    page.get_by_role("heading", name="Like torus turned").wait_for()
    until(lambda: hits(page)[0] == "torus", "the torus is like the torus")
    check_open_to_everyone(page)
    page.get_by_role("button", name="This search, as code").click()
    assert f'"shape_id":"{bank["torus turned"]}"' in page.get_by_test_id("code-curl").text_content()


def test_says_that_nothing_was_found(open_page: OpenPage, bank: dict[str, str]) -> None:
    page = open_page(f"/shapes/search?shape={bank['egg']}&labels=family:none")
    page.get_by_role("heading", name="Nothing was found").wait_for()
    page.get_by_text("No other shape is in this collection and carries these labels.").wait_for()
    check_open_to_everyone(page)


def test_a_file_is_searched_with(open_page: OpenPage, bank: dict[str, str], tmp_path: Path, api: httpx.Client) -> None:
    write_mesh(turned(torus(52, 26)), tmp_path / "found ring.stl")
    before = len(api.get("/v1/shapes", params={"limit": 200}).json()["items"])
    page = open_page("/shapes/search")
    page.get_by_test_id("files").set_input_files(tmp_path / "found ring.stl")
    page.wait_for_url("**/shapes/search?asset=*")
    assert set(hits(page)[:2]) == {"torus", "torus turned"}
    page.get_by_role("heading", name="Like found ring.stl").wait_for()
    query, found = (page.get_by_test_id(name) for name in ("query", "found"))
    until(lambda: len(hues(picture(query)) & hues(picture(found))) >= 3, "what was matched has the same colors")
    jobs = len(api.get("/v1/jobs", params={"kind": "shape-search"}).json()["items"])
    page.reload()
    assert set(hits(page)[:2]) == {"torus", "torus turned"}
    assert len(api.get("/v1/jobs", params={"kind": "shape-search"}).json()["items"]) == jobs  # nothing ran again
    assert len(api.get("/v1/shapes", params={"limit": 200}).json()["items"]) == before


def orange(pixels: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return np.asarray((pixels[..., 0].astype(int) - pixels[..., 2]) > 70)


def test_a_painted_region_is_searched_with(open_page: OpenPage, bank: dict[str, str]) -> None:
    page = open_page(f"/shapes/{bank['egg']}")
    page.get_by_role("button", name="Paint a region").click()
    before = wait_for_picture(page, "shape")
    place = page.get_by_test_id("shape").bounding_box()
    x, y = place["x"] + place["width"] / 2, place["y"] + place["height"] / 2
    page.mouse.move(x - 40, y)
    page.mouse.down()
    for step in range(1, 17):
        page.mouse.move(x - 40 + 5 * step, y + 10 * (step % 2))
    page.mouse.up()
    told = page.get_by_test_id("painted")
    until(lambda: "of the area painted" in told.text_content(), "the share is told")
    until(lambda: orange(picture(page.get_by_test_id("shape"))).any(), "the paint is seen")
    painted = wait_for_picture(page, "shape")
    assert np.mean(drawn(painted) != drawn(before)) < 0.002  # it was painted, not turned
    assert 0.02 < orange(painted).sum() / drawn(painted).sum() < 0.7
    share = int(re.match(r"(\d+)", told.text_content())[1])  # type: ignore[index]
    assert 1 <= share <= 50
    page.get_by_role("link", name="Find this region").click()
    page.wait_for_url("**/shapes/search?*parts=*")
    assert hits(page)[0] == "egg turned"
    page.get_by_text(re.compile("by a region of")).wait_for()

    # what was matched has color, the rest has none
    def check(name: str) -> None:
        pixels = wait_for_picture(page, name)
        vivid = (pixels.max(axis=2).astype(int) - pixels.min(axis=2)) > 60
        assert 0.01 < vivid.sum() / drawn(pixels).sum() < 0.8, name

    for name in ("query", "found"):
        eventually(lambda name=name: check(name))


def test_ten_thousand_shapes_scroll(open_page: OpenPage, bank: dict[str, str], api: httpx.Client) -> None:
    """Pages of copies of one shape stand in for a large bank: what is tested is the wall."""
    shape = api.get(f"/v1/shapes/{bank['egg']}").json()
    total, size = 10_000, 200

    def answer(route: Any) -> None:
        begin = int((re.search(r"cursor=(\d+)", route.request.url) or [0, 0])[1])
        items = [{**shape, "id": str(begin + i), "name": f"No {begin + i}"} for i in range(size)]
        end = begin + size
        route.fulfill(json={"items": items, "next_cursor": str(end) if end < total else None})

    page = open_page("/shapes", before=lambda page: page.route(re.compile(r"/v1/shapes\?"), answer))
    page.route(re.compile(r"/v1/shapes/\d+/preview"), lambda route: route.abort())
    page.watch.allowed.append("ERR_FAILED")
    page.locator("li[data-shape='No 0']").wait_for()
    most = 0
    for _ in range(400):
        page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        page.wait_for_timeout(30)
        seen = names(page)
        most = max(most, len(seen))
        if f"No {total - 1}" in seen:
            break
    else:
        raise AssertionError(f"the last one is not reached; at the end: {names(page)[-1]}")
    assert most < 120
    page.evaluate("scrollTo(0, document.documentElement.scrollHeight / 2)")
    until(lambda: any(name == "No 5000" for name in names(page)), "the middle is shown where it is")


def test_pages_with_shapes_are_open_to_everyone(open_page: OpenPage, bank: dict[str, str]) -> None:
    if not AXE.is_file():
        pytest.skip("axe-core is not installed (npm ci in services/dashboard)")
    axe = AXE.read_text()
    found = {}
    for scheme in ("light", "dark"):
        page = open_page("/shapes", color_scheme=scheme)
        page.locator("[data-testid=wall] img").first.wait_for()
        found[scheme, "wall"] = serious(page, axe)
        page.get_by_role("button", name="Choose", exact=True).click()
        found[scheme, "choosing"] = serious(page, axe)
        page.goto(page.url.split("/shapes")[0] + f"/shapes/{bank['egg']}")
        page.get_by_role("button", name="Paint a region").click()
        page.get_by_role("button", name="Edit").click()
        found[scheme, "shape"] = serious(page, axe)
        page.set_viewport_size({"width": 820, "height": 1180})
        assert overflow(page) <= 0
        page.goto(page.url.split("/shapes")[0] + f"/shapes/search?shape={bank['egg']}")
        hits(page)
        page.get_by_test_id("found").wait_for()
        found[scheme, "search"] = serious(page, axe)
        assert overflow(page) <= 0
        page.goto(page.url.split("?")[0])
        page.get_by_role("link", name="all shapes").wait_for()
        found[scheme, "examples"] = serious(page, axe)
    assert {where: faults for where, faults in found.items() if faults} == {}


def test_the_keyboard_is_enough_to_search_by_a_region(open_page: OpenPage, bank: dict[str, str]) -> None:
    """From the wall to a shape, to one of its parts, and to what is like it, without a mouse."""
    page = open_page("/shapes?collection=bodies")
    page.locator("[data-testid=wall] > li").first.wait_for()

    def tab_to(what: str, condition: str) -> None:
        for _ in range(90):
            page.keyboard.press("Tab")
            if page.evaluate(f"(() => {{ const it = document.activeElement; return {condition}; }})()"):
                return
        raise AssertionError(f"{what} is not reached by the tabulator key")

    tab_to("the shape", f"it.tagName === 'A' && it.href.endsWith('{bank['egg']}')")
    page.keyboard.press("Enter")
    page.wait_for_url(f"**/shapes/{bank['egg']}")
    page.get_by_test_id("shape").wait_for()
    tab_to("the brush", "it.textContent === 'Paint a region'")
    page.keyboard.press("Enter")
    tab_to("a part", "it.getAttribute('aria-label') === 'Part 3'")
    page.keyboard.press("Space")
    tab_to("the search", "it.textContent === 'Find this region'")
    page.keyboard.press("Enter")
    page.wait_for_url("**/shapes/search?*")
    page.locator("[data-hit]").nth(1).wait_for(timeout=WORK)
    tab_to("the second hit", "it.textContent.startsWith('2. ') && it.getAttribute('aria-pressed') === 'false'")
    page.keyboard.press("Enter")
    page.locator("button[aria-pressed=true]", has_text="2. ").wait_for()


def test_there_is_no_such_shape(open_page: OpenPage) -> None:
    page = open_page("/shapes/01890a5d-ac96-774b-bcce-b302099a8057")
    page.watch.allowed.append("404")
    page.get_by_role("heading", name="There is no such shape").wait_for()
    page.get_by_role("link", name="To the shapes").click()
    page.get_by_role("heading", name="Shapes").wait_for()
