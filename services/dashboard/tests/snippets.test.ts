import { execFileSync } from "node:child_process";
import { describe, expect, it } from "vitest";
import {
  batchSnippets,
  jobSnippets,
  keySnippets,
  literal,
  resultSnippets,
  shellWord,
} from "@/features/snippets/snippets";

const local = { server: "http://127.0.0.1:8000", keyed: false };
const keyed = { server: "https://shapes.example", keyed: true };

/** The words that a shell makes of a command, with the command's name left out. */
function words(command: string): string[] {
  const script = `show() { printf '%s\\0' "$@"; }; curl() { show "$@"; }; shapery() { show "$@"; }; ${command}`;
  return execFileSync("bash", ["-c", script], { encoding: "utf8" }).split("\0").slice(0, -1);
}

describe("snippets", () => {
  const request = {
    kind: "segmentation",
    inputs: { post: "0189-a", pre: "0189-b" },
    params: { seeds: [[1.5, -2, 3]], note: "it's $HOME" },
  };

  it("come out of a shell as they went in", () => {
    const { curl, command } = jobSnippets(request, local);
    expect(JSON.parse(words(curl).at(-1) ?? "")).toEqual(request);
    expect(words(curl)).toContain("http://127.0.0.1:8000/v1/jobs");
    const said = words(command);
    expect(said.slice(0, 7)).toEqual([
      "jobs",
      "submit",
      "segmentation",
      "--input",
      "post=0189-a",
      "--input",
      "pre=0189-b",
    ]);
    expect(JSON.parse(said[8] ?? "")).toEqual(request.params);
    expect(said.slice(-2)).toEqual(["--server", "http://127.0.0.1:8000"]);
  });

  it("take the key from the environment, and hold none", () => {
    const { curl, python } = jobSnippets(request, keyed);
    expect(curl).toContain('-H "Authorization: Bearer $SHAPERY_API_KEY"');
    expect(python).toContain('Client("https://shapes.example", api_key=os.environ["SHAPERY_API_KEY"])');
    expect(jobSnippets(request, local).python).not.toContain("import os");
  });

  it("leave out what is empty", () => {
    const { curl, command, python } = jobSnippets({ ...request, params: {} }, local);
    expect(JSON.parse(words(curl).at(-1) ?? "")).not.toHaveProperty("params");
    expect(command).not.toContain("--params");
    expect(python).toContain('{"post": "0189-a", "pre": "0189-b"})');
  });

  it("give every file of a job, with folders in their names undone", () => {
    const job = { id: "7", artifacts: [{ name: "surfaces/1.ply", url: "/v1/jobs/7/artifacts/surfaces/1.ply" }] };
    expect(words(resultSnippets(job, local).curl)).toEqual([
      "-o",
      "surfaces-1.ply",
      "http://127.0.0.1:8000/v1/jobs/7/artifacts/surfaces/1.ply",
    ]);
  });

  it("write a batch's items one a line", () => {
    const batch = { kind: "segmentation", params: {}, items: [{ inputs: { post: "a" }, params: {} }] };
    expect(batchSnippets(batch, local).curl.split("\n").slice(1, 3)).toEqual([
      '{"kind":"segmentation"}',
      '{"inputs":{"post":"a"}}',
    ]);
    expect(batchSnippets(batch, local).python).toContain('    BatchItem(inputs={"post": "a"}),');
  });

  it("make keys that end, and such that don't", () => {
    expect(words(keySnippets("my key", ["read"], 30, local).command)).toEqual(
      ["keys", "create", "my key", "--scope", "read", "--days", "30", "--server", local.server], // one word
    );
    expect(keySnippets("k", ["read"], null, local).python).not.toContain("timedelta");
  });
});

describe("shellWord", () =>
  it.each(["plain", "a b", "it's", "$(rm)", "", 'say "x"', "ä\nb", "a;b"])("keeps %j one word", (text) =>
    expect(words(`show ${shellWord(text)}`)).toEqual([text]),
  ));

describe("literal", () =>
  it("writes Python", () =>
    expect(literal({ a: [true, false, null, 1.5, "x\n"], "b c": {} })).toBe(
      '{"a": [True, False, None, 1.5, "x\\n"], "b c": {}}',
    )));
