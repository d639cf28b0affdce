import { type Ball, ballOf, spread } from "./reach";
import { Motion } from "./smc/motion";
import type { Header } from "./smc/container";

export type Ask = { open: ArrayBuffer } | { frame: number; into: Float32Array };
export type Told =
  | { is: "open"; header: Header; faces: Uint32Array; labels: Int32Array; reach: Ball[] }
  | { is: "frame"; frame: number; positions: Float32Array }
  | { is: "problem"; problem: string };

const SAMPLED = 16;

let motion: Motion | null = null;
let exact = new Float64Array(0);

self.onmessage = ({ data }: MessageEvent<Ask>) => {
  const tell = (told: Told, given: Transferable[] = []) => self.postMessage(told, { transfer: given });
  try {
    if ("open" in data) {
      motion = new Motion(new Uint8Array(data.open));
      exact = new Float64Array(3 * motion.header.vertices);
      const { header, faces } = motion;
      const labels = motion.labels(0);
      tell({ is: "open", header, faces, labels, reach: reachOf(motion) });
    } else if (motion) {
      data.into.set(motion.frame(data.frame, exact));
      tell({ is: "frame", frame: data.frame, positions: data.into }, [data.into.buffer]);
    }
  } catch (error) {
    tell({ is: "problem", problem: error instanceof Error ? error.message : String(error) });
  }
};

/** Where the mesh goes, as far as the group that is open tells: to open all of them would take long. */
function reachOf(motion: Motion): Ball[] {
  return spread(motion.header.groups[0]?.frames ?? 1, SAMPLED).map((frame) => ballOf(motion.frame(frame, exact)));
}
