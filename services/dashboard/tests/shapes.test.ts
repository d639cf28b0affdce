import { describe, expect, it, vi } from "vitest";
import { requestOf } from "@/api/search";
import type { Asset, Batch, BatchCreate } from "@/api/types";
import { createStore } from "@/app/store";
import { type Addition, Adding } from "@/features/shapes/adding";
import { CAPTION, GAP, layOut, visibleRows } from "@/features/shapes/grid";
import { readLabel, readLabels, writeLabels } from "@/features/shapes/labels";
import { readAddress, readParts, searchOf, writeParts } from "@/features/shapes/searching";
import { searchSnippets } from "@/features/snippets/snippets";
import type { UploadItem } from "@/features/uploads/manager";

describe("the wall", () => {
  it("fills the width with as many columns as there is room for", () => {
    const grid = layOut(1000);
    expect(grid.columns).toBe(5);
    expect(grid.columns * grid.side + (grid.columns - 1) * GAP).toBeLessThanOrEqual(1000);
    expect(grid.pitch).toBe(grid.side + CAPTION + GAP);
    expect(layOut(200).columns).toBe(2);
  });

  it("holds only what is in sight of ten thousand", () => {
    const grid = layOut(1000);
    const rows = 2000;
    expect(visibleRows(grid, 10_000, 0, 700)).toEqual([0, Math.ceil(700 / grid.pitch) + 2]);
    const [first, last] = visibleRows(grid, 10_000, 1000 * grid.pitch, 700);
    expect(first).toBe(998);
    expect(last).toBeLessThan(1010);
    expect(visibleRows(grid, 10_000, rows * grid.pitch, 700)).toEqual([rows - 2, rows]);
    expect(visibleRows(grid, 0, 0, 700)).toEqual([0, 0]);
  });
});

describe("labels", () => {
  it("are names and values with a colon between them", () => {
    expect(readLabel("side: left")).toEqual(["side", "left"]);
    expect(readLabel("found at:12:30")).toEqual(["found at", "12:30"]);
    expect(readLabel("no colon")).toBeNull();
    expect(readLabel(":x")).toBeNull();
    expect(readLabels(["a:1", "nothing", "a:2", "b:"])).toEqual({ a: "2", b: "" });
    expect(readLabels(writeLabels({ side: "left", "found at": "12:30" }))).toEqual({
      side: "left",
      "found at": "12:30",
    });
  });
});

describe("a search's address", () => {
  it("holds what is needed to search again, and nothing else", () => {
    const address = readAddress({
      shape: "id",
      asset: "ignored beside a shape",
      parts: "3,7,x,7",
      mode: "global",
      collection: 2024,
      labels: ["a:b", 5],
      rerank: "yes",
      other: 1,
    });
    expect(address).toEqual({ shape: "id", parts: "3,7", collection: "2024", labels: ["a:b"] });
    expect(requestOf(searchOf(address))).toEqual({
      shape_id: "id",
      parts: [3, 7],
      mode: "partial",
      collection: "2024",
      labels: { a: "b" },
      limit: 40,
      rerank: false,
    });
    expect(readAddress({ asset: "mesh", mode: "partial", rerank: true, round: 2 })).toEqual({
      asset: "mesh",
      mode: "partial",
      rerank: true,
      round: 2,
    });
    // what makes no sense is overruled, or it would pass as the address has it
    expect(readAddress({ shape: "id", labels: 5 })).toHaveProperty("labels", undefined);
    expect(readAddress({ shape: "id", labels: "class:cup" }).labels).toEqual(["class:cup"]);
    expect(readAddress({ parts: 4 })).toEqual({ parts: "4" }); // a lone number arrives as one
    expect(readParts(writeParts([5, 0, 31]))).toEqual([5, 0, 31]);
    expect(readParts(undefined)).toEqual([]);
  });

  it("becomes code that does the same", () => {
    const target = { server: "http://127.0.0.1:8000", keyed: false };
    const request = requestOf({ shape: "1", parts: [2, 5], collection: "old bones", labels: { side: "left" } });
    const { curl, command, python } = searchSnippets(request, target);
    expect(curl).toContain(
      `-d '{"shape_id":"1","parts":[2,5],"collection":"old bones","labels":{"side":"left"},"limit":40}'`,
    );
    expect(command.replaceAll(" \\\n   ", "")).toBe(
      "shapery search 1 --part 2 --part 5 --collection 'old bones' --label side:left --limit 40 --server http://127.0.0.1:8000",
    );
    expect(python).toContain(
      'shapery.search(shape="1", parts=[2, 5], collection="old bones", labels={"side": "left"}, limit=40)',
    );
    const mesh = searchSnippets(requestOf({ asset: "9", mode: "partial", rerank: true }), target, "my bone.ply");
    expect(mesh.curl).toContain('{"asset_id":"9","mode":"partial","limit":40,"rerank":true}');
    expect(mesh.command).toContain("search 'my bone.ply'");
    expect(mesh.command).toContain("--partial");
    expect(mesh.python).toContain('asset="9", mode="partial", limit=40, rerank=True');
  });
});

