import { QueryClient } from "@tanstack/react-query";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { keys, mergeEvent, newestEvent } from "@/api/queries";
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

function watch(after = 0) {
  const controller = new AbortController();
  const seen: number[] = [];
  const modes: string[] = [];
  const done = watchJob(ID, {
    after,
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

it("begins after what is known, and has nothing to do where a job has ended with that", async () => {
  fetched.mockResolvedValueOnce(new Response(null, { status: 204 }));
  const { seen, modes, done } = watch(7);
  await vi.runAllTimersAsync();
  await done;
  expect(fetched.mock.calls.map(([request]) => request.headers.get("Last-Event-ID"))).toEqual(["7"]);
  expect([seen, modes]).toEqual([[], []]);
});

it("lets no event that is known already change a job: not of a run before this one, and not when it has ended", () => {
  const job = { state: "running", fraction: 0.2, event: 5 } as Job;
  expect(mergeEvent(job, event(4, "cancelled"))).toBe(job);
  expect(mergeEvent(job, event(5, "running", 0.9))).toBe(job);
  const ended = mergeEvent(job, event(6, "succeeded", 1));
  expect(ended).toMatchObject({ state: "succeeded", event: 6 });
  expect(mergeEvent(ended, event(6, "running"))).toBe(ended);
  expect(mergeEvent(ended, event(7, "queued")).state).toBe("queued"); // a retry
});

it("knows the newest event of every cached copy", () => {
  const client = new QueryClient();
  expect(newestEvent(client, ID)).toBe(0);
  client.setQueryData(keys.job(ID), { id: ID, event: 3 });
  client.setQueryData([...keys.jobLists, "first"], {
    items: [
      { id: ID, event: 8 },
      { id: "another", event: 9 },
    ],
  });
  expect(newestEvent(client, ID)).toBe(8);
});

it("says that there is a newer preview, and when there is none any more", () => {
  const job = { state: "running", preview: 3, attempt: 1, event: 6 } as Job;
  expect(mergeEvent(job, { ...event(7, "running"), preview: 7 }).preview).toBe(7);
  expect(mergeEvent(job, { ...event(8, "queued"), preview: 0 }).preview).toBe(0);
});
