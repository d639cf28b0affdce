import { createStore } from "@/app/store";

/** Whether the server answers; every request reports here. */
export type Connection = "up" | "down";

export const connection = createStore<Connection>("up");

export function reportAnswer(): void {
  connection.set("up");
}

export function reportSilence(): void {
  connection.set("down");
}

/** Resolve when the server answers again, or after `milliseconds`, whichever comes first. */
export function untilReachable(milliseconds: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const done = () => {
      clearTimeout(timer);
      unsubscribe();
      signal?.removeEventListener("abort", done);
      resolve();
    };
    const timer = setTimeout(done, milliseconds);
    const unsubscribe = connection.subscribe(() => {
      if (connection.get() === "up") done();
    });
    signal?.addEventListener("abort", done, { once: true });
    if (signal?.aborted) done();
  });
}
