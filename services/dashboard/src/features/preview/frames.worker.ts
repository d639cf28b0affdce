import type { Asset } from "@/api/types";
import { type Ball, ballOf, spread } from "@/features/motion/reach";
import { coarsen } from "@/viewers/coarse";
import { reasonOf } from "./reason";
import type { Sequence } from "./sequence";

export interface File {
  content: ArrayBuffer;
  kind: Asset["kind"];
  format: string;
  /** Faces that are drawn at the most. */
  most: number;
}

export interface Opened {
  frames: number;
  faces: Uint32Array;
  /** Of the first frame. */
  positions: Float32Array;
  /** Faces in the file. */
  whole: number;
  /** Balls around some frames. */
  reach: Ball[];
}

export type Ask = { open: File } | { frame: number };
export type Told =
  { is: "open"; opened: Opened } | { is: "frame"; positions: Float32Array } | { is: "problem"; problem: string };

/** Frames that tell where the mesh goes. */
const SAMPLED = 8;

let frame: (index: number) => Promise<Float32Array> = () => Promise.reject(new Error("Nothing is open."));

self.onmessage = ({ data }: MessageEvent<Ask>) => {
  const tell = (told: Told, given: Transferable[] = []) => self.postMessage(told, { transfer: given });
  const work = async () => {
    if ("frame" in data) tell({ is: "frame", positions: await frame(data.frame) });
    else {
      const opened = await open(data.open);
      tell({ is: "open", opened }, [opened.faces.buffer]);
    }
  };
  work().catch((error: unknown) => tell({ is: "problem", problem: reasonOf(error) }));
};

async function open({ content, kind, format, most }: File): Promise<Opened> {
  const sequence = await read(content, kind, format);
  const first = await sequence.positions(0);
  const coarse = coarsen({ positions: first, faces: sequence.faces }, most);
  const drawn = (positions: Float32Array) => (coarse ? coarse.gather(positions) : positions);
  frame = async (index) => drawn(await sequence.positions(index));
  const positions = drawn(first);
  const reach: Ball[] = [];
  for (const index of spread(sequence.frames, SAMPLED)) reach.push(ballOf(index > 0 ? await frame(index) : positions));
  return {
    frames: sequence.frames,
    faces: coarse?.faces ?? sequence.faces,
    positions,
    whole: sequence.faces.length / 3,
    reach,
  };
}

/** Readers are fetched when a file needs them. */
async function read(content: ArrayBuffer, kind: Asset["kind"], format: string): Promise<Sequence> {
  if (kind === "sequence") return (await import("./sequence")).openSequence(new Blob([content]));
  const { faces, positions } = (await import("./mesh")).readMesh(content, format);
  return { frames: 1, faces, positions: () => Promise.resolve(positions) };
}
