import { gzipSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { rateAt } from "@/features/motion/rate";
import { readResiduals, typicalError } from "@/features/motion/residuals";
import { errorColor } from "@/viewers/motion/errorColors";

function file(frames: number, vertices: number, step: number, values: Int8Array): ArrayBuffer {
  const bytes = new Uint8Array(16 + values.length);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, 0x31524d53, true);
  view.setUint32(4, frames, true);
  view.setUint32(8, vertices, true);
  view.setFloat32(12, step, true);
  bytes.set(new Uint8Array(values.buffer), 16);
  return new Uint8Array(gzipSync(bytes)).buffer;
}

describe("residuals", () => {
  it("are read as they were written", async () => {
    const values = Int8Array.from([3, 0, -4, 0, 0, 0]);
    const found = await readResiduals(file(2, 1, 0.5, values));
    expect(found).toMatchObject({ frames: 2, vertices: 1, step: 0.5 });
    expect([...found.values]).toEqual([3, 0, -4, 0, 0, 0]);
    expect(typicalError(found)).toBeCloseTo(0.5 * Math.sqrt(25 / 2));
  });

  it("that are cut off or something else are refused", async () => {
    await expect(readResiduals(file(3, 1, 0.5, new Int8Array(6)))).rejects.toThrow("cut off");
    await expect(readResiduals(new Uint8Array(gzipSync(new Uint8Array(40))).buffer)).rejects.toThrow("cannot be read");
  });
});

describe("the rate at another quality", () => {
  const curve = [0.1, 0.2, 0.4].map((kg) => ({ kg, bits: 0.8 * (kg / 0.1) ** -0.8 }));

  it("follows the power between and beyond the points", () => {
    for (const kg of [0.02, 0.1, 0.15, 0.4, 1]) expect(rateAt(curve, kg)).toBeCloseTo(0.8 * (kg / 0.1) ** -0.8);
  });

  it("is not known from one point", () => expect(rateAt(curve.slice(0, 1), 0.1)).toBeNull());
});

it("errors go from blue to red, and what is beyond the scale keeps its last color", () => {
  const colors = new Float32Array(9);
  errorColor(0, colors, 0);
  errorColor(1, colors, 3);
  errorColor(7, colors, 6);
  expect(colors[2]).toBeGreaterThan(2 * (colors[0] ?? 1));
  expect(colors[3]).toBeGreaterThan(3 * (colors[5] ?? 1));
  expect([...colors.subarray(6)]).toEqual([...colors.subarray(3, 6)]);
});
