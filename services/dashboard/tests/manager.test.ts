import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { connection } from "@/api/connection";
import { ApiError, Unreachable } from "@/api/problem";
import type { Keep, UploadRecord } from "@/features/uploads/keep";
import { type Exclusively, judge, patiently, UploadManager } from "@/features/uploads/manager";
import type { Transfer } from "@/features/uploads/transfer";

/** Unfinished uploads in memory: what outlives a page. */
class MemoryKeep implements Keep {
  readonly kept = new Map<string, UploadRecord>();
  readonly contents = new Map<string, Blob>();
  room = true;
  records = () => [...this.kept.values()].map((record) => ({ ...record }));
  save = (record: UploadRecord) => void this.kept.set(record.id, { ...record });
  drop = async (id: string) => {
    this.kept.delete(id);
    this.contents.delete(id);
  };
  saveContent = async (id: string, content: Blob) => {
    if (this.room) this.contents.set(id, content);
    return this.room;
  };
  content = async (id: string) => this.contents.get(id) ?? null;
}

/** A transfer that the test finishes by hand. */
interface Attempt extends Transfer {
  resolve: (assetId: string) => void;
  reject: (error: Error) => void;
}

function setUp(keep = new MemoryKeep()) {
  const attempts: Attempt[] = [];
  const terminated: string[] = [];
  const locks = new Set<string>();
  const exclusively: Exclusively = async (id, work) => {
    if (locks.has(id)) return false;
    locks.add(id);
    await work();
    locks.delete(id);
    return true;
  };
  const manager = new UploadManager({
    keep,
    now: Date.now,
    transfer: (transfer) =>
      new Promise((resolve, reject) => {
        attempts.push({ ...transfer, resolve, reject });
        transfer.signal.addEventListener("abort", () => reject(transfer.signal.reason));
      }),
    terminate: async (url) => void terminated.push(url),
    exclusively,
    takeUp: patiently(exclusively),
  });
  const states = () => manager.items.get().map((item) => item.state);
  return { manager, keep, attempts, terminated, locks, states };
}

const settle = () => vi.advanceTimersByTimeAsync(0);
const parcel = (name: string, size = 10) => ({ type: "file", name, file: new File(["x".repeat(size)], name) }) as const;

beforeEach(() => {
  vi.useFakeTimers();
  connection.set("up");
});
afterEach(() => {
  vi.useRealTimers();
});

