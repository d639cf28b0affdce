import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, it } from "vitest";
import { checksum, zip } from "@/features/uploads/zip";

const blob = (text: string) => new Blob([text]);

it("has the checksum that everybody knows", async () => {
  expect(await checksum(blob("123456789"))).toBe(0xcbf43926);
  expect(await checksum(blob(""))).toBe(0);
});

it("sums up what comes in pieces like a whole", async () => {
  const large = new Uint8Array(300_000).map((_, index) => (index * 7) & 0xff);
  const pieces = new Blob([large.slice(0, 70_001), large.slice(70_001)]);
  expect(await checksum(pieces)).toBe(await checksum(new Blob([large])));
});

it("is read by another program, names and all", async () => {
  const archive = await zip([
    { path: "b/größe.dcm", content: blob("two") },
    { path: "a.dcm", content: blob("one") },
    { path: "empty", content: blob("") },
  ]);
  const folder = mkdtempSync(join(tmpdir(), "zip-"));
  try {
    writeFileSync(join(folder, "it.zip"), new Uint8Array(await archive.arrayBuffer()));
    const script =
      "import json, sys, zipfile\n" +
      "z = zipfile.ZipFile(sys.argv[1]); assert z.testzip() is None\n" +
      "print(json.dumps({n: z.read(n).decode() for n in z.namelist()}))";
    const read = execFileSync("python3", ["-c", script, join(folder, "it.zip")], { encoding: "utf-8" });
    expect(JSON.parse(read)).toEqual({
      "a.dcm": "one",
      "b/größe.dcm": "two",
      empty: "",
    });
  } finally {
    rmSync(folder, { recursive: true });
  }
});

it("makes the same bytes of the same files in any order, or an upload could not go on", async () => {
  const files = ["c", "a", "b"].map((path) => ({
    path,
    content: blob(path.repeat(9)),
  }));
  const one = await (await zip(files)).text();
  const other = await (await zip(files.toReversed())).text();
  expect(one).toBe(other);
});

it("refuses what the format cannot hold", async () => {
  const many = new Array(65_536).fill({ path: "a", content: blob("") });
  await expect(zip(many)).rejects.toThrow(/65 535 files/);
});

it("stops when it is told to", async () => {
  await expect(zip([{ path: "a", content: blob("a") }], undefined, AbortSignal.abort())).rejects.toThrow(/abort/);
});
