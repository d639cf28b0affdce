import type { components } from "@/api/schema";
import type { Job, JobCreate } from "@/api/types";
import type { Box } from "@/viewers/volume/box";

export type SegmentationParams = components["schemas"]["SegmentationParams"];
export type SegmentationResult = components["schemas"]["SegmentationResult"];
export type SegmentedObject = components["schemas"]["SegmentedObject"];

/** RAS mm. */
export type Point = [number, number, number];

/** Read seed points as people write them: three numbers each (RAS mm), one point to a line or separated by semicolons. */
export function parseSeeds(text: string): {
  seeds: [number, number, number][];
  problem: string | null;
} {
  const seeds: [number, number, number][] = [];
  for (const line of text.split(/[\n;]/)) {
    if (!line.trim()) continue;
    const numbers = line
      .trim()
      .split(/[\s,]+/)
      .map(Number);
    const [x, y, z, ...rest] = numbers;
    if (x === undefined || y === undefined || z === undefined || rest.length > 0 || !numbers.every(Number.isFinite)) {
      return {
        seeds: [],
        problem: `“${line.trim()}” is not a point: give three numbers, like 12.5, -30, 41.`,
      };
    }
    seeds.push([x, y, z]);
  }
  if (seeds.length > 64)
    return {
      seeds: [],
      problem: `Up to 64 seeds are taken; these are ${seeds.length}.`,
    };
  return { seeds, problem: null };
}

/** Read two opposite corners of a box (RAS mm), six numbers; nothing gives no box. */
export function parseBox(text: string): { box: number[] | null; problem: string | null } {
  const trimmed = text.trim();
  if (!trimmed) return { box: null, problem: null };
  const numbers = trimmed.split(/[\s,;]+/).map(Number);
  if (numbers.length !== 6 || !numbers.every(Number.isFinite)) {
    return {
      box: null,
      problem: "A box is six numbers: one corner and the one opposite, like -10, 0, 20, 30, 45, 60.",
    };
  }
  return { box: numbers, problem: null };
}

/** What the form asks for, as it is written there. */
export interface Choices {
  mode: NonNullable<SegmentationParams["mode"]>;
  seeds: string;
  box: string;
  register: boolean;
  polarity: NonNullable<SegmentationParams["polarity"]>;
  vesselSeeds: string;
  microhemorrhages: NonNullable<SegmentationParams["microhemorrhages"]>;
  maxObjects: number | "";
  topology: NonNullable<SegmentationParams["topology"]>;
  edgeLength: number | "";
  smoothing: number;
  randomSeed: number | "";
}

export const DEFAULTS: Choices = {
  mode: "auto",
  seeds: "",
  box: "",
  register: true,
  polarity: "auto",
  vesselSeeds: "",
  microhemorrhages: "auto",
  maxObjects: 8,
  topology: "adaptive",
  edgeLength: "",
  smoothing: 0.12,
  randomSeed: 0,
};

/** What stands in the way of a job, by field; and its parameters: only what differs from the server's own defaults. */
export function readChoices(
  choices: Choices,
  withVessels: boolean,
): { problems: Partial<Record<keyof Choices, string>>; params: Record<string, unknown> } {
  const seeds = parseSeeds(choices.seeds);
  const box = parseBox(choices.box);
  const vesselSeeds = withVessels ? parseSeeds(choices.vesselSeeds) : { seeds: [], problem: null };
  const pointed = seeds.seeds.length > 0 || box.box !== null;
  const problems: Partial<Record<keyof Choices, string>> = {
    ...(seeds.problem ? { seeds: seeds.problem } : {}),
    ...(box.problem ? { box: box.problem } : {}),
    ...(vesselSeeds.problem ? { vesselSeeds: vesselSeeds.problem } : {}),
    ...(choices.mode === "object" && !pointed && !seeds.problem && !box.problem
      ? { mode: "Say which object is meant: give a seed point or a box." }
      : {}),
    ...(choices.mode === "tumor" && box.box ? { box: "A box is for any object; tumors are found without one." } : {}),
  };
  const changed: [string, unknown, boolean][] = [
    ["mode", choices.mode, choices.mode !== DEFAULTS.mode],
    ["seeds", seeds.seeds, seeds.seeds.length > 0],
    ["box", box.box, box.box !== null],
    ["register_volumes", choices.register, !choices.register],
    ["polarity", choices.polarity, withVessels && choices.polarity !== DEFAULTS.polarity],
    ["vessel_seeds", vesselSeeds.seeds, vesselSeeds.seeds.length > 0],
    [
      "microhemorrhages",
      choices.microhemorrhages,
      withVessels && choices.microhemorrhages !== DEFAULTS.microhemorrhages,
    ],
    ["max_objects", choices.maxObjects, choices.maxObjects !== "" && choices.maxObjects !== DEFAULTS.maxObjects],
    ["topology", choices.topology, choices.topology !== DEFAULTS.topology],
    ["edge_length", choices.edgeLength, choices.edgeLength !== ""],
    ["smoothing", choices.smoothing, choices.smoothing !== DEFAULTS.smoothing],
    ["random_seed", choices.randomSeed, choices.randomSeed !== "" && choices.randomSeed !== DEFAULTS.randomSeed],
  ];
  return {
    problems,
    params: Object.fromEntries(changed.filter(([, , differs]) => differs).map(([name, value]) => [name, value])),
  };
}

/** Whether a job's result has the form of a segmentation's. */
export function isSegmentationResult(result: unknown): result is SegmentationResult {
  return typeof result === "object" && result !== null && "objects" in result && Array.isArray(result.objects);
}

/** The job's work once more from other places. A box points at any object, which is looked for in one volume. */
export function onceMore(
  job: Pick<Job, "kind" | "inputs" | "params">,
  seeds: readonly Point[],
  box: Box | null,
): JobCreate {
  const rounded = (values: readonly number[]) => values.map((value) => Math.round(value * 100) / 100);
  const without = <T>(from: Record<string, T>, ...names: string[]) =>
    Object.fromEntries(Object.entries(from).filter(([name]) => !names.includes(name)));
  return {
    kind: job.kind,
    inputs: box ? without(job.inputs, "pre") : job.inputs,
    params: {
      ...without(job.params, "box", "seeds"),
      ...(box ? { mode: "object", box: rounded(box) } : {}),
      ...(seeds.length > 0 ? { seeds: seeds.map(rounded) } : {}),
    },
  };
}