describe("UploadManager", () => {
  it("tells when some of its uploads are over", async () => {
    const { manager, attempts } = setUp();
    const ids = await manager.add([parcel("a"), parcel("b"), parcel("c")]);
    await manager.add([parcel("other")]);
    let over: string[] | null = null;
    void manager.settled(ids).then((items) => (over = items.map(({ name, state }) => `${name} ${state}`)));
    await settle();
    attempts[0]?.resolve("asset");
    attempts[1]?.reject(new ApiError(422, "corrupt_file", "It is broken.", ""));
    await settle();
    manager.clearDone(); // what was done before stays known
    expect(over).toBeNull();
    await manager.remove(ids[2] ?? "");
    await settle();
    expect(over).toEqual(["a done", "b failed"]);
  });

  it("uploads three at once and then the next", async () => {
    const { manager, attempts, states } = setUp();
    await manager.add(["a", "b", "c", "d", "e"].map((name) => parcel(name)));
    await settle();
    expect(states()).toEqual(["sending", "sending", "sending", "queued", "queued"]);
    attempts[0]?.resolve("asset-a");
    await settle();
    expect(attempts.map(({ name }) => name)).toEqual(["a", "b", "c", "d"]);
    expect(manager.items.get()[0]).toMatchObject({
      state: "done",
      assetId: "asset-a",
      sent: 10,
    });
  });

  it("goes on where it stopped after the connection was lost, as often as it takes", async () => {
    const { manager, attempts, states, keep } = setUp();
    const done: string[] = [];
    manager.onDone = (id) => done.push(id);
    await manager.add([parcel("a")]);
    await settle();
    attempts[0]?.onUrl("/v1/uploads/1");
    for (let loss = 0; loss < 12; loss += 1) {
      attempts.at(-1)?.reject(new Unreachable());
      await settle();
      expect(states()).toEqual(["waiting"]);
      await vi.advanceTimersByTimeAsync(20_000);
      expect(states()).toEqual(["sending"]);
      expect(attempts.at(-1)?.url).toBe("/v1/uploads/1");
    }
    attempts.at(-1)?.resolve("asset-1");
    await settle();
    expect(done).toEqual(["asset-1"]);
    expect(keep.kept.size + keep.contents.size).toBe(0);
  });

  it("does not wait out its time when the server is back earlier", async () => {
    const { manager, attempts, states } = setUp();
    await manager.add([parcel("a")]);
    await settle();
    connection.set("down");
    attempts[0]?.reject(new Unreachable());
    await settle();
    expect(states()).toEqual(["waiting"]);
    connection.set("up");
    await settle();
    expect(states()).toEqual(["sending"]);
  });

  it("starts over when the server no longer has what was sent", async () => {
    const { manager, attempts } = setUp();
    await manager.add([parcel("a")]);
    await settle();
    attempts[0]?.onUrl("/v1/uploads/1");
    attempts[0]?.reject(new ApiError(410, "upload_expired", "expired", ""));
    await settle();
    expect(attempts[1]?.url).toBeNull();
  });

  it("fails with the server's reason, and can be sent again by hand", async () => {
    const { manager, attempts, states } = setUp();
    await manager.add([parcel("a")]);
    await settle();
    attempts[0]?.reject(new ApiError(422, "unknown_format", "It is of no known format.", "Send NIfTI."));
    await settle();
    const [item] = manager.items.get();
    expect(item).toMatchObject({
      state: "failed",
      error: { code: "unknown_format", hint: "Send NIfTI." },
    });
    manager.resume(item?.id ?? "");
    await settle();
    expect(states()).toEqual(["sending"]);
    expect(attempts).toHaveLength(2);
  });

  it("pauses and continues", async () => {
    const { manager, attempts, states } = setUp();
    await manager.add([parcel("a")]);
    await settle();
    const id = manager.items.get()[0]?.id ?? "";
    attempts[0]?.onUrl("/v1/uploads/1");
    manager.pause(id);
    await settle();
    expect(states()).toEqual(["paused"]);
    expect(attempts[0]?.signal.aborted).toBe(true);
    manager.resume(id);
    await settle();
    expect(attempts[1]).toMatchObject({ url: "/v1/uploads/1" });
    expect(attempts[1]?.signal.aborted).toBe(false);
  });

  it("removes what the server has when an upload is called off, and nothing of a finished one", async () => {
    const { manager, attempts, terminated, keep } = setUp();
    await manager.add([parcel("a"), parcel("b")]);
    await settle();
    attempts[0]?.onUrl("/v1/uploads/1");
    attempts[1]?.onUrl("/v1/uploads/2");
    attempts[1]?.resolve("asset-b");
    await settle();
    for (const { id } of manager.items.get()) await manager.remove(id);
    await settle();
    expect(terminated).toEqual(["/v1/uploads/1"]);
    expect(manager.items.get()).toEqual([]);
    expect(keep.kept.size).toBe(0);
  });

  it("takes up after a reload what was interrupted, with the content it had kept", async () => {
    const before = setUp();
    await before.manager.add([parcel("a")]);
    await settle();
    before.attempts[0]?.onUrl("/v1/uploads/1");
    const after = setUp(before.keep);
    await after.manager.restore();
    await settle();
    expect(after.attempts).toHaveLength(1);
    expect(after.attempts[0]).toMatchObject({
      url: "/v1/uploads/1",
      name: "a",
    });
    expect(after.attempts[0]?.content.size).toBe(10);
  });

  it("asks for the file where there was no room for its content, and takes only one of the same size", async () => {
    const keep = new MemoryKeep();
    keep.room = false;
    const before = setUp(keep);
    await before.manager.add([parcel("a")]);
    await settle();
    before.attempts[0]?.onUrl("/v1/uploads/1");
    const after = setUp(keep);
    await after.manager.restore();
    await settle();
    expect(after.states()).toEqual(["needs-file"]);
    const id = after.manager.items.get()[0]?.id ?? "";
    expect(await after.manager.continueWith(id, new Blob(["short"]))).toBe(false);
    await after.manager.add([parcel("a")]); // dropping it again is as good as choosing it
    await settle();
    expect(after.states()).toEqual(["sending"]);
    expect(after.attempts[0]?.url).toBe("/v1/uploads/1");
  });

  it("leaves alone what another tab is sending", async () => {
    const before = setUp();
    await before.manager.add([parcel("a")]);
    await settle();
    const other = setUp(before.keep);
    for (const record of before.keep.records()) other.locks.add(record.id);
    void other.manager.restore();
    await vi.advanceTimersByTimeAsync(5_000);
    expect(other.manager.items.get()).toEqual([]);
  });

  it("does not take up what another tab has just finished", async () => {
    const before = setUp();
    await before.manager.add([parcel("a")]);
    await settle();
    const other = setUp(before.keep);
    for (const record of before.keep.records()) other.locks.add(record.id);
    void other.manager.restore();
    before.attempts[0]?.resolve("asset-1");
    await settle();
    other.locks.clear();
    await vi.advanceTimersByTimeAsync(5_000);
    expect(other.manager.items.get()).toEqual([]);
  });

  it("measures its speed", async () => {
    const { manager, attempts } = setUp();
    await manager.add([parcel("a", 10_000)]);
    await settle();
    for (const sent of [1000, 2000, 3000]) {
      await vi.advanceTimersByTimeAsync(1000);
      attempts[0]?.onProgress(sent);
    }
    expect(manager.items.get()[0]).toMatchObject({ sent: 3000, rate: 1000 });
  });
});

describe("judge", () => {
  it.each([
    [new Unreachable(), 99, "again"],
    [new ApiError(423, "upload_locked", "", ""), 1, "again"],
    [new ApiError(429, "rate_limited", "", ""), 7, "again"],
    [new ApiError(500, "internal_error", "", ""), 8, "give-up"],
    [new ApiError(404, "not_found", "", ""), 1, "start-over"],
    [new ApiError(404, "not_found", "", ""), 3, "give-up"],
    [new ApiError(413, "request_too_large", "", ""), 1, "give-up"],
    [new RangeError("zip"), 1, "give-up"],
  ])("%s after %d failures: %s", (error, failures, verdict) => expect(judge(error, failures)).toBe(verdict));
});
