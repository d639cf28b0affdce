import type { CompareAnswer } from "./compare.worker";
import type { Overlap } from "./overlap";

/** Compare two label volumes in a thread of their own; `ours` and `theirs` are given away. */
export function compareLabels(ours: ArrayBuffer, theirs: ArrayBuffer, signal: AbortSignal): Promise<Overlap> {
  return new Promise((resolve, reject) => {
    const worker = new Worker(new URL("./compare.worker.ts", import.meta.url), { type: "module" });
    const end = () => worker.terminate();
    signal.addEventListener("abort", end, { once: true });
    worker.onmessage = ({ data }: MessageEvent<CompareAnswer>) => {
      end();
      if ("overlap" in data) resolve(data.overlap);
      else reject(new Error(data.problem));
    };
    worker.onerror = (event) => {
      end();
      reject(new Error(event.message || "The comparison broke off."));
    };
    worker.postMessage({ ours, theirs }, [ours, theirs]);
  });
}
