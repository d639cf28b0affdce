import type { Asset } from "@/api/types";

/** The volume viewer tells formats apart by a file's ending, and an asset's name is whatever its owner called it. */
const ENDINGS: Record<string, string> = { nrrd: "nrrd", metaimage: "mha" };

/** A name under which the viewer can read a volume; null for what it cannot. */
export function drawableName(asset: Pick<Asset, "format">): string | null {
  if (asset.format === "nifti1" || asset.format === "nifti2") return "volume.nii.gz"; // also where it is not gzipped
  const ending = ENDINGS[asset.format];
  return ending ? `volume.${ending}` : null;
}
