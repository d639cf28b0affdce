import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { mergeEvent } from "@/api/queries";
import type { Job, JobEvent } from "@/api/types";
import { watchJob } from "@/api/watchJob";

const ID = "0192f0c1-0000-7000-8000-000000000001";

function event(seq: number, state: JobEvent["state"], fraction = 0): JobEvent {
  const at = `2026-01-01T00:00:0${seq}Z`;
  return {
    seq,
    type: "progress",
    job_id: ID,
    state,
    stage: "evolve",
    fraction,
    message: "",
    preview: 0,
    at,
  };
}

function stream(...events: JobEvent[]): Response {
  return new Response(
    events.map((one) => `id: ${one.seq}\nevent: ${one.type}\ndata: ${JSON.stringify(one)}\n\n`).join(""),
  );
}

const fetched = vi.fn<(request: Request) => Promise<Response>>();

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("fetch", fetched);
  // Requests need a whole address outside of a browser.
  const { Request: Plain } = globalThis;
  vi.stubGlobal(
    "Request",
    class extends Plain {
      constructor(input: string | Request, init?: RequestInit) {
        super(typeof input === "string" ? new URL(input, "http://server.test").href : input, init);
      }
    },
  );
});

afterEach(() => {
  fetched.mockReset();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

function watch() {
  const controller = new AbortController();
  const seen: number[] = [];
  const modes: string[] = [];
  const done = watchJob(ID, {
    onEvent: ({ seq }) => seen.push(seq),
    onMode: (mode) => modes.push(mode),
    signal: controller.signal,
  });
  return { controller, seen, modes, done };
}

it("goes on after the last event when the stream breaks, and ends with the job", async () => {
  fetched
    .mockResolvedValueOnce(stream(event(1, "running"), event(2, "running", 0.5)))
    .mockRejectedValueOnce(new TypeError("network"))
    .mockResolvedValueOnce(stream(event(3, "running", 0.7), event(4, "succeeded", 1)));
  const { seen, done } = watch();
  await vi.runAllTimersAsync();
  await done;
  expect(seen).toEqual([1, 2, 3, 4]);
  expect(fetched.mock.calls.map(([request]) => request.headers.get("Last-Event-ID"))).toEqual([null, "2", "2"]);
});

it("says that one has to ask while no stream comes through, and that one need not when it does again", async () => {
  fetched
    .mockImplementationOnce(async () => stream()) // a proxy that ends every stream at once
    .mockImplementationOnce(async () => stream())
    .mockResolvedValueOnce(stream(event(1, "succeeded", 1)));
  const { modes, done } = watch();
  await vi.runAllTimersAsync();
  await done;
  expect(modes).toEqual(["poll", "stream"]);
});

it("gives up where asking again is of no use", async () => {
  fetched.mockResolvedValue(
    new Response(JSON.stringify({ detail: "no", code: "not_found", status: 404 }), { status: 404 }),
  );
  const { modes, done } = watch();
  await vi.runAllTimersAsync();
  await done;
  expect(fetched).toHaveBeenCalledTimes(1);
  expect(modes).toEqual(["poll"]);
});

it("stops when nobody watches any longer", async () => {
  fetched.mockRejectedValue(new TypeError("network"));
  const { controller, done } = watch();
  await vi.advanceTimersByTimeAsync(1500);
  const asked = fetched.mock.calls.length;
  controller.abort();
  await vi.runAllTimersAsync();
  await done;
  expect(fetched.mock.calls.length).toBe(asked);
});

it("does not let a late event bring an ended job back", () => {
  const job = {
    state: "succeeded",
    fraction: 1,
    stage: "",
    message: "",
    finished_at: "2026-01-01T00:00:05Z",
  } as Job;
  expect(mergeEvent(job, event(4, "running", 0.9))).toBe(job);
  expect(mergeEvent(job, event(6, "queued")).state).toBe("queued"); // a retry, later
});

it("says that there is a newer preview, and when there is none any more", () => {
  const job = { state: "running", preview: 3, attempt: 1 } as Job;
  expect(mergeEvent(job, { ...event(7, "running"), preview: 7 }).preview).toBe(7);
  expect(mergeEvent(job, { ...event(8, "queued"), preview: 0 }).preview).toBe(0);
});
