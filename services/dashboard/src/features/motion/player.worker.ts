import { Motion } from "./smc/motion";
import type { Header } from "./smc/container";

export type Ask = { open: ArrayBuffer } | { frame: number; into: Float32Array };
export type Told =
  | { is: "open"; header: Header; faces: Uint32Array; labels: Int32Array }
  | { is: "frame"; frame: number; positions: Float32Array }
  | { is: "problem"; problem: string };

let motion: Motion | null = null;
let exact = new Float64Array(0);

self.onmessage = ({ data }: MessageEvent<Ask>) => {
  const tell = (told: Told, given: Transferable[] = []) => self.postMessage(told, { transfer: given });
  try {
    if ("open" in data) {
      motion = new Motion(new Uint8Array(data.open));
      exact = new Float64Array(3 * motion.header.vertices);
      tell({ is: "open", header: motion.header, faces: motion.faces, labels: motion.labels(0) });
    } else if (motion) {
      data.into.set(motion.frame(data.frame, exact));
      tell({ is: "frame", frame: data.frame, positions: data.into }, [data.into.buffer]);
    }
  } catch (error) {
    tell({ is: "problem", problem: error instanceof Error ? error.message : String(error) });
  }
};
