/** A fresh idempotency key. `crypto.randomUUID` is there over HTTPS only; this is there everywhere. */
export function newIdempotencyKey(): string {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Gives one key to one request: sent twice (an impatient click, a lost answer) it is done once; changed, it is another. */
export class Attempts {
  #last: { request: string; key: string } | null = null;

  keyFor(request: unknown): string {
    const text = JSON.stringify(request);
    if (this.#last?.request !== text) this.#last = { request: text, key: newIdempotencyKey() };
    return this.#last.key;
  }
}
