import { untilReachable } from "@/api/connection";
import { ApiError, describe, Unreachable } from "@/api/problem";
import { createStore, type Store } from "@/app/store";
import type { Parcel } from "./gather";
import type { Keep, UploadRecord } from "./keep";
import type { Transfer } from "./transfer";
import { zip } from "./zip";

export type UploadState =
  /** Its files are put into one archive. */
  | "preparing"
  /** Others go first. */
  | "queued"
  | "sending"
  /** The connection was lost, or the server asked for patience; it goes on by itself. */
  | "waiting"
  | "paused"
  /** The page was left and the file's content with it: it must be chosen again. */
  | "needs-file"
  | "done"
  | "failed";

export interface UploadItem {
  id: string;
  name: string;
  size: number;
  state: UploadState;
  sent: number;
  /** Bytes per second, smoothed; 0 while unknown. */
  rate: number;
  /** Files inside of it, where it is an archive made here. */
  files: number;
  assetId: string | null;
  error: { message: string; code: string; hint: string } | null;
}

/** Runs `work` while no other tab does the same; false where another tab has it. */
export type Exclusively = (id: string, work: () => Promise<void>) => Promise<boolean>;

/** The same with patience: a page that was left may hold its lock for a moment longer, another tab holds it for good. */
export function patiently(exclusively: Exclusively): Exclusively {
  return async (id, work) => {
    for (let attempt = 0; attempt < 4; attempt += 1) {
      if (attempt > 0) await new Promise((resolve) => setTimeout(resolve, 500));
      if (await exclusively(id, work)) return true;
    }
    return false;
  };
}

interface Dependencies {
  keep: Keep;
  transfer: (transfer: Transfer) => Promise<string>;
  terminate: (url: string) => Promise<void>;
  exclusively: Exclusively;
  /** For what an earlier page has left. */
  takeUp: Exclusively;
  now: () => number;
}

interface Running {
  content: Blob | null;
  url: string | null;
  controller: AbortController;
  createdAt: number;
}

const AT_ONCE = 3;
const LONGEST_WAIT = 15_000;
const REPORT_EVERY = 150;

