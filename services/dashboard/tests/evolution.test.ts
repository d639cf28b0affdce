import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { type Frame, readEvolution, sceneAt } from "@/viewers/surface/evolution";

/** Written by tests/unit/segmentation/test_evolution.py, which checks that it still is what Python writes. */
const golden = new Uint8Array(readFileSync(new URL("golden/evolution.bin", import.meta.url)));

function copy(change: (bytes: Uint8Array) => Uint8Array = (bytes) => bytes): ArrayBuffer {
  const bytes = change(golden.slice());
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
}

function withHeader(change: (text: string) => string): ArrayBuffer {
  const length = new DataView(golden.buffer, golden.byteOffset).getUint32(8, true);
  const text = change(new TextDecoder().decode(golden.subarray(12, 12 + length)).trimEnd());
  const header = new TextEncoder().encode(text + " ".repeat((4 - (text.length % 4)) % 4));
  const bytes = new Uint8Array(12 + header.length + golden.length - 12 - length);
  bytes.set(golden.subarray(0, 8));
  new DataView(bytes.buffer).setUint32(8, header.length, true);
  bytes.set(header, 12);
  bytes.set(golden.subarray(12 + length), 12 + header.length);
  return bytes.buffer;
}

describe("an evolution", () => {
  it("is read as Python wrote it", () => {
    const frames = readEvolution(copy());
    expect(frames.map(({ object, stage, iteration }) => [object, stage, iteration])).toEqual([
      [1, 0, 1],
      [1, 1, 5],
      [2, 0, 1],
    ]);
    // Tetrahedra with corners at the origin and on the axes, 1, 2 and 4 mm long, the last one 10 mm to the right.
    expect(frames.map(({ faces }) => [...faces])).toEqual(Array(3).fill([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]));
    const expected = [
      [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1],
      [0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2],
      [10, 0, 0, 14, 0, 0, 10, 4, 0, 10, 0, 4],
    ];
    frames.forEach(({ positions }, index) =>
      positions.forEach((value, at) => expect(value).toBeCloseTo(expected[index]?.[at] ?? NaN, 3)),
    );
  });

  it.each([
    ["another format", copy((bytes) => bytes.fill(65, 0, 3)), "is no evolution"],
    ["too short", copy((bytes) => bytes.subarray(0, 9)), "is no evolution"],
    ["a cut body", copy((bytes) => bytes.subarray(0, bytes.length - 4)), "a frame is cut off"],
    ["a cut header", copy((bytes) => bytes.subarray(0, 40)), "its header is cut off"],
    ["a header that is no JSON", withHeader((text) => text.slice(0, -2)), "its header is no JSON"],
    ["a header of another kind", withHeader(() => "[1, 2, 3]"), "lacks what it should tell"],
    ["a negative offset", withHeader((text) => text.replace(/"offset": \d+/, '"offset": -4')), "lacks what"],
    ["an offset beyond its end", withHeader((text) => text.replace(/"offset": \d+/, '"offset": 4000')), "is cut off"],
    ["too few vertices", withHeader((text) => text.replace('"vertices": 4', '"vertices": 2')), "no such vertex"],
  ])("is refused where it is damaged: %s", (_, content, sentence) => {
    expect(() => readEvolution(content)).toThrow(sentence);
  });

  it("shows the objects that rest beside the one that flows", () => {
    const frames = readEvolution(copy());
    const told = (scene: Frame[]) => scene.map(({ object, iteration }) => [object, iteration]);
    expect(told(sceneAt(frames, 0))).toEqual([[1, 1]]);
    expect(told(sceneAt(frames, 1))).toEqual([[1, 5]]);
    expect(told(sceneAt(frames, 2))).toEqual([
      [1, 5],
      [2, 1],
    ]);
    expect(sceneAt(frames, 3)).toEqual([]);
  });
});
