import { type WebGLProgram, WebGLRenderer } from "three";
import { drawsBySoftware } from "../webgl";

/** As many as a page shows at once: two shapes side by side. */
const MOST = 2;

/** Those that no page uses now. */
const kept: WebGLRenderer[] = [];

/**
 * A renderer with a canvas of its own. A browser does not give back everything that a context took, so renderers are
 * lent to one page after the other instead of being made anew for each.
 */
export function borrowRenderer(): WebGLRenderer {
  const renderer = kept.pop() ?? opaque();
  renderer.setPixelRatio(sharpness());
  renderer.setClearColor("#000000");
  return renderer;
}

/**
 * A renderer whose canvas hides what is behind it. A context that three makes has transparency, and the browser then
 * blends every picture over the page, which takes as long as to draw it where there is no graphics card.
 */
function opaque(): WebGLRenderer {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", { alpha: false, antialias: !drawsBySoftware() });
  return new WebGLRenderer({ canvas, ...(context ? { context } : {}) });
}

/** Pixels of a canvas to one of the page. */
export function sharpness(): number {
  return drawsBySoftware() ? 1 : Math.min(window.devicePixelRatio, 2);
}

const held = new WeakSet<WebGLProgram>();

/**
 * Keep the programs that a renderer has compiled. three deletes one with the last material that uses it, and would
 * compile it anew for the next page, which takes time; and what a driver that draws by the processor has generated for
 * a program stays in memory long after it.
 */
export function keepPrograms({ info }: WebGLRenderer): void {
  for (const program of info.programs ?? []) {
    if (held.has(program)) continue;
    held.add(program);
    program.usedTimes += 1;
  }
}

/** Whoever has drawn with it has disposed of what was drawn. */
export function giveBackRenderer(renderer: WebGLRenderer): void {
  renderer.domElement.remove();
  renderer.renderLists.dispose();
  if (kept.length < MOST && !renderer.getContext().isContextLost()) {
    renderer.setScissorTest(false);
    renderer.setSize(1, 1, false);
    kept.push(renderer);
    return;
  }
  renderer.dispose();
  // A browser keeps a handful of contexts; one that is only forgotten counts until it is collected.
  renderer.forceContextLoss();
}
