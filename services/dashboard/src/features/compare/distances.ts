import type { Asset } from "@/api/types";
import { download } from "@/viewers/download";
import type { DistanceAnswer, DistanceQuestion } from "./distance.worker";

/** Measure, in a thread of its own, how far points lie from a mask's border: mm, negative inside. */
export async function distancesTo(
  reference: Asset,
  values: readonly number[] | null,
  points: Float32Array[],
  signal: AbortSignal,
): Promise<Float32Array[]> {
  const mask = await download(reference.content_url, reference.size, () => undefined, signal);
  return new Promise((resolve, reject) => {
    const worker = new Worker(new URL("./distance.worker.ts", import.meta.url), { type: "module" });
    const end = () => worker.terminate();
    signal.addEventListener("abort", end, { once: true });
    worker.onmessage = ({ data }: MessageEvent<DistanceAnswer>) => {
      end();
      if ("distances" in data) resolve(data.distances);
      else reject(new Error(data.problem));
    };
    worker.onerror = (event) => {
      end();
      reject(new Error(event.message || "Measuring the distances broke off."));
    };
    const question: DistanceQuestion = { mask, values, points };
    worker.postMessage(question, [mask]);
  });
}
