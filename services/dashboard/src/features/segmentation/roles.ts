import type { Asset } from "@/api/types";

/** Which volume was made before contrast, which after, and which shows vessels. */
export interface Roles {
  post: string | null;
  pre: string | null;
  vessels: string | null;
}

/** What tells the volumes of one examination apart in their names. */
const ROLE_WORDS = /(t1[-_ ]?(c|ce|gd|ca|post)?|post|pre|contrast|enhanced|gad|gd|ce|native|plain)(?![a-z])/gi;
const AFTER = /(t1[-_ ]?(c|ce|gd|ca|post)|post|contrast|enhanced|gad|[-_ ]gd|[-_ ]ce)(?![a-z])/i;
const VESSELS = /(^|[-_. ])(swi|swan|mra|tof|cta|vessels?|angio\w*)(?![a-z])/i;
const BEFORE = /(t1|pre|native|plain)(?![a-z])/i;

/** Guess from the names which of some volumes is which; what the names don't tell is left to the user. */
export function guessRoles(volumes: readonly Pick<Asset, "id" | "filename">[]): Roles {
  const vessels = volumes.find((volume) => says(VESSELS, volume));
  const heads = volumes.filter((volume) => !says(VESSELS, volume));
  const after = heads.filter((volume) => says(AFTER, volume));
  const [only, ...others] = heads;
  const post = after[0] ?? (only && others.length === 0 && !says(BEFORE, only) ? only : undefined);
  const pre = heads.find((volume) => volume !== post && !says(AFTER, volume) && says(BEFORE, volume));
  return { post: post?.id ?? null, pre: pre?.id ?? null, vessels: vessels?.id ?? null };
}

/** A volume after contrast, and the one before where there is one. */
export interface Pair {
  post: string;
  pre: string | null;
}

/** Find the volumes that say they were made after contrast, each with the one before of the same examination. */
export function pairUp(volumes: readonly Pick<Asset, "id" | "filename">[]): Pair[] {
  const before = new Map<string, string>();
  for (const volume of volumes) {
    if (says(AFTER, volume) || !says(BEFORE, volume)) continue;
    const name = examination(volume.filename);
    if (!before.has(name)) before.set(name, volume.id);
  }
  return volumes
    .filter((volume) => says(AFTER, volume))
    .map(({ id, filename }) => ({ post: id, pre: before.get(examination(filename)) ?? null }));
}

function says(pattern: RegExp, { filename }: Pick<Asset, "filename">): boolean {
  return pattern.test(stem(filename));
}

function examination(filename: string): string {
  return stem(filename)
    .replace(ROLE_WORDS, "")
    .replace(/[-_. ]+/g, " ")
    .trim()
    .toLowerCase();
}

function stem(filename: string): string {
  return filename.replace(/\.(nii|nii\.gz|nrrd|mha|mhd|zip|dcm)$/i, "");
}
