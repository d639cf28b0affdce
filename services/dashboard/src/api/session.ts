import { createStore } from "@/app/store";

/** How this browser tab signs in: a key lives as long as the tab, and never reaches the disk. */
export interface Session {
  /** The API key, or null where none was given. */
  key: string | null;
  /** Whether the server refused a request for want of a (valid) key. */
  refused: boolean;
}

const STORAGE = "shapery.key";

function storedKey(): string | null {
  try {
    return globalThis.sessionStorage?.getItem(STORAGE) ?? null;
  } catch {
    return null; // storage is forbidden: the key then lasts until the next reload
  }
}

export const session = createStore<Session>({
  key: storedKey(),
  refused: false,
});

export function signIn(key: string): void {
  try {
    globalThis.sessionStorage?.setItem(STORAGE, key);
  } catch {
    // as above
  }
  session.set({ key, refused: false });
}

export function signOut(): void {
  try {
    globalThis.sessionStorage?.removeItem(STORAGE);
  } catch {
    // as above
  }
  session.set({ key: null, refused: false });
}

/** The server answered 401. */
export function refuseKey(): void {
  if (!session.get().refused) {
    session.set({ ...session.get(), refused: true });
  }
}

export function authHeaders(): Record<string, string> {
  const { key } = session.get();
  return key ? { Authorization: `Bearer ${key}` } : {};
}
