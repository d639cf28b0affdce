import { apiFetch } from "@/api/client";
import type { Drawn } from "./niftiStream";
import type { Ask, Told } from "./volume.worker";

export interface VolumeFile {
  url: string;
  /** With the extension that tells the format. */
  name: string;
  size: number;
}

/** Pieces that are on their way to the worker; a file may come faster than it is uncompressed. */
const AHEAD = 32;

/**
 * Fetch a NIfTI file as it is drawn: at most `most` voxels, uncompressed and made coarser piece by piece in a thread of
 * its own, so that a file of any size needs no more memory than its picture.
 */
export async function loadVolume(
  { url, size }: VolumeFile,
  most: number,
  labels: boolean,
  onProgress: (fraction: number) => void,
  signal: AbortSignal,
): Promise<Drawn> {
  const response = await apiFetch(url, { signal });
  const reader = (response.body ?? new Blob([]).stream()).getReader();
  const worker = new Worker(new URL("./volume.worker.ts", import.meta.url), { type: "module" });
  const ask = (message: Ask, given: Transferable[] = []) => worker.postMessage(message, given);
  let ahead = 0;
  let more = true;
  let go: () => void = () => undefined;
  try {
    const drawn = new Promise<Drawn>((resolve, reject) => {
      worker.onerror = (event) => reject(new Error(event.message || "The volume could not be read."));
      worker.onmessage = ({ data }: MessageEvent<Told>) => {
        if (data.is === "drawn") resolve(data.drawn);
        else if (data.is === "problem") reject(new Error(data.problem));
        else {
          ahead -= 1;
          more = data.more;
          go();
        }
      };
    });
    drawn.catch(() => undefined); // told below
    ask({ begin: { most, labels } });
    let received = 0;
    while (more) {
      const { done, value } = await reader.read();
      if (done) break;
      received += value.length;
      ahead += 1;
      const own = value.byteLength === value.buffer.byteLength ? value : value.slice();
      ask({ piece: own }, [own.buffer]);
      onProgress(size > 0 ? Math.min(received / size, 1) : 0);
      if (ahead >= AHEAD) await Promise.race([drawn, new Promise<void>((resolve) => (go = resolve))]);
    }
    ask({ end: true });
    return await drawn;
  } finally {
    worker.terminate();
    reader.cancel().catch(() => undefined); // it has ended, or its end is not needed
  }
}
