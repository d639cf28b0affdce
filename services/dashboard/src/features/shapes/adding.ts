import { newIdempotencyKey } from "@/api/idempotency";
import { describe } from "@/api/problem";
import type { Asset, Batch, BatchCreate } from "@/api/types";
import { createStore, type Store } from "@/app/store";
import type { Parcel } from "@/features/uploads/gather";
import type { UploadItem, UploadManager } from "@/features/uploads/manager";
import { kindName } from "@/format/asset";

/** Meshes on their way into the bank. */
export interface Addition {
  id: string;
  collection: string;
  uploads: readonly string[];
  total: number;
  /** The batches that index them, once all are uploaded. */
  batches: readonly string[];
  /** What does not become a shape, and why. */
  refused: readonly { name: string; why: string }[];
  error: string | null;
}

interface Dependencies {
  uploads: Pick<UploadManager, "add" | "settled" | "remove">;
  asset: (id: string) => Promise<Asset>;
  createBatch: (request: BatchCreate, idempotencyKey: string) => Promise<Batch>;
  batchLimit: () => Promise<number>;
}

/** Uploads meshes and has them indexed; goes on while one looks at other pages. */
export class Adding {
  readonly additions: Store<readonly Addition[]> = createStore<readonly Addition[]>([]);
  readonly #dependencies: Dependencies;

  constructor(dependencies: Dependencies) {
    this.#dependencies = dependencies;
  }

  async add(parcels: readonly Parcel[], collection: string, labels: Readonly<Record<string, string>>): Promise<void> {
    await this.#while(parcels.length, collection, async (id) => {
      const ids = await this.#dependencies.uploads.add(parcels);
      this.#change(id, { uploads: ids });
      const { meshes, refused } = await this.#sorted(await this.#dependencies.uploads.settled(ids));
      this.#change(id, { refused, total: meshes.length });
      await this.#index(id, meshes, { collection, ...(Object.keys(labels).length > 0 ? { labels } : {}) });
    });
  }

  /** Index meshes that are on the server. */
  async index(meshes: readonly string[], collection: string): Promise<void> {
    await this.#while(meshes.length, collection, (id) => this.#index(id, meshes, { collection }));
  }

  async #while(total: number, collection: string, work: (id: string) => Promise<void>): Promise<void> {
    const id = newIdempotencyKey();
    const start = { id, collection, uploads: [], total, batches: [], refused: [], error: null };
    this.additions.set([...this.additions.get(), start]);
    try {
      await work(id);
    } catch (error) {
      const { message, hint } = describe(error);
      this.#change(id, { error: `${message} ${hint}`.trim() });
    }
  }

  async #index(id: string, meshes: readonly string[], params: BatchCreate["params"]): Promise<void> {
    const limit = await this.#dependencies.batchLimit();
    for (let from = 0; from < meshes.length; from += limit) {
      const items = meshes.slice(from, from + limit).map((mesh) => ({ inputs: { mesh }, params: {} }));
      const request = { kind: "shape-index", params, items };
      const batch = await this.#dependencies.createBatch(request, `${id}-${from}`);
      this.#change(id, { batches: [...this.#find(id).batches, batch.id] });
    }
  }

  /** Show it no longer; what runs goes on. */
  forget(id: string): void {
    this.additions.set(this.additions.get().filter((one) => one.id !== id));
  }

  async #sorted(items: readonly UploadItem[]) {
    const meshes: string[] = [];
    const refused: { name: string; why: string }[] = [];
    for (const { id, name, assetId, error } of items) {
      const asset = assetId ? await this.#dependencies.asset(assetId) : null;
      if (asset?.kind === "mesh") meshes.push(asset.id);
      else if (asset) refused.push({ name, why: `It is no mesh, but: ${kindName(asset.kind).toLowerCase()}.` });
      else {
        refused.push({ name, why: error?.message ?? "It was not uploaded." });
        await this.#dependencies.uploads.remove(id); // told here, it need not wait among the uploads
      }
    }
    return { meshes, refused };
  }

  #find(id: string): Addition {
    const found = this.additions.get().find((one) => one.id === id);
    return found ?? { id, collection: "", uploads: [], total: 0, batches: [], refused: [], error: null };
  }

  #change(id: string, change: Partial<Addition>): void {
    this.additions.set(this.additions.get().map((one) => (one.id === id ? { ...one, ...change } : one)));
  }
}