/** All uploads of this page: they go on while one looks at other pages, and after a reload. */
export class UploadManager {
  readonly items: Store<readonly UploadItem[]> = createStore<readonly UploadItem[]>([]);
  onDone: (assetId: string) => void = () => undefined;
  readonly #inner = new Map<string, Running>();
  readonly #dependencies: Dependencies;
  #counter = 0;
  #restored: () => void = () => undefined;
  /** When all that an earlier visit has left is here. */
  readonly restored = new Promise<void>((resolve) => (this.#restored = resolve));

  constructor(dependencies: Dependencies) {
    this.#dependencies = dependencies;
  }

  /** Upload what was gathered, and tell as what; a file that an interrupted upload waits for continues that upload. */
  async add(parcels: readonly Parcel[]): Promise<string[]> {
    const ids = await Promise.all(parcels.map((parcel) => this.#accept(parcel)));
    return ids.filter((id) => id !== null);
  }

  /** Wait until each of some uploads is done, has failed or was removed before it was done, which leaves it out. */
  async settled(ids: readonly string[]): Promise<UploadItem[]> {
    const over = new Map<string, UploadItem>();
    await this.#when(() => {
      const there = new Map(this.items.get().map((item) => [item.id, item]));
      for (const id of ids) {
        const item = there.get(id);
        if (item?.state === "done" || item?.state === "failed") over.set(id, item);
        else if (item) over.delete(id); // it is tried again
      }
      return ids.every((id) => over.has(id) || !there.has(id));
    });
    return ids.flatMap((id) => over.get(id) ?? []);
  }

  /** Take up what an earlier visit has left unfinished; until all of it is here, or another tab has it. */
  async restore(): Promise<void> {
    await Promise.all(this.#dependencies.keep.records().map((record) => this.#takeUp(record)));
    this.#restored();
  }

  async #takeUp(record: UploadRecord): Promise<void> {
    if (this.#inner.has(record.id)) return;
    const content = await this.#dependencies.keep.content(record.id);
    await new Promise<void>((here) => {
      void this.#dependencies
        .takeUp(record.id, async () => {
          // Another tab may have brought it to its end in the meantime.
          const open = this.#dependencies.keep.records().some(({ id }) => id === record.id);
          if (open) this.#insert(record, content ? "queued" : "needs-file", 0);
          here();
          if (open) await this.#run(record.id);
        })
        .then(() => here());
    });
  }

  /** What is sent, as long as it lies in the browser: a reference to a file, not the bytes themselves. */
  content(id: string): Blob | null {
    return this.#inner.get(id)?.content ?? null;
  }

  pause(id: string): void {
    const inner = this.#inner.get(id);
    if (!inner) return;
    this.#change(id, { state: "paused", rate: 0 });
    inner.controller.abort();
  }

  resume(id: string): void {
    const item = this.#item(id);
    if (item && (item.state === "paused" || item.state === "failed")) {
      this.#change(id, { state: "queued", error: null });
    }
    this.#wake(id);
  }

  /** Give an interrupted upload its file again. */
  async continueWith(id: string, file: Blob): Promise<boolean> {
    const item = this.#item(id);
    const inner = this.#inner.get(id);
    if (!item || !inner || file.size !== item.size) return false;
    inner.content = file;
    await this.#dependencies.keep.saveContent(id, file);
    this.#change(id, { state: "queued", error: null });
    this.#wake(id);
    return true;
  }

  /** Forget an upload; what the server has of it is removed. */
  async remove(id: string): Promise<void> {
    const inner = this.#inner.get(id);
    const finished = this.#item(id)?.state === "done";
    this.items.set(this.items.get().filter((item) => item.id !== id));
    this.#inner.delete(id);
    inner?.controller.abort();
    await this.#dependencies.keep.drop(id);
    if (inner?.url && !finished) {
      await this.#dependencies.terminate(inner.url).catch(() => undefined); // it expires by itself
    }
  }

  clearDone(): void {
    for (const item of this.items.get()) if (item.state === "done") this.#inner.delete(item.id);
    this.items.set(this.items.get().filter((item) => item.state !== "done"));
  }

  async #accept(parcel: Parcel): Promise<string | null> {
    this.#counter += 1;
    const id = `${this.#dependencies.now().toString(36)}-${this.#counter}-${Math.random().toString(36).slice(2, 8)}`;
    const record: UploadRecord = {
      id,
      name: parcel.name,
      size: 0,
      url: null,
      createdAt: this.#dependencies.now(),
    };
    let content: Blob;
    if (parcel.type === "file") {
      content = parcel.file;
    } else {
      record.size = parcel.files.reduce((sum, file) => sum + file.content.size, 0);
      this.#insert(record, "preparing", parcel.files.length);
      const { signal } = (this.#inner.get(id) as Running).controller;
      try {
        content = await zip(parcel.files, (fraction) => this.#change(id, { sent: fraction * record.size }), signal);
      } catch (error) {
        if (!signal.aborted) this.#change(id, { state: "failed", error: describe(error) });
        return signal.aborted ? null : id;
      }
    }
    const waiting = this.items
      .get()
      .find((item) => item.state === "needs-file" && item.name === parcel.name && item.size === content.size);
    if (waiting) {
      this.items.set(this.items.get().filter((item) => item.id !== id));
      this.#inner.delete(id);
      await this.continueWith(waiting.id, content);
      return waiting.id;
    }
    record.size = content.size;
    if (parcel.type === "file") this.#insert(record, "queued", 0);
    else this.#change(id, { state: "queued", size: content.size, sent: 0 });
    const inner = this.#inner.get(id);
    if (!inner) return null;
    inner.content = content;
    this.#dependencies.keep.save(record);
    void this.#dependencies.keep.saveContent(id, content);
    void this.#dependencies.exclusively(id, () => this.#run(id));
    return id;
  }

  #insert(record: UploadRecord, state: UploadState, files: number): void {
    this.#inner.set(record.id, {
      content: null,
      url: record.url,
      controller: new AbortController(),
      createdAt: record.createdAt,
    });
    const item: UploadItem = {
      id: record.id,
      name: record.name,
      size: record.size,
      state,
      sent: 0,
      rate: 0,
      files,
      assetId: null,
      error: null,
    };
    this.items.set([...this.items.get(), item]);
  }

  /** Carry one upload to its end, through every interruption. */
  async #run(id: string): Promise<void> {
    let failures = 0;
    for (;;) {
      await this.#turn(id);
      const item = this.#item(id);
      const inner = this.#inner.get(id);
      if (!item || !inner) return;
      inner.content ??= await this.#dependencies.keep.content(id);
      if (!inner.content) {
        this.#change(id, { state: "needs-file" });
        continue;
      }
      inner.controller = new AbortController();
      try {
        const before = item.sent;
        const assetId = await this.#send(id, inner, inner.content, (sent) => {
          if (sent > before) failures = 0;
        });
        this.#change(id, { state: "done", sent: item.size, rate: 0, assetId });
        await this.#dependencies.keep.drop(id);
        this.onDone(assetId);
        return;
      } catch (error) {
        if (inner.controller.signal.aborted) continue; // paused or removed: the next turn tells
        failures += 1;
        const verdict = judge(error, failures);
        if (verdict === "start-over") {
          inner.url = null;
          this.#save(id);
          this.#change(id, { state: "queued", sent: 0 });
        } else if (verdict === "give-up") {
          failures = 0;
          this.#change(id, {
            state: "failed",
            rate: 0,
            error: describe(error),
          });
        } else {
          this.#change(id, {
            state: "waiting",
            rate: 0,
            error: describe(error),
          });
          const { signal } = inner.controller;
          await untilReachable(Math.min(500 * 2 ** failures, LONGEST_WAIT), signal);
          if (!signal.aborted) this.#change(id, { state: "queued" });
        }
      }
    }
  }

  async #send(id: string, inner: Running, content: Blob, onProgress: (sent: number) => void): Promise<string> {
    const { now } = this.#dependencies;
    let reported = 0;
    let last: { at: number; sent: number } | null = null;
    return await this.#dependencies.transfer({
      content,
      name: this.#item(id)?.name ?? "",
      url: inner.url,
      signal: inner.controller.signal,
      onUrl: (url) => {
        inner.url = url;
        this.#save(id);
      },
      onProgress: (sent) => {
        onProgress(sent);
        const at = now();
        if (at - reported < REPORT_EVERY && sent < content.size) return;
        reported = at;
        const rate = last && at > last.at ? ((sent - last.sent) / (at - last.at)) * 1000 : 0;
        const before = this.#item(id)?.rate ?? 0;
        last = { at, sent };
        this.#change(id, {
          sent,
          rate: before > 0 ? 0.7 * before + 0.3 * rate : Math.max(rate, 0),
        });
      },
    });
  }

  /** Wait until this upload wants to run and there is room for it, and take its place; at once where it was removed. */
  #turn(id: string): Promise<void> {
    return this.#when(() => {
      const state = this.#item(id)?.state;
      if (state === undefined) return true;
      if (state !== "queued") return false;
      if (this.items.get().filter((item) => item.state === "sending").length >= AT_ONCE) return false;
      this.#change(id, { state: "sending", error: null, rate: 0 });
      return true;
    });
  }

  #when(condition: () => boolean): Promise<void> {
    return new Promise((resolve) => {
      if (condition()) {
        resolve();
        return;
      }
      const unsubscribe = this.items.subscribe(() => {
        if (!condition()) return;
        unsubscribe();
        resolve();
      });
    });
  }

  /** Whoever waits in `#turn` looks again. */
  #wake(id: string): void {
    this.#change(id, {});
  }

  #save(id: string): void {
    const item = this.#item(id);
    const inner = this.#inner.get(id);
    if (!item || !inner) return;
    const { name, size } = item;
    this.#dependencies.keep.save({
      id,
      name,
      size,
      url: inner.url,
      createdAt: inner.createdAt,
    });
  }

  #item(id: string): UploadItem | undefined {
    return this.items.get().find((item) => item.id === id);
  }

  #change(id: string, change: Partial<UploadItem>): void {
    this.items.set(this.items.get().map((item) => (item.id === id ? { ...item, ...change } : item)));
  }
}

/** What to do after an attempt has failed. */
export function judge(error: unknown, failures: number): "again" | "start-over" | "give-up" {
  if (error instanceof Unreachable) return "again"; // for as long as it takes
  if (!(error instanceof ApiError)) return "give-up";
  // The server no longer has what was sent.
  if ((error.status === 404 || error.status === 410) && failures < 3) return "start-over";
  // Another request still holds it, the offset moved on, a checksum failed on the way, or patience is asked for.
  const passing = [409, 423, 429, 460, 500, 503].includes(error.status);
  return passing && failures < 8 ? "again" : "give-up";
}
