import type { Artifact } from "@/api/types";
import { LABELS } from "@/viewers/labels";
import type { SurfaceFile } from "@/viewers/surface/SurfaceViewer";
import type { SegmentedObject } from "./params";

const [TUMOR, , VESSEL, BLEEDING] = LABELS;
/** Objects have their own numbers as ids; vessels and bleedings follow behind all that there can be of the former. */
const FIRST_VESSEL = 1000;
const BLEEDINGS = 2000;

/** The surfaces of a segmentation: of each object, of each vessel, of all bleedings together. */
export function surfacesOf(objects: readonly SegmentedObject[], artifacts: readonly Artifact[]): SurfaceFile[] {
  const byName = new Map(artifacts.map((artifact) => [artifact.name, artifact]));
  const surface = (id: number, name: string, group: string, title: string, color: string): SurfaceFile[] => {
    const file = byName.get(name);
    return file ? [{ id, url: file.url, size: file.size, group, title, color }] : [];
  };
  const ours = objects.flatMap(({ label, surface: name }) =>
    surface(label, name, "Objects", `Object ${label}`, TUMOR.color),
  );
  return [
    ...(ours.length > 0 ? ours : surface(1, "surface.ply", "Objects", "Object 1", TUMOR.color)),
    ...artifacts.flatMap(({ name }) => {
      const vessel = /^surfaces\/vessel-(\d+)\.ply$/.exec(name);
      const number = Number(vessel?.[1]);
      return vessel ? surface(FIRST_VESSEL + number, name, "Vessels", `Vessel ${number}`, VESSEL.color) : [];
    }),
    ...surface(BLEEDINGS, "surfaces/microhemorrhages.ply", "Microhemorrhages", "Microhemorrhages", BLEEDING.color),
  ];
}
