interface Drawing {
  /** Whether this browser can draw volumes and surfaces (WebGL 2). */
  can: boolean;
  /** Whether the processor does it, for want of a graphics card. */
  bySoftware: boolean;
}

let known: Drawing | null = null;

function drawing(): Drawing {
  if (known === null) {
    const context = document.createElement("canvas").getContext("webgl2");
    const names = context?.getExtension("WEBGL_debug_renderer_info");
    const renderer: unknown = names && context?.getParameter(names.UNMASKED_RENDERER_WEBGL);
    known = { can: context !== null, bySoftware: /swiftshader|llvmpipe|software/i.test(String(renderer)) };
    context?.getExtension("WEBGL_lose_context")?.loseContext();
  }
  return known;
}

export function hasWebGL(): boolean {
  return drawing().can;
}

/** Where the processor draws, what only makes a picture finer is left out, so that it still moves. */
export function drawsBySoftware(): boolean {
  return drawing().bySoftware;
}
