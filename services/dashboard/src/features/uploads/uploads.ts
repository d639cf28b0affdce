import { browserKeep } from "./keep";
import { patiently, UploadManager } from "./manager";

/** Runs `work` under a lock that all tabs of this origin share, where the browser has one. */
async function exclusively(id: string, work: () => Promise<void>): Promise<boolean> {
  if (!navigator.locks) {
    // Over plain HTTP there are no locks; the server refuses the second writer, and both arrive at the same asset.
    await work();
    return true;
  }
  return navigator.locks.request(`shapery-${id}`, { ifAvailable: true }, async (lock) => {
    if (!lock) return false;
    await work();
    return true;
  });
}

export const takeUp = patiently(exclusively);

/** The uploads of this page. The tus client is fetched with the first of them. */
export const uploads = new UploadManager({
  keep: browserKeep,
  transfer: async (transfer) => (await import("./transfer")).transfer(transfer),
  terminate: async (url) => (await import("./transfer")).terminate(url),
  exclusively,
  takeUp,
  now: Date.now,
});
