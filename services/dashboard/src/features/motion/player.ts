import type { Ask, Told } from "./player.worker";
import type { Ball } from "./reach";
import type { Header } from "./smc/container";

export interface Opened {
  header: Header;
  faces: Uint32Array;
  /** The cluster of each vertex in the first group. */
  labels: Int32Array;
  /** Balls around some frames. */
  reach: readonly Ball[];
}

/** A motion that is decoded in a thread of its own; of frames asked for while one is decoded, the latest counts. */
export class MotionPlayer {
  readonly #worker = new Worker(new URL("./player.worker.ts", import.meta.url), { type: "module" });
  readonly #onFrame: (frame: number, positions: Float32Array) => void;
  #spare: Float32Array | null = null;
  #wanted: number | null = null;

  constructor(onFrame: (frame: number, positions: Float32Array) => void) {
    this.#onFrame = onFrame;
  }

  open(content: ArrayBuffer, onProblem: (problem: Error) => void): Promise<Opened> {
    return new Promise((resolve, reject) => {
      this.#worker.onerror = (event) => reject(new Error(event.message || "The motion could not be decoded."));
      this.#worker.onmessage = ({ data }: MessageEvent<Told>) => {
        if (data.is === "open") {
          this.#spare = new Float32Array(3 * data.header.vertices);
          resolve(data);
        } else if (data.is === "problem") {
          reject(new Error(data.problem));
          onProblem(new Error(data.problem));
        } else {
          this.#onFrame(data.frame, data.positions);
          this.#spare = data.positions;
          if (this.#wanted !== null) this.want(this.#wanted);
        }
      };
      const ask: Ask = { open: content };
      this.#worker.postMessage(ask, [content]);
    });
  }

  /** Whether a frame is being decoded. */
  get busy(): boolean {
    return this.#spare === null;
  }

  want(frame: number): void {
    const into = this.#spare;
    if (!into) {
      this.#wanted = frame;
      return;
    }
    this.#wanted = null;
    this.#spare = null;
    const ask: Ask = { frame, into };
    this.#worker.postMessage(ask, [into.buffer]);
  }

  close(): void {
    this.#worker.terminate();
  }
}
