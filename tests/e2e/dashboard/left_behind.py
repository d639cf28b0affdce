"""What views of a page leave behind in the graphics driver."""

from __future__ import annotations

from tests.e2e.dashboard.conftest import OpenPage

COUNT = """
window.graphics = { contexts: 0, linked: 0, live: {} };
const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
    const context = get.call(this, kind, ...rest);
    if (kind === "webgl2" && context && !context.counted) {
        context.counted = true;
        window.graphics.contexts += 1;
    }
    return context;
};
const all = WebGL2RenderingContext.prototype;
const link = all.linkProgram;
all.linkProgram = function (program) {
    window.graphics.linked += 1;
    return link.call(this, program);
};
const KINDS = ["Buffer", "Texture", "Framebuffer", "Renderbuffer", "VertexArray", "Program", "Shader", "Sampler"];
for (const kind of KINDS) {
    const [create, remove] = [all[`create${kind}`], all[`delete${kind}`]];
    const live = new Set();
    Object.defineProperty(window.graphics.live, kind, { enumerable: true, get: () => live.size });
    all[`create${kind}`] = function (...given) {
        const made = create.apply(this, given);
        live.add(made);
        return made;
    };
    all[`delete${kind}`] = function (old) {
        live.delete(old);
        return remove.call(this, old);
    };
}
"""
"""Counts contexts that are made, programs that are linked, and what is made in contexts and not yet deleted."""

VIEW = """
async (path) => {
    const until = async (there) => {
        while (!there()) await new Promise((resolve) => setTimeout(resolve, 20));
    };
    const go = (to) => {
        history.pushState({}, "", to);
        dispatchEvent(new PopStateEvent("popstate"));
    };
    go(path);
    const is = (status) => document.querySelector(`section[data-status=${status}]`) !== null;
    await until(() => is("ready") && !is("loading"));
    for (let frame = 0; frame < 3; frame += 1) await new Promise(requestAnimationFrame); // it is drawn
    await new Promise((resolve) => setTimeout(resolve, 100));
    go("/jobs");
    await until(() => document.body.textContent.includes("Progress and outcome"));
    return JSON.stringify(window.graphics);
}
"""


def check_nothing_is_left(open_page: OpenPage, path: str) -> None:
    """Look at a page again and again: after the first time, nothing stays, and nothing is made that was made before."""
    page = open_page("/jobs", before=lambda page: page.add_init_script(COUNT))
    page.get_by_text("Progress and outcome").wait_for()
    page.evaluate(VIEW, path)
    settled = page.evaluate(VIEW, path)
    for _ in range(3):
        now = page.evaluate(VIEW, path)
        assert now == settled, f"{settled} became {now}"
