import { describe, expect, it } from "vitest";
import { describeAsset } from "@/format/asset";
import {
  ago,
  anatomical,
  area,
  bytes,
  duration,
  integer,
  percent,
  relative,
  significant,
  volume,
} from "@/format/format";

/** Unbreakable spaces, as a reader sees them. */
const plain = (text: string) => text.replaceAll(/[\u00A0\u202F]/g, " ");

describe("numbers with units", () => {
  it.each([
    [0, "0 B"],
    [999, "999 B"],
    [1000, "1 kB"],
    [1536, "1.54 kB"],
    [999_999, "1 MB"], // never "1000 kB"
    [4_294_967_296, "4.29 GB"],
    [1e15, "1000 TB"],
    [-1, "–"],
    [Number.NaN, "–"],
  ])("%d bytes are %s", (count, text) => expect(plain(bytes(count))).toBe(text));

  it.each([
    [0, "0 mm³"],
    [4.188_79, "4.19 mm³"],
    [999.4, "999 mm³"],
    [1000, "1 cm³"],
    [39_244, "39.2 cm³"],
  ])("%d mm³ are %s", (value, text) => expect(plain(volume(value))).toBe(text));

  it("gives areas in cm² from 10 cm² on", () => {
    expect(plain(area(350))).toBe("350 mm²");
    expect(plain(area(1400))).toBe("14 cm²");
  });

  it("says 100 % only when all is done", () => {
    expect(plain(percent(0.999))).toBe("99 %");
    expect(plain(percent(1))).toBe("100 %");
    expect(plain(percent(-0.2))).toBe("0 %");
    expect(plain(percent(3))).toBe("100 %");
  });

  it.each([
    [0.04, "0.0 s"],
    [9.94, "9.9 s"],
    [9.96, "10 s"],
    [59.6, "1 min"],
    [65, "1 min 05 s"],
    [3600, "1 h"],
    [8040, "2 h 14 min"],
    [-1, "–"],
  ])("%d seconds are %s", (seconds, text) => expect(plain(duration(seconds))).toBe(text));

  it("keeps significant figures without exponents", () => {
    expect(significant(0.000_012_345, 3)).toBe("0.0000123");
    expect(significant(1234.6, 3)).toBe("1230");
    expect(significant(Number.POSITIVE_INFINITY, 3)).toBe("–");
  });

  it("groups thousands", () => expect(plain(integer(1_234_567.4))).toBe("1 234 567"));
});

describe("times", () => {
  const now = Date.parse("2026-01-10T12:00:00Z");
  it.each([
    ["2026-01-10T11:59:50Z", "just now"],
    ["2026-01-10T12:00:20Z", "in less than a minute"],
    ["2026-01-10T11:58:01Z", "1 minute ago"],
    ["2026-01-10T09:00:00Z", "3 hours ago"],
    ["2026-02-08T12:00:00Z", "in 29 days"],
  ])("%s is %s", (at, text) => expect(relative(Date.parse(at), now)).toBe(text));
});

it("never puts what was into the future", () => {
  expect(ago("2026-01-10T12:00:03Z", Date.parse("2026-01-10T12:00:00Z"))).toBe("just now");
});

describe("places and files", () => {
  it("names the sides of a point in RAS", () => {
    expect(plain(anatomical([12, -3.46, 0]))).toBe("R 12.0   P 3.5   S 0.0");
    expect(plain(anatomical([-0.04, 1, -2]))).toBe("L 0.0   A 1.0   I 2.0");
  });

  it("describes what a file was found to be", () => {
    const text = describeAsset({
      kind: "volume",
      format: "nifti1",
      details: { shape: [240, 240, 155], spacing: [1, 1, 1.2000000476837158] },
    });
    expect(text).toBe("Volume · NIfTI · 240 × 240 × 155 · 1 × 1 × 1.2 mm");
  });

  it("keeps to what it knows of unknown formats", () => {
    expect(
      describeAsset({
        kind: "mesh",
        format: "abc",
        details: { vertices: 12_000, shape: "odd" },
      }),
    ).toMatch(/^Mesh · ABC · 12.000 vertices$/);
  });
});
