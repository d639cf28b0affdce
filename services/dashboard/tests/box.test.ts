import { describe, expect, it } from "vitest";
import { onceMore } from "@/features/segmentation/params";
import { around, beginDrag, type Box, type SliceView, toScreen, toSlice, viewAt } from "@/viewers/volume/box";

/** An axial slice, the patient's left on the right: 200 mm by 100 mm at two pixels a millimetre. */
const AXIAL: SliceView = {
  across: 0,
  up: 1,
  through: 2,
  left: 10,
  top: 20,
  width: 400,
  height: 200,
  mirrored: true,
  low: [-120, -40],
  size: [200, 100],
};
const SAGITTAL: SliceView = { ...AXIAL, across: 1, up: 2, through: 0, left: 420, mirrored: false };
const BOX: Box = [-30, -10, 5, 10, 20, 45];

describe("a slice on the canvas", () => {
  it("has the patient's right on the left where it is mirrored", () => {
    expect(toScreen(AXIAL, [80, 60])).toEqual([10, 20]);
    expect(toScreen(AXIAL, [-120, -40])).toEqual([410, 220]);
    expect(toScreen(SAGITTAL, [-120, -40])).toEqual([420, 220]);
  });

  it.each([AXIAL, SAGITTAL])("leads back to where a point is seen", (view) => {
    const [across, up] = toSlice(view, toScreen(view, [-3, 17]));
    expect(across).toBeCloseTo(-3);
    expect(up).toBeCloseTo(17);
  });

  it("gives no point outside of itself", () => {
    expect(toSlice(AXIAL, [-50, 900])).toEqual([80, -40]);
  });

  it("is found by a place on it", () => {
    expect(viewAt([AXIAL, SAGITTAL], [430, 30])).toBe(SAGITTAL);
    expect(viewAt([AXIAL, SAGITTAL], [5, 30])).toBeUndefined();
  });
});

describe("a drag", () => {
  it("beside the box draws a new one of the same depth", () => {
    const move = beginDrag(BOX, AXIAL, [30, 40], 4, 20);
    expect(move([50, 25])).toEqual([30, 25, 5, 50, 40, 45]);
    expect(move([20, 55])).toEqual([20, 40, 5, 30, 55, 45]);
  });

  it("in a slice that the box does not reach draws one around that slice", () => {
    expect(beginDrag(BOX, AXIAL, [0, 0], 4, 80)([20, 40])).toEqual([0, 0, 65, 20, 40, 95]);
  });

  it("from inside carries the box", () => {
    expect(beginDrag(BOX, AXIAL, [0, 0], 4, 20)([7, -5])).toEqual([-23, -15, 5, 17, 15, 45]);
  });

  it("from a side takes that side along, from a corner both, also past the other side", () => {
    expect(beginDrag(BOX, AXIAL, [11, 0], 4, 20)([25, 99])).toEqual([-30, -10, 5, 25, 20, 45]);
    expect(beginDrag(BOX, AXIAL, [-29, 21], 4, 20)([-50, 30])).toEqual([-50, -10, 5, 10, 30, 45]);
    expect(beginDrag(BOX, AXIAL, [11, 0], 4, 20)([-60, 0])).toEqual([-60, -10, 5, -30, 20, 45]);
  });

  it("changes the two axes of its slice", () => {
    expect(beginDrag(BOX, SAGITTAL, [20, 45], 2, 0)([30, 60])).toEqual([-30, -10, 5, 10, 30, 60]);
  });
});

it("a first box lies around the crosshair", () => {
  expect(around([1, 2, 3], 10)).toEqual([-4, -3, -2, 6, 7, 8]);
});

describe("the work once more", () => {
  const job = { kind: "segmentation", inputs: { post: ["a"], pre: ["b"], vessels: ["c"] }, params: { max_objects: 3 } };

  it("starts from seeds as it was", () => {
    expect(onceMore(job, [[1.234, 5, 6]], null)).toEqual({ ...job, params: { max_objects: 3, seeds: [[1.23, 5, 6]] } });
  });

  it("looks for any object in a box, in one volume", () => {
    const { inputs, params } = onceMore(
      { ...job, params: { seeds: [[9, 9, 9]], mode: "tumor" } },
      [],
      [0, 1, 2, 3, 4, 5.678],
    );
    expect(inputs).toEqual({ post: ["a"], vessels: ["c"] });
    expect(params).toEqual({ mode: "object", box: [0, 1, 2, 3, 4, 5.68] });
  });
});
