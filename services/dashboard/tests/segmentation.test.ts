import { describe, expect, it } from "vitest";
import { problemFrom } from "@/api/problem";
import { changedParams } from "@/features/jobs/changedParams";
import { DEFAULTS, parseBox, parseSeeds, readChoices } from "@/features/segmentation/params";
import { guessRoles, pairUp } from "@/features/segmentation/roles";
import { LABELS, rgb } from "@/viewers/labels";

const volumes = (...names: string[]) => names.map((filename) => ({ id: filename, filename }));

describe("guessRoles", () => {
  it.each([
    [["t1.nii.gz", "t1c.nii.gz"], "t1c.nii.gz", "t1.nii.gz"],
    [["BraTS_t1ce.nii.gz", "BraTS_t1.nii.gz"], "BraTS_t1ce.nii.gz", "BraTS_t1.nii.gz"],
    [["pre.nii", "post.nii"], "post.nii", "pre.nii"],
    [["patient-T1-Gd.zip", "patient-T1.zip"], "patient-T1-Gd.zip", "patient-T1.zip"],
    [["scan.nii.gz"], "scan.nii.gz", null],
    [["pre.nii.gz"], null, "pre.nii.gz"],
    [["flair.nii.gz", "t2.nii.gz"], null, null],
    [["postman.nii.gz", "other.nii.gz"], null, null],
  ])("%j: after %s, before %s", (names, post, pre) => {
    expect(guessRoles(volumes(...names))).toEqual({ post, pre, vessels: null });
    expect(guessRoles(volumes(...names).reverse())).toEqual({ post, pre, vessels: null });
  });
  it.each(["swi.nii.gz", "case_SWI.nii", "TOF-MRA.nii.gz", "angiography.nrrd"])("%s shows vessels", (vessels) => {
    expect(guessRoles(volumes("t1c.nii.gz", vessels, "t1.nii.gz"))).toEqual({
      post: "t1c.nii.gz",
      pre: "t1.nii.gz",
      vessels,
    });
    expect(guessRoles(volumes("scan.nii", vessels)).post).toBe("scan.nii");
  });
  it("does not take other words for vessels", () => {
    expect(guessRoles(volumes("swimmer.nii", "octave.nii")).vessels).toBeNull();
  });
});

describe("parseSeeds", () => {
  it("reads points as people write them", () => {
    expect(parseSeeds("12.5, -30, 41\n 1 2 3 ;4,5,6\n\n").seeds).toEqual([
      [12.5, -30, 41],
      [1, 2, 3],
      [4, 5, 6],
    ]);
  });
  it.each(["1, 2", "1 2 3 4", "a b c", "1, , 3", "1e999 0 0"])("refuses %j and says so", (text) => {
    const { seeds, problem } = parseSeeds(text);
    expect(seeds).toEqual([]);
    expect(problem).toContain(text);
  });
  it("keeps the server's limit", () => {
    expect(parseSeeds("0 0 0\n".repeat(65)).problem).toMatch(/64/);
    expect(parseSeeds("0 0 0\n".repeat(64)).seeds).toHaveLength(64);
  });
});

describe("parseBox", () => {
  it("reads two corners, or none", () => {
    expect(parseBox("-10, 0 20; 30,45 60")).toEqual({ box: [-10, 0, 20, 30, 45, 60], problem: null });
    expect(parseBox("  ")).toEqual({ box: null, problem: null });
  });
  it.each(["1 2 3", "1 2 3 4 5 6 7", "1 2 3 4 5 x"])("refuses %j", (text) => {
    expect(parseBox(text)).toMatchObject({ box: null, problem: expect.stringMatching(/six numbers/) as string });
  });
});

