import { apiFetch } from "@/api/client";

/** Fetch a file, and tell how much of it is here; `size` is what is expected, as far as known. */
export async function download(
  url: string,
  size: number,
  onProgress: (fraction: number) => void,
  signal: AbortSignal,
): Promise<ArrayBuffer> {
  const response = await apiFetch(url, { signal });
  if (!response.body || size <= 0) return response.arrayBuffer();
  const reader = response.body.getReader();
  let buffer = new Uint8Array(size);
  let received = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    if (received + value.length > buffer.length) {
      const larger = new Uint8Array(Math.max(buffer.length * 2, received + value.length));
      larger.set(buffer);
      buffer = larger;
    }
    buffer.set(value, received);
    received += value.length;
    onProgress(Math.min(received / size, 1));
  }
  return received === buffer.length ? buffer.buffer : buffer.buffer.slice(0, received);
}
