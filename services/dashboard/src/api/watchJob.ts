import { apiFetch } from "./client";
import { untilReachable } from "./connection";
import { readMessages } from "./eventStream";
import { ApiError } from "./problem";
import { isTerminal, type JobEvent } from "./types";

/** How a job's changes arrive: pushed by its stream, or (where a proxy swallows streams) by asking again and again. */
export type WatchMode = "stream" | "poll";

interface Watch {
  /** Number of the event after which to begin. */
  after: number;
  onEvent: (event: JobEvent) => void;
  onMode: (mode: WatchMode) => void;
  signal: AbortSignal;
}

/** Follow a job's events until it has ended or `signal` aborts; reconnects where it left off. */
export async function watchJob(jobId: string, { after, onEvent, onMode, signal }: Watch): Promise<void> {
  let last = after ? String(after) : "";
  let failures = 0;
  while (!signal.aborted) {
    try {
      const response = await apiFetch(`/v1/jobs/${jobId}/events`, {
        headers: {
          Accept: "text/event-stream",
          ...(last ? { "Last-Event-ID": last } : {}),
        },
        cache: "no-store",
        signal,
      });
      if (response.status === 204) return; // it has ended, and nothing is new
      if (!response.body) throw new Error("the stream has no body");
      for await (const message of readMessages(response.body)) {
        failures = 0;
        onMode("stream");
        if (message.id) last = message.id;
        const event = JSON.parse(message.data) as JobEvent;
        onEvent(event);
        if (isTerminal(event.state)) return;
      }
      failures += 1; // it ended without the job having ended
    } catch (error) {
      if (signal.aborted) return;
      // Nothing will come of asking again: the job is not there, or the key is not valid.
      if (error instanceof ApiError && error.status < 500 && error.status !== 429) {
        onMode("poll");
        return;
      }
      failures += 1;
    }
    if (failures >= 2) onMode("poll");
    await untilReachable(Math.min(500 * 2 ** failures, 15_000), signal);
    await new Promise((resolve) => setTimeout(resolve, 250)); // never a tight loop, whatever the server does
  }
}