describe("readChoices", () => {
  it("sends nothing that the server assumes anyway", () => {
    expect(readChoices(DEFAULTS, true)).toEqual({ problems: {}, params: {} });
  });
  it("sends what differs", () => {
    const choices = { ...DEFAULTS, mode: "object", box: "0 0 0 9 9 9", register: false, edgeLength: 0.7 } as const;
    expect(readChoices(choices, false)).toEqual({
      problems: {},
      params: { mode: "object", box: [0, 0, 0, 9, 9, 9], register_volumes: false, edge_length: 0.7 },
    });
  });
  it("speaks of vessels only where a volume shows them", () => {
    const choices = { ...DEFAULTS, polarity: "dark", microhemorrhages: "off", vesselSeeds: "1 2 3" } as const;
    expect(readChoices(choices, false).params).toEqual({});
    expect(readChoices(choices, true).params).toEqual({
      polarity: "dark",
      microhemorrhages: "off",
      vessel_seeds: [[1, 2, 3]],
    });
    expect(readChoices({ ...DEFAULTS, vesselSeeds: "x" }, true).problems).toHaveProperty("vesselSeeds");
    expect(readChoices({ ...DEFAULTS, vesselSeeds: "x" }, false).problems).toEqual({});
  });
  it("asks which object is meant", () => {
    expect(readChoices({ ...DEFAULTS, mode: "object" }, false).problems).toHaveProperty("mode");
    expect(readChoices({ ...DEFAULTS, mode: "object", seeds: "1 2 3" }, false).problems).toEqual({});
    expect(readChoices({ ...DEFAULTS, mode: "object", seeds: "1 2" }, false).problems).toHaveProperty("seeds");
    expect(readChoices({ ...DEFAULTS, mode: "tumor", box: "0 0 0 9 9 9" }, false).problems).toHaveProperty("box");
  });
});

describe("what is drawn", () => {
  it("has a color of its own for every label", () => {
    expect(new Set(LABELS.map(({ color }) => color)).size).toBe(LABELS.length);
    expect(rgb("#f2a24a")).toEqual([242, 162, 74]);
  });
});

describe("problemFrom", () => {
  it("reads a problem, with the fields that are wrong", () => {
    const body = JSON.stringify({
      status: 422,
      code: "validation_failed",
      detail: "The request is not valid.",
      hint: "Mend it.",
      errors: [{ location: "body.kind", message: "is missing" }, "odd"],
    });
    const error = problemFrom(422, body);
    expect(error).toMatchObject({
      status: 422,
      code: "validation_failed",
      hint: "Mend it.",
    });
    expect(error.message).toBe("The request is not valid. body.kind: is missing");
  });
  it.each(["<html>Bad Gateway</html>", "", "[]", '{"detail": 3}'])("makes the best of %j", (body) => {
    expect(problemFrom(503, body)).toMatchObject({
      status: 503,
      code: "http_503",
    });
  });
});

describe("changedParams", () => {
  const schema = {
    properties: {
      seeds: { default: [] },
      edge: { default: null },
      smoothing: { default: 0.12 },
      must: {},
    },
  };
  it("leaves out what is as it would have been", () => {
    expect(changedParams({ seeds: [], edge: null, smoothing: 0.2, must: 1, unknown: 2 }, schema)).toEqual([
      ["smoothing", 0.2],
      ["must", 1],
      ["unknown", 2],
    ]);
  });
  it("shows everything where the kind is not known", () => {
    expect(changedParams({ a: 1 }, undefined)).toEqual([["a", 1]]);
  });
});

describe("pairUp", () => {
  const named = (...names: string[]) => names.map((filename) => ({ id: filename, filename }));

  it.each([
    [["01_t1.nii.gz", "01_t1c.nii.gz"], [["01_t1c.nii.gz", "01_t1.nii.gz"]]],
    [
      ["b_T1.nii", "a_T1gd.nii", "b-T1-Gd.nii", "a T1.nii"],
      [
        ["a_T1gd.nii", "a T1.nii"],
        ["b-T1-Gd.nii", "b_T1.nii"],
      ],
    ],
    [["x_post.mha", "y_pre.mha"], [["x_post.mha", null]]],
    [["flair.nii", "truth.nii.gz"], []],
    [["BraTS-07-t1ce.nii.gz", "BraTS-08-t1.nii.gz"], [["BraTS-07-t1ce.nii.gz", null]]],
  ])("finds in %j who belongs to whom", (names, pairs) =>
    expect(pairUp(named(...names)).map(({ post, pre }) => [post, pre])).toEqual(pairs),
  );
});
