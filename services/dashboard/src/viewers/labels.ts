/** What the numbers of `labels.nii.gz` stand for, and the colors they have everywhere (`--label-*` in app.css). */
export const LABELS = [
  { value: 1, name: "Enhancing tumor", color: "#f2a24a" },
  { value: 2, name: "Enclosed core", color: "#5aa9e6" },
  { value: 3, name: "Vessel", color: "#e4576a" },
  { value: 4, name: "Microhemorrhage", color: "#b48cf2" },
] as const;

/** What somebody else has drawn. */
export const REFERENCE_COLOR = "#4fd18b";

/** Names by value; where any object was looked for, what was found is no tumor. */
export type LabelNames = Readonly<Record<number, string>>;

export function labelNames(mode: "tumor" | "object" = "tumor"): LabelNames {
  const names = Object.fromEntries(LABELS.map(({ value, name }) => [value, name]));
  return mode === "object" ? { ...names, 1: "Object", 2: "Enclosed" } : names;
}

/** "#f2a24a" → [242, 162, 74]. */
export function rgb(color: string): [number, number, number] {
  const value = Number.parseInt(color.slice(1), 16);
  return [(value >> 16) & 0xff, (value >> 8) & 0xff, value & 0xff];
}
