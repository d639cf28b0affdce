import { DetailedError, Upload } from "tus-js-client";
import { apiFetch } from "@/api/client";
import { reportAnswer, reportSilence } from "@/api/connection";
import { ApiError, problemFrom, Unreachable } from "@/api/problem";
import { authHeaders, refuseKey } from "@/api/session";

export interface Transfer {
  content: Blob;
  name: string;
  /** Where an earlier attempt has left off. */
  url: string | null;
  onUrl: (url: string) => void;
  onProgress: (sent: number) => void;
  signal: AbortSignal;
}

/** Send a file over tus, or the rest of it; gives the asset's id. One attempt: whoever calls decides about the next. */
export async function transfer(transfer: Transfer): Promise<string> {
  if (transfer.url) await ensureFree(transfer.url, transfer.signal);
  return send(transfer);
}

/**
 * Throw while the server still takes in what an earlier connection had sent.
 *
 * Bytes on their way outlive the page that sent them. Until they have arrived the offset is not the last word, and the
 * server refuses other writers, which a browser would learn only after it had sent everything: so ask with nothing.
 */
async function ensureFree(url: string, signal: AbortSignal): Promise<void> {
  const headers = { "Tus-Resumable": "1.0.0" };
  const standing = await apiFetch(url, { method: "HEAD", headers, signal });
  const offset = standing.headers.get("Upload-Offset") ?? "0";
  if (offset === standing.headers.get("Upload-Length")) return;
  await apiFetch(url, {
    method: "PATCH",
    headers: {
      ...headers,
      "Upload-Offset": offset,
      "Content-Type": "application/offset+octet-stream",
    },
    signal,
  });
}

function send({ content, name, url, onUrl, onProgress, signal }: Transfer): Promise<string> {
  return new Promise((resolve, reject) => {
    let assetId = "";
    const upload = new Upload(content, {
      // Without an endpoint the client never starts over by itself when it is to resume: a passing refusal of the
      // request for the offset must not throw away what has arrived.
      endpoint: url ? null : "/v1/uploads",
      uploadUrl: url,
      metadata: { filename: name },
      headers: authHeaders(),
      retryDelays: null,
      // What a refusal in the middle can cost at the most: a browser reads the answer after it has sent everything.
      chunkSize: 32 << 20,
      storeFingerprintForResuming: false,
      onUploadUrlAvailable: () => {
        if (upload.url) onUrl(upload.url);
      },
      onProgress: (sent) => onProgress(sent),
      onAfterResponse: (_request, response) => {
        reportAnswer();
        assetId = response.getHeader("Upload-Asset-Id") ?? assetId;
      },
      onSuccess: () => {
        if (assetId) resolve(assetId);
        else reject(new ApiError(200, "no_asset", "The upload arrived, but the server named no asset for it.", ""));
      },
      onError: (error) => reject(translate(error)),
    });
    signal.addEventListener(
      "abort",
      () => {
        void upload.abort();
        reject(signal.reason);
      },
      { once: true },
    );
    signal.throwIfAborted();
    upload.start();
  });
}

/** Tell the server that the rest will not come. */
export async function terminate(url: string): Promise<void> {
  await Upload.terminate(url, { headers: authHeaders(), retryDelays: null });
}

function translate(error: Error): Error {
  if (!(error instanceof DetailedError)) return error;
  const response = error.originalResponse;
  const status = response?.getStatus() ?? 0;
  if (!response || status === 0 || status === 502 || status === 504) {
    reportSilence();
    return new Unreachable(error);
  }
  if (status === 401) refuseKey();
  return problemFrom(status, response.getBody());
}
