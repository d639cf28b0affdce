import { newIdempotencyKey } from "@/api/idempotency";
import { describe } from "@/api/problem";
import type { Asset, Batch, BatchCreate } from "@/api/types";
import { createStore, type Store } from "@/app/store";
import type { Parcel } from "@/features/uploads/gather";
import type { Exclusively, UploadItem, UploadManager } from "@/features/uploads/manager";
import { kindName } from "@/format/asset";

/** Meshes on their way into the bank. */
export interface Addition {
  id: string;
  createdAt: number;
  collection: string;
  labels: Readonly<Record<string, string>>;
  /** Whether shapes are indexed again that were there. */
  again: boolean;
  uploads: readonly string[];
  /** What of them has arrived, and as what. */
  arrived: Readonly<Record<string, { name: string; asset: string }>>;
  total: number;
  /** What is indexed: assets; null while it is uploaded. */
  meshes: readonly string[] | null;
  /** The batches that index them. */
  batches: readonly string[];
  /** Whether all batches are made: the rest is the server's. */
  handedOver: boolean;
  /** What does not become a shape, and why. */
  refused: readonly { name: string; why: string }[];
  error: string | null;
}

/** Where additions wait for the next visit. */
export interface AdditionKeep {
  all(): Addition[];
  save(addition: Addition): void;
  drop(id: string): void;
}

interface Dependencies {
  uploads: Pick<UploadManager, "add" | "settled" | "remove" | "items">;
  asset: (id: string) => Promise<Asset>;
  createBatch: (request: BatchCreate, idempotencyKey: string) => Promise<Batch>;
  batchLimit: () => Promise<number>;
  keep: AdditionKeep;
  exclusively: Exclusively;
  now: () => number;
}

/** How long an addition is told of that nobody has closed. */
const TOLD = 24 * 3_600_000;

/** Uploads meshes and has them indexed; goes on while one looks at other pages, and after a reload. */
export class Adding {
  readonly additions: Store<readonly Addition[]> = createStore<readonly Addition[]>([]);
  readonly #dependencies: Dependencies;

