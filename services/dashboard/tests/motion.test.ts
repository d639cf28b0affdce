import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { CorruptMotion, crc32 } from "@/features/motion/smc/container";
import { Motion } from "@/features/motion/smc/motion";

/** Motions that the reference encoder wrote, and their vertices as the reference decoder gives them. */
function golden(name: string): { bytes: Uint8Array; vertices: Float64Array } {
  const read = (ending: string) => new Uint8Array(readFileSync(new URL(`golden/${name}.${ending}`, import.meta.url)));
  return { bytes: read("smc"), vertices: new Float64Array(read("f64").buffer) };
}

function diagonal(frame: Float64Array): number {
  const spans = [0, 1, 2].map((axis) => {
    const along = frame.filter((_, at) => at % 3 === axis);
    return Math.max(...along) - Math.min(...along);
  });
  return Math.hypot(...spans);
}

function largestError(motion: Motion, vertices: Float64Array, order: Iterable<number>): number {
  const n = 3 * motion.header.vertices;
  let largest = 0;
  for (const index of order) {
    const frame = motion.frame(index);
    for (let at = 0; at < n; at += 1) {
      largest = Math.max(largest, Math.abs((frame[at] ?? NaN) - (vertices[index * n + at] ?? NaN)));
    }
  }
  return largest;
}

describe.each(["trajectory", "trajectory-exact", "trajectory-1.1", "trajectory-1.2", "trajectory-1.3"])(
  "the motion %s",
  (name) => {
    const { bytes, vertices } = golden(name);

    it("has the same vertices as in the reference decoder", () => {
      const motion = new Motion(bytes);
      const n = 3 * motion.header.vertices;
      expect(vertices.length).toBe(motion.header.frames * n);
      const bound = 1e-9 * diagonal(vertices.subarray(0, n)); // the format asks for 1e-5
      expect(
        largestError(
          motion,
          vertices,
          Array.from({ length: 21 }, (_, frame) => frame),
        ),
      ).toBeLessThan(bound);
      expect(largestError(motion, vertices, [20, 0, 13, 8, 9])).toBeLessThan(bound);
    });

    it("has its faces, whole and in order", () => {
      const { faces, header } = new Motion(bytes);
      expect(faces.length).toBe(3 * header.faces);
      expect([...faces.subarray(0, 9)]).toEqual([0, 44, 45, 0, 45, 150, 1, 46, 103]);
      expect(Math.max(...faces)).toBeLessThan(header.vertices);
    });

    it("is refused wherever a byte is altered", () => {
      for (let at = 0; at < bytes.length; at += 29) {
        const altered = bytes.slice();
        altered[at] = (altered[at] ?? 0) ^ 0x55;
        expect(() => {
          const motion = new Motion(altered);
          for (const { first } of motion.header.groups) motion.frame(first);
        }, `byte ${at}`).toThrow(/.+/);
      }
    });

    it("is refused wherever it is cut off", () => {
      for (let length = 0; length < bytes.length; length += 41) {
        expect(() => new Motion(bytes.slice(0, length)), `${length} bytes`).toThrow(CorruptMotion);
      }
    });
  },
);

describe("a motion of the profile gradient", () => {
  const { bytes, vertices } = golden("gradient");

  it("has the same vertices as in the reference decoder, in any order", () => {
    const motion = new Motion(bytes);
    const n = 3 * motion.header.vertices;
    expect(motion.header).toMatchObject({ profile: "gradient", frames: 6, vertices: 205 });
    const bound = 1e-8 * diagonal(vertices.subarray(0, n)); // the format asks for 1e-5
    expect(largestError(motion, vertices, [0, 1, 2, 3, 4, 5])).toBeLessThan(bound);
    expect(largestError(motion, vertices, [5, 2, 0, 3, 1])).toBeLessThan(bound);
  });

  it("tells the clusters of its first predicted frame", () => {
    const labels = new Motion(bytes).labels(0);
    expect(new Set(labels).size).toBeGreaterThan(1);
    expect(Math.min(...labels)).toBeGreaterThanOrEqual(0);
  });

  it("is refused where its sections contradict themselves, and never ends in a loop", () => {
    const view = new DataView(bytes.buffer);
    let refused = 0;
    for (let at = 8; at < bytes.length;) {
      const length = view.getUint32(at + 4, true);
      for (let inner = 0; inner < length; inner += Math.max(3, Math.floor(length / 12))) {
        const altered = bytes.slice();
        altered[at + 8 + inner] = (altered[at + 8 + inner] ?? 0) ^ 0xff;
        new DataView(altered.buffer).setUint32(at + 8 + length, crc32(altered.subarray(at, at + 8 + length)), true);
        try {
          const motion = new Motion(altered);
          for (let frame = 0; frame < Math.min(motion.header.frames, 6); frame += 1) motion.frame(frame);
        } catch (error) {
          refused += 1;
          expect((error as Error).message).toMatch(/^The motion file is damaged: section/);
        }
      }
      at += 12 + length;
    }
    expect(refused).toBeGreaterThan(10);
  });
});

describe("a motion's header", () => {
  it("tells what is known of it", () => {
    const { header } = new Motion(golden("trajectory").bytes);
    expect(header).toMatchObject({
      name: "two sheets",
      unit: "m",
      fps: 25,
      vertices: 163,
      frames: 21,
      profile: "trajectory",
    });
    expect(header.groups.map(({ first, frames }) => [first, frames])).toEqual([
      [0, 10],
      [10, 11],
    ]);
    expect(header.met.kgPercent).toBeLessThanOrEqual(header.asked.kgPercent);
  });
});

it.each(["trajectory-1.3", "gradient"])("a header that tells of millions of vertices is refused: %s", (name) => {
  const altered = golden(name).bytes.slice();
  const view = new DataView(altered.buffer);
  const length = view.getUint32(12, true);
  view.setUint32(20, 16_000_000, true);
  view.setUint32(16 + length, crc32(altered.subarray(8, 16 + length)), true);
  expect(() => new Motion(altered)).toThrow(/section HEAD tells of more vertices than its memory holds/);
});

it("crc32 is that of zip and PNG", () => expect(crc32(new TextEncoder().encode("123456789"))).toBe(0xcbf43926));

it("a stream that was altered with its checksum ends in a sentence, never in a loop or an overflow", () => {
  const { bytes } = golden("trajectory");
  const view = new DataView(bytes.buffer);
  // The sections behind the header, each of them spoilt in many places under a checksum that holds.
  for (let at = 8; at < bytes.length;) {
    const length = view.getUint32(at + 4, true);
    // A header may tell of a little more than there is; of 65,000 vertices it would only take long.
    const spoilt = at === 8 ? 0x03 : 0xff;
    for (let inner = 0; inner < length; inner += Math.max(5, Math.floor(length / 15))) {
      const altered = bytes.slice();
      altered[at + 8 + inner] = (altered[at + 8 + inner] ?? 0) ^ spoilt;
      new DataView(altered.buffer).setUint32(at + 8 + length, crc32(altered.subarray(at, at + 8 + length)), true);
      try {
        const motion = new Motion(altered);
        for (let frame = 0; frame < Math.min(motion.header.frames, 40); frame += 10) motion.frame(frame);
      } catch (error) {
        expect((error as Error).message).toMatch(/^The motion file is damaged: section/);
      }
    }
    at += 12 + length;
  }
});
