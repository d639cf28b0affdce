import type { Asset } from "@/api/types";
import { integer, shape, significant } from "./format";

const KINDS: Record<Asset["kind"], string> = {
  volume: "Volume",
  mesh: "Mesh",
  sequence: "Mesh sequence",
  motion: "Compressed motion",
};

const FORMATS: Record<string, string> = {
  nifti1: "NIfTI",
  nifti2: "NIfTI-2",
  nrrd: "NRRD",
  metaimage: "MetaImage",
  dicom: "DICOM",
  "dicom-zip": "DICOM series",
  "mesh-zip": "zip of meshes",
};

export function formatName(format: string): string {
  return FORMATS[format] ?? format.toUpperCase();
}

export function kindName(kind: Asset["kind"]): string {
  return KINDS[kind];
}

function numbers(value: unknown): number[] | null {
  return Array.isArray(value) && value.every((entry) => typeof entry === "number") ? value : null;
}

/** What a file was found to be: "Volume · NIfTI · 240 × 240 × 155 · 1 × 1 × 1 mm". */
export function describeAsset(asset: Pick<Asset, "kind" | "format" | "details">): string {
  const details = asset.details ?? {};
  const parts = [kindName(asset.kind), formatName(asset.format)];
  const extent = numbers(details.shape);
  if (extent) parts.push(shape(extent));
  const spacing = numbers(details.spacing);
  if (spacing)
    parts.push(
      `${spacing
        .slice(0, 3)
        .map((step) => significant(step, 3))
        .join(" × ")} mm`,
    );
  for (const name of ["files", "slices", "frames", "vertices", "faces"]) {
    const count = details[name];
    if (typeof count === "number") parts.push(`${integer(count)} ${name}`);
  }
  return parts.join(" · ");
}