describe("adding shapes", () => {
  const parcel = (name: string) => ({ type: "file" as const, name, file: new File(["x"], name) });

  /** A visit of the page; what is kept and which uploads have arrived may be those of an earlier one. */
  function bench(limit: number, { refuse = false, kept = new Map<string, Addition>(), waits = false } = {}) {
    const requests: { request: BatchCreate; key: string }[] = [];
    const removed: string[] = [];
    const kinds: Record<string, Asset["kind"]> = { "scan.nii": "volume" };
    const items = createStore<readonly UploadItem[]>([]);
    const item = (name: string) =>
      ({
        id: name,
        name,
        assetId: name === "broken.ply" ? null : `asset of ${name}`,
        error: name === "broken.ply" ? { message: "It is no mesh.", code: "", hint: "" } : null,
      }) as UploadItem;
    const adding = new Adding({
      uploads: {
        items,
        add: async (parcels) => parcels.map(({ name }) => name),
        remove: async (id) => void removed.push(id),
        settled: (ids) => (waits ? new Promise(() => undefined) : Promise.resolve(ids.map(item))),
      },
      asset: async (id) => ({ id, kind: kinds[id.slice(9)] ?? "mesh" }) as Asset,
      createBatch: async (request, key) => {
        if (refuse) throw new Error("There is no room.");
        requests.push({ request, key });
        return { id: `batch ${requests.length}` } as Batch;
      },
      batchLimit: async () => limit,
      keep: {
        all: () => [...kept.values()],
        save: (addition) => void kept.set(addition.id, structuredClone(addition)),
        drop: (id) => void kept.delete(id),
      },
      exclusively: async (_id, work) => {
        await work();
        return true;
      },
      now: () => 1e12,
    });
    return { adding, requests, removed, kept, arrive: (...names: string[]) => items.set(names.map(item)) };
  }

  it("indexes the meshes, and tells what is none", async () => {
    const { adding, requests, removed } = bench(2);
    const names = ["a.ply", "broken.ply", "b.ply", "scan.nii", "c.ply"];
    await adding.add(names.map(parcel), "bones", { side: "left" });
    expect(requests.map(({ request }) => request)).toEqual([
      {
        kind: "shape-index",
        params: { collection: "bones", labels: { side: "left" } },
        items: ["a.ply", "b.ply"].map((name) => ({ inputs: { mesh: `asset of ${name}` }, params: {} })),
      },
      {
        kind: "shape-index",
        params: { collection: "bones", labels: { side: "left" } },
        items: [{ inputs: { mesh: "asset of c.ply" }, params: {} }],
      },
    ]);
    expect(new Set(requests.map(({ key }) => key)).size).toBe(2);
    const [addition] = adding.additions.get();
    expect(addition).toMatchObject({ total: 3, batches: ["batch 1", "batch 2"], error: null });
    expect(addition?.refused).toEqual([
      { name: "broken.ply", why: "It is no mesh." },
      { name: "scan.nii", why: "It is no mesh, but: volume." },
    ]);
    expect(removed).toEqual(["broken.ply"]);
    adding.forget(addition?.id ?? "");
    expect(adding.additions.get()).toEqual([]);
  });

  it("indexes what is on the server", async () => {
    const { adding, requests } = bench(10);
    await adding.index(["mesh"], "tumors");
    const items = [{ inputs: { mesh: "mesh" }, params: {} }];
    expect(requests[0]?.request).toEqual({ kind: "shape-index", params: { collection: "tumors" }, items });
  });

  it("makes no batch of nothing, and tells why one was refused", async () => {
    const nothing = bench(10);
    await nothing.adding.add([parcel("broken.ply")], "bones", {});
    expect(nothing.requests).toEqual([]);
    expect(nothing.adding.additions.get()[0]).toMatchObject({ total: 0, batches: [], error: null });
    const refused = bench(10, { refuse: true });
    await refused.adding.add([parcel("a.ply")], "bones", {});
    expect(refused.adding.additions.get()[0]?.error).toBe("There is no room.");
  });

  it("goes on after a reload, with what had arrived before", async () => {
    const before = bench(10, { waits: true });
    void before.adding.add([parcel("a.ply"), parcel("b.ply")], "bones", { side: "left" });
    await vi.waitFor(() => expect(before.adding.additions.get()[0]?.uploads).toHaveLength(2));
    before.arrive("a.ply");
    const after = bench(10, { kept: before.kept });
    after.adding.restore();
    await vi.waitFor(() => expect(after.adding.additions.get()[0]?.handedOver).toBe(true));
    expect(after.requests[0]?.request.items.map(({ inputs }) => inputs.mesh)).toEqual([
      "asset of a.ply",
      "asset of b.ply",
    ]);
    expect(after.requests[0]?.request.params).toEqual({ collection: "bones", labels: { side: "left" } });
    // Once more: the server has it, and it is only told.
    const again = bench(10, { kept: after.kept });
    again.adding.restore();
    expect(again.adding.additions.get()).toMatchObject([{ total: 2, batches: ["batch 1"], handedOver: true }]);
    expect(again.requests).toEqual([]);
    again.adding.forget(again.adding.additions.get()[0]?.id ?? "");
    expect(again.kept.size).toBe(0);
  });

  it("makes the same batches again where the page was left among them", async () => {
    const before = bench(1);
    await before.adding.add(["a.ply", "b.ply"].map(parcel), "bones", {});
    const [addition] = before.kept.values();
    if (addition) before.kept.set(addition.id, { ...addition, batches: ["batch 1"], handedOver: false });
    const after = bench(1, { kept: before.kept });
    after.adding.restore();
    await vi.waitFor(() => expect(after.adding.additions.get()[0]?.handedOver).toBe(true));
    expect(after.requests).toEqual(before.requests);
  });

  it("does not tell for ever of what nobody has closed", async () => {
    const { adding, kept } = bench(10);
    adding.follow({ id: "batch", total: 3 }, "bones");
    const [addition] = kept.values();
    expect(addition).toMatchObject({ again: true, batches: ["batch"], total: 3 });
    if (addition) kept.set(addition.id, { ...addition, createdAt: 1e12 - 25 * 3_600_000 });
    const later = bench(10, { kept });
    later.adding.restore();
    expect(later.adding.additions.get()).toEqual([]);
    expect(kept.size).toBe(0);
  });
});
