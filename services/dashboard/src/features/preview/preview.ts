import type { Picture } from "./picture";
import type { Ask, Told } from "./preview.worker";

/** One file after the other: a dozen volumes at once would not fit into memory. */
let before: Promise<unknown> = Promise.resolve();

/** A small picture of a file in the browser, drawn in a thread of its own; null where it is none that can be drawn. */
export async function picture(file: Blob, name: string, size: number, signal: AbortSignal): Promise<Picture | null> {
  const told = await ask({ draw: file, name, size }, signal);
  return "picture" in told ? told.picture : null;
}

/** A volume of another format as a NIfTI file, made in a thread of its own; throws a sentence where it cannot be read. */
export async function asNifti(file: Blob, format: string, signal: AbortSignal): Promise<Blob> {
  const told = await ask({ convert: file, format }, signal);
  if ("problem" in told) throw new Error(told.problem);
  if (!("volume" in told)) throw new Error("The volume could not be read.");
  return told.volume;
}

function ask(question: Ask, signal: AbortSignal): Promise<Told> {
  const answer = before.then(
    () =>
      new Promise<Told>((resolve, reject) => {
        signal.throwIfAborted();
        const worker = new Worker(new URL("./preview.worker.ts", import.meta.url), { type: "module" });
        const end = () => {
          signal.removeEventListener("abort", abort);
          worker.terminate();
        };
        const abort = () => {
          end();
          reject(new DOMException("No longer wanted.", "AbortError"));
        };
        signal.addEventListener("abort", abort);
        worker.onmessage = ({ data }: MessageEvent<Told>) => {
          end();
          resolve(data);
        };
        worker.onerror = (event) => {
          end();
          reject(new Error(event.message || "The file could not be read."));
        };
        worker.postMessage(question);
      }),
  );
  before = answer.catch(() => undefined);
  return answer;
}
