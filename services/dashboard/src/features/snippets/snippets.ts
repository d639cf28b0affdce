import type { BatchCreate, JobCreate, SearchRequest } from "@/api/types";

/** The same request in three languages. */
export interface Snippets {
  curl: string;
  command: string;
  python: string;
}

export interface Target {
  /** The server's address, without a slash at its end. */
  server: string;
  /** Whether requests need a key; snippets take it from the environment, never from this page. */
  keyed: boolean;
}

/** Start a job on assets that are on the server. */
export function jobSnippets({ kind, inputs, params }: JobCreate, target: Target): Snippets {
  const flags = Object.entries(inputs).flatMap(([name, ids]) =>
    [ids].flat().map((id) => `--input ${shellWord(`${name}=${id}`)}`),
  );
  const given = params && Object.keys(params).length > 0 ? params : null;
  const request = { kind, inputs, ...(given ? { params: given } : {}) };
  return {
    curl: curl("/v1/jobs", target, request),
    command: command([`jobs submit ${shellWord(kind)}`, ...flags, ...parameters(given)], target),
    python: python(
      [
        `job = shapery.submit(${literal(kind)}, ${literal(inputs)}${given ? `, ${literal(given)}` : ""})`,
        "job = shapery.wait(job.id)",
        'shapery.download(job, "results")',
      ],
      target,
    ),
  };
}

/** Fetch what a job made. */
export function resultSnippets(
  job: { id: string; artifacts: readonly { name: string; url: string }[] },
  target: Target,
) {
  const files = job.artifacts.map(
    ({ name, url }) =>
      `curl${header(target)} -o ${shellWord(name.replaceAll("/", "-"))} ${shellWord(target.server + url)}`,
  );
  return {
    curl: files.join("\n"),
    command: command([`jobs download ${job.id}`, "--out results"], target),
    python: python([`job = shapery.job(${literal(job.id)})`, 'shapery.download(job, "results")'], target),
  };
}

/** Start many jobs; the items stand in a file, as there may be thousands. */
export function batchSnippets({ kind, params, items }: BatchCreate, target: Target): Snippets {
  const given = params && Object.keys(params).length > 0 ? params : null;
  const lines = items.map(({ inputs, params: own }) =>
    JSON.stringify(Object.keys(own).length > 0 ? { inputs, params: own } : { inputs }),
  );
  const file = ["cat > items.ndjson <<'END'", ...lines, "END"].join("\n");
  const head = JSON.stringify({ kind, ...(given ? { params: given } : {}) });
  return {
    curl: [
      ["cat > batch.ndjson <<'END'", head, ...lines, "END"].join("\n"),
      `curl${header(target)} -H 'Content-Type: application/x-ndjson' ${target.server}/v1/batches \\\n     --data-binary @batch.ndjson`,
    ].join("\n"),
    command: [
      file,
      command(["batch submit items.ndjson", `--kind ${shellWord(kind)}`, ...parameters(given)], target),
    ].join("\n"),
    python: python(
      [
        "items = [",
        ...items.map(({ inputs, params: own }) => {
          const rest = Object.keys(own).length > 0 ? `, params=${literal(own)}` : "";
          return `    BatchItem(inputs=${literal(inputs)}${rest}),`;
        }),
        "]",
        `batch = shapery.submit_batch(${literal(kind)}, items${given ? `, ${literal(given)}` : ""})`,
        "for result in shapery.batch_results(shapery.wait_batch(batch.id).id):",
        "    print(result.job.id, result.job.state)",
      ],
      target,
      { own: ["from shapery_contracts.api import BatchItem"] },
    ),
  };
}

