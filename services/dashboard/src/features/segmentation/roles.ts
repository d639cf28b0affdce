import type { Asset } from "@/api/types";

/** Which volume was made before contrast and which after. */
export interface Roles {
  post: string | null;
  pre: string | null;
}

const AFTER = /(t1[-_ ]?(c|ce|gd|ca|post)|post|contrast|enhanced|gad|[-_ ]gd|[-_ ]ce)(?![a-z])/i;
const BEFORE = /(t1|pre|native|plain)(?![a-z])/i;

/** Guess from the names which of some volumes is which; what the names don't tell is left to the user. */
export function guessRoles(volumes: readonly Pick<Asset, "id" | "filename">[]): Roles {
  const says = (pattern: RegExp, { filename }: Pick<Asset, "filename">) => pattern.test(filename.replace(/\..*$/, ""));
  const after = volumes.filter((volume) => says(AFTER, volume));
  const [only, ...others] = volumes;
  const post = after[0] ?? (only && others.length === 0 && !says(BEFORE, only) ? only : undefined);
  const pre = volumes.find((volume) => volume !== post && !says(AFTER, volume) && says(BEFORE, volume));
  return { post: post?.id ?? null, pre: pre?.id ?? null };
}
