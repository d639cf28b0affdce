/** What an encoding changed: the original is the decoded position plus the residual. See docs/motion.md. */
export interface Residuals {
  frames: number;
  vertices: number;
  step: number;
  /** frames · vertices · 3, in steps. */
  values: Int8Array;
}

const MAGIC = 0x31524d53; // "SMR1"

/** Read `residuals.bin.gz`. */
export async function readResiduals(content: ArrayBuffer): Promise<Residuals> {
  const stream = new Blob([content]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = await new Response(stream).arrayBuffer();
  const view = new DataView(bytes);
  if (bytes.byteLength < 16 || view.getUint32(0, true) !== MAGIC) throw new Error("The residuals cannot be read.");
  const frames = view.getUint32(4, true);
  const vertices = view.getUint32(8, true);
  if (bytes.byteLength !== 16 + 3 * frames * vertices) throw new Error("The residuals are cut off.");
  return { frames, vertices, step: view.getFloat32(12, true), values: new Int8Array(bytes, 16) };
}

/** The root mean square of all errors, from a sample of them. */
export function typicalError({ values, step }: Residuals): number {
  const vectors = values.length / 3;
  const stride = Math.max(1, Math.floor(vectors / 200_000));
  let total = 0;
  let count = 0;
  for (let v = 0; v < vectors; v += stride) {
    for (let at = 3 * v; at < 3 * v + 3; at += 1) total += (values[at] as number) ** 2;
    count += 1;
  }
  return count > 0 ? step * Math.sqrt(total / count) : 0;
}
