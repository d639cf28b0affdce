import type { Ask, File, Opened, Told } from "./frames.worker";

/** A mesh, or a sequence of meshes, that is read and made as coarse as can be drawn in a thread of its own. */
export class Frames {
  readonly #worker = new Worker(new URL("./frames.worker.ts", import.meta.url), { type: "module" });

  open(file: File): Promise<Opened> {
    return this.#ask({ open: file }, [file.content]).then((told) => {
      if (told.is !== "open") throw new Error("The mesh could not be read.");
      return told.opened;
    });
  }

  /** x, y and z of each vertex in a frame; one at a time is asked for. */
  positions(frame: number): Promise<Float32Array> {
    return this.#ask({ frame }).then((told) => {
      if (told.is !== "frame") throw new Error("The frame could not be read.");
      return told.positions;
    });
  }

  close(): void {
    this.#worker.terminate();
  }

  #ask(ask: Ask, given: Transferable[] = []): Promise<Told> {
    return new Promise((resolve, reject) => {
      this.#worker.onerror = (event) => reject(new Error(event.message || "The mesh could not be read."));
      this.#worker.onmessage = ({ data }: MessageEvent<Told>) => {
        if (data.is === "problem") reject(new Error(data.problem));
        else resolve(data);
      };
      this.#worker.postMessage(ask, given);
    });
  }
}
