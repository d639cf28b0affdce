import type { Artifact } from "@/api/types";
import { LABELS } from "@/viewers/labels";
import type { SurfaceFile } from "@/viewers/surface/surfaceFile";
import type { SegmentedObject } from "./params";

const [TUMOR, , VESSEL, BLEEDING] = LABELS;
type Label = (typeof LABELS)[number];

/** Objects have their own numbers as ids; vessels and bleedings follow behind all that there can be of the former. */
const FIRST_VESSEL = 1000;
const BLEEDINGS = 2000;

/** The id of a vessel's surface. */
export function vesselId(label: number): number {
  return FIRST_VESSEL + label;
}

/** The surfaces of a segmentation: of each object, of each vessel, of all bleedings together. */
export function surfacesOf(objects: readonly SegmentedObject[], artifacts: readonly Artifact[]): SurfaceFile[] {
  const byName = new Map(artifacts.map((artifact) => [artifact.name, artifact]));
  const surface = (id: number, name: string, group: string, title: string, label: Label): SurfaceFile[] => {
    const file = byName.get(name);
    return file ? [{ id, url: file.url, size: file.size, group, title, label: label.value, color: label.color }] : [];
  };
  const ours = objects.flatMap(({ label, surface: name }) => surface(label, name, "Objects", `Object ${label}`, TUMOR));
  return [
    ...ours,
    ...artifacts.flatMap(({ name }) => {
      const vessel = /^surfaces\/vessel-(\d+)\.ply$/.exec(name);
      const number = Number(vessel?.[1]);
      return vessel ? surface(vesselId(number), name, "Vessels", `Vessel ${number}`, VESSEL) : [];
    }),
    ...surface(BLEEDINGS, "surfaces/microhemorrhages.ply", "Microhemorrhages", "Microhemorrhages", BLEEDING),
  ];
}