/** Search by a stored shape, or by a mesh: an asset over HTTP, its file on the command line. */
export function searchSnippets(request: SearchRequest, target: Target, filename = "mesh.ply"): Snippets {
  const { shape_id, asset_id, parts, mode, collection, labels, limit, rerank } = request;
  const own = Object.entries(labels);
  const partial = mode === "partial" && !parts;
  return {
    curl: curl("/v1/search", target, {
      ...(shape_id ? { shape_id } : { asset_id }),
      ...(parts ? { parts } : {}),
      ...(partial ? { mode } : {}),
      ...(collection ? { collection } : {}),
      ...(own.length > 0 ? { labels } : {}),
      limit,
      ...(rerank ? { rerank } : {}),
    }),
    command: command(
      [
        `search ${shellWord(shape_id ?? filename)}`,
        ...(parts ?? []).map((part) => `--part ${part}`),
        ...(partial ? ["--partial"] : []),
        ...(collection ? [`--collection ${shellWord(collection)}`] : []),
        ...own.map(([name, value]) => `--label ${shellWord(`${name}:${value}`)}`),
        `--limit ${limit}`,
        ...(rerank ? ["--rerank"] : []),
      ],
      target,
    ),
    python: python(
      [
        `answer = shapery.search(${[
          shape_id ? `shape=${literal(shape_id)}` : `asset=${literal(asset_id)}`,
          ...(parts ? [`parts=${literal(parts)}`] : []),
          ...(partial ? ['mode="partial"'] : []),
          ...(collection ? [`collection=${literal(collection)}`] : []),
          ...(own.length > 0 ? [`labels=${literal(labels)}`] : []),
          `limit=${limit}`,
          ...(rerank ? ["rerank=True"] : []),
        ].join(", ")})`,
        "for hit in answer.hits:",
        "    print(round(hit.score, 3), hit.shape.name)",
      ],
      target,
    ),
  };
}

/** Make a key. */
export function keySnippets(name: string, scopes: readonly string[], days: number | null, target: Target): Snippets {
  const expires = days ? { expires_at: new Date(Date.now() + days * 86_400_000).toISOString() } : {};
  return {
    curl: curl("/v1/keys", target, { name, scopes, ...expires }),
    command: command(
      [
        `keys create ${shellWord(name)}`,
        ...scopes.map((scope) => `--scope ${scope}`),
        ...(days ? [`--days ${days}`] : []),
      ],
      target,
    ),
    python: python(
      [
        `scopes = [${scopes.map((scope) => `Scope.${scope.toUpperCase()}`).join(", ")}]`,
        ...(days ? [`expires = datetime.now(UTC) + timedelta(days=${days})`] : []),
        `print(shapery.create_key(${literal(name)}, scopes${days ? ", expires" : ""}).secret)`,
      ],
      target,
      {
        standard: days ? ["from datetime import UTC, datetime, timedelta"] : [],
        own: ["from shapery_contracts.api import Scope"],
      },
    ),
  };
}

function header({ keyed }: Target): string {
  return keyed ? ' -H "Authorization: Bearer $SHAPERY_API_KEY"' : "";
}

function curl(path: string, target: Target, request: unknown): string {
  return (
    `curl${header(target)} -H 'Content-Type: application/json' ${target.server}${path} \\\n` +
    `     -d ${shellQuoted(JSON.stringify(request))}`
  );
}

function command(parts: readonly string[], { server }: Target): string {
  return [`shapery ${parts[0] ?? ""}`, ...parts.slice(1), `--server ${server}`].join(" \\\n    ");
}

function parameters(given: unknown): string[] {
  return given ? [`--params ${shellQuoted(JSON.stringify(given))}`] : [];
}

/** A program around `lines`; `standard` imports come from Python itself, `own` from our packages. */
function python(
  lines: readonly string[],
  { server, keyed }: Target,
  { standard = [], own = [] }: { standard?: string[]; own?: string[] } = {},
): string {
  const before = [...(keyed ? ["import os"] : []), ...standard];
  const key = keyed ? ', api_key=os.environ["SHAPERY_API_KEY"]' : "";
  return [
    ...before,
    ...(before.length > 0 ? [""] : []),
    "from shapery_client import Client",
    ...own,
    "",
    `with Client(${literal(server)}${key}) as shapery:`,
    ...lines.map((line) => `    ${line}`),
  ].join("\n");
}

/** One word of a shell's line, quoted where it has to be. */
export function shellWord(text: string): string {
  return /^[\w@%+=:,./-]+$/.test(text) ? text : shellQuoted(text);
}

function shellQuoted(text: string): string {
  return `'${text.replaceAll("'", `'\\''`)}'`;
}

/** A value as Python writes it; strings as JSON does, which Python reads alike. */
export function literal(value: unknown): string {
  if (value === null || value === undefined) return "None";
  if (typeof value === "boolean") return value ? "True" : "False";
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value === "object") {
    return `{${Object.entries(value)
      .map(([name, entry]) => `${JSON.stringify(name)}: ${literal(entry)}`)
      .join(", ")}}`;
  }
  return JSON.stringify(value);
}