  constructor(dependencies: Dependencies) {
    this.#dependencies = dependencies;
    dependencies.uploads.items.subscribe(() => this.#noteArrivals());
  }

  async add(parcels: readonly Parcel[], collection: string, labels: Readonly<Record<string, string>>): Promise<void> {
    const id = this.#begin({ collection, labels, total: parcels.length });
    await this.#carry(id, async () => {
      this.#change(id, { uploads: await this.#dependencies.uploads.add(parcels) });
    });
  }

  /** Index meshes that are on the server. */
  async index(meshes: readonly string[], collection: string): Promise<void> {
    await this.#carry(this.#begin({ collection, meshes, total: meshes.length }));
  }

  /** Tell of a batch that indexes shapes of a collection again. */
  follow(batch: Pick<Batch, "id" | "total">, collection: string): void {
    this.#begin({ collection, again: true, meshes: [], batches: [batch.id], handedOver: true, total: batch.total });
  }

  /** Take up what an earlier visit has left unfinished; the uploads have been taken up before. */
  restore(): void {
    for (const addition of this.#dependencies.keep.all()) {
      const { id, createdAt, handedOver, error, uploads, meshes } = addition;
      const lost = uploads.length === 0 && meshes === null;
      if (lost || createdAt < this.#dependencies.now() - TOLD) this.#dependencies.keep.drop(id);
      else if (handedOver || error !== null) this.additions.set([...this.additions.get(), addition]);
      else {
        void this.#dependencies.exclusively(id, () => {
          this.additions.set([...this.additions.get(), addition]);
          return this.#work(id);
        });
      }
    }
  }

  /** Show it no longer; what runs goes on. */
  forget(id: string): void {
    this.#dependencies.keep.drop(id);
    this.additions.set(this.additions.get().filter((one) => one.id !== id));
  }

  #begin(known: Partial<Addition> & Pick<Addition, "collection" | "total">): string {
    const addition: Addition = {
      id: newIdempotencyKey(),
      createdAt: this.#dependencies.now(),
      labels: {},
      again: false,
      uploads: [],
      arrived: {},
      meshes: null,
      batches: [],
      handedOver: false,
      refused: [],
      error: null,
      ...known,
    };
    this.#dependencies.keep.save(addition);
    this.additions.set([...this.additions.get(), addition]);
    return addition.id;
  }

  /** Carry an addition to its end, while other tabs leave it alone. */
  async #carry(id: string, first: () => Promise<void> = () => Promise.resolve()): Promise<void> {
    await this.#dependencies.exclusively(id, () => this.#work(id, first));
  }

  async #work(id: string, first: () => Promise<void> = () => Promise.resolve()): Promise<void> {
    try {
      await first();
      await this.#sort(id);
      await this.#index(id);
    } catch (error) {
      const { message, hint } = describe(error);
      this.#change(id, { error: `${message} ${hint}`.trim() });
    }
  }

  /** Wait for the uploads, and tell meshes from the rest. */
  async #sort(id: string): Promise<void> {
    const before = this.#find(id);
    if (!before || before.meshes !== null) return;
    const { uploads } = before;
    const items = await this.#dependencies.uploads.settled(uploads.filter((one) => !before.arrived[one]));
    const arrived = this.#find(id)?.arrived ?? {};
    const meshes: string[] = [];
    const refused: { name: string; why: string }[] = [];
    for (const upload of uploads) {
      const item = items.find((one) => one.id === upload);
      const asset = item?.assetId ?? arrived[upload]?.asset;
      if (asset) {
        const { kind } = await this.#dependencies.asset(asset);
        if (kind === "mesh") meshes.push(asset);
        else {
          const why = `It is no mesh, but: ${kindName(kind).toLowerCase()}.`;
          refused.push({ name: item?.name ?? arrived[upload]?.name ?? "", why });
        }
      } else if (item) {
        refused.push({ name: item.name, why: item.error?.message ?? "It was not uploaded." });
        await this.#dependencies.uploads.remove(upload); // told here, it need not wait among the uploads
      }
    }
    this.#change(id, { refused, meshes, total: meshes.length });
  }

  async #index(id: string): Promise<void> {
    const addition = this.#find(id);
    const { meshes, collection, labels } = addition ?? {};
    if (!meshes) return;
    const params = { collection, ...(labels && Object.keys(labels).length > 0 ? { labels } : {}) };
    const limit = await this.#dependencies.batchLimit();
    const batches: string[] = [];
    // What an earlier visit has made is made again under the same key, which gives the same batch.
    for (let from = 0; from < meshes.length; from += limit) {
      const items = meshes.slice(from, from + limit).map((mesh) => ({ inputs: { mesh }, params: {} }));
      const batch = await this.#dependencies.createBatch({ kind: "shape-index", params, items }, `${id}-${from}`);
      batches.push(batch.id);
      this.#change(id, { batches: [...batches] });
    }
    this.#change(id, { handedOver: true });
  }

  #noteArrivals(): void {
    const done = this.#dependencies.uploads.items.get().filter(({ assetId }) => assetId !== null);
    for (const { id, uploads, arrived } of this.additions.get()) {
      const fresh = done.filter((item) => uploads.includes(item.id) && !arrived[item.id]);
      if (fresh.length === 0) continue;
      const noted = fresh.map(({ id, name, assetId }: UploadItem) => [id, { name, asset: assetId ?? "" }] as const);
      this.#change(id, { arrived: { ...arrived, ...Object.fromEntries(noted) } });
    }
  }

  #find(id: string): Addition | undefined {
    return this.additions.get().find((one) => one.id === id);
  }

  #change(id: string, change: Partial<Addition>): void {
    const before = this.#find(id);
    if (!before) return; // somebody has closed it
    const after = { ...before, ...change };
    this.#dependencies.keep.save(after);
    this.additions.set(this.additions.get().map((one) => (one.id === id ? after : one)));
  }
}
