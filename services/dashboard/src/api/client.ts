import createClient from "openapi-fetch";
import { reportAnswer, reportSilence } from "./connection";
import { problemFrom, Unreachable } from "./problem";
import type { paths } from "./schema";
import { authHeaders, refuseKey } from "./session";

/** `fetch` with the key, which tells silence from an answer, and throws for every answer that is an error. */
export async function apiFetch(input: string | Request, init: RequestInit = {}): Promise<Response> {
  const request = new Request(input, init);
  for (const [name, value] of Object.entries(authHeaders())) request.headers.set(name, value);
  let response: Response;
  try {
    response = await fetch(request);
  } catch (error) {
    if (request.signal.aborted) throw error;
    reportSilence();
    throw new Unreachable(error);
  }
  // A proxy answers for a server that does not.
  if (response.status === 502 || response.status === 504) {
    reportSilence();
    throw new Unreachable();
  }
  reportAnswer();
  if (response.ok) return response;
  if (response.status === 401) refuseKey();
  throw problemFrom(response.status, await response.text().catch(() => ""));
}

const client = createClient<paths>({
  baseUrl: globalThis.location?.origin ?? "",
  fetch: apiFetch,
});

/** The typed API. Every call either gives the body or throws (`ApiError`, `Unreachable`). */
export const api = client;

/** Unwrap an answer: errors were thrown already, so the body is there. */
export async function body<T>(call: Promise<{ data?: T }>): Promise<T> {
  return (await call).data as T;
}
