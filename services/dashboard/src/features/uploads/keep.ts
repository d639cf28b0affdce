/** What is remembered of an unfinished upload over a reload of the page. */
export interface UploadRecord {
  id: string;
  name: string;
  size: number;
  /** Where the server keeps it, once it does. */
  url: string | null;
  createdAt: number;
}

/** Where unfinished uploads wait for the next visit. */
export interface Keep {
  records(): UploadRecord[];
  save(record: UploadRecord): void;
  drop(id: string): Promise<void>;
  /** Keep the content too, so that nobody has to choose the file again; false where there is no room for it. */
  saveContent(id: string, content: Blob): Promise<boolean>;
  content(id: string): Promise<Blob | null>;
}

const PREFIX = "shapery.upload.";
/** Larger files are not copied: the copy would take longer than choosing the file once more. */
const LARGEST_COPY = 4e9;

/** Records in local storage (one key each, so that two tabs never overwrite each other), contents in IndexedDB. */
export const browserKeep: Keep = {
  records() {
    const found: UploadRecord[] = [];
    for (const key of storedKeys()) {
      try {
        found.push(JSON.parse(localStorage.getItem(key) ?? "") as UploadRecord);
      } catch {
        localStorage.removeItem(key); // not ours to read, and never will be
      }
    }
    return found.sort((one, other) => one.createdAt - other.createdAt);
  },
  save(record) {
    try {
      localStorage.setItem(PREFIX + record.id, JSON.stringify(record));
    } catch {
      // Storage is full or forbidden: the upload works, it just does not outlive the page.
    }
  },
  async drop(id) {
    try {
      localStorage.removeItem(PREFIX + id);
      await request("readwrite", (store) => store.delete(id));
    } catch {
      // as above
    }
  },
  async saveContent(id, content) {
    if (content.size > LARGEST_COPY) return false;
    try {
      const { quota = 0, usage = 0 } = (await navigator.storage?.estimate()) ?? {};
      if (quota > 0 && content.size > (quota - usage) / 2) return false;
      await request("readwrite", (store) => store.put(content, id));
      return true;
    } catch {
      return false;
    }
  },
  async content(id) {
    try {
      const found = await request<unknown>("readonly", (store) => store.get(id));
      return found instanceof Blob ? found : null;
    } catch {
      return null;
    }
  },
};

function storedKeys(): string[] {
  try {
    return Object.keys(localStorage).filter((key) => key.startsWith(PREFIX));
  } catch {
    return [];
  }
}

let database: Promise<IDBDatabase> | null = null;

function open(): Promise<IDBDatabase> {
  database ??= new Promise((resolve, reject) => {
    const opening = indexedDB.open("shapery", 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore("files");
    opening.onsuccess = () => resolve(opening.result);
    opening.onerror = () => reject(opening.error);
  });
  return database;
}

async function request<T>(mode: IDBTransactionMode, ask: (store: IDBObjectStore) => IDBRequest<T>): Promise<T> {
  const transaction = (await open()).transaction("files", mode);
  return new Promise((resolve, reject) => {
    const asked = ask(transaction.objectStore("files"));
    transaction.oncomplete = () => resolve(asked.result);
    transaction.onerror = () => reject(transaction.error);
    transaction.onabort = () => reject(transaction.error);
  });
}
