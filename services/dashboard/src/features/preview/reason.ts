/** Why a file could not be read, for whoever wanted to see it. */
export function reasonOf(error: unknown): string {
  if (error instanceof RangeError) return "This file needs more memory than the browser has.";
  return error instanceof Error ? error.message : String(error);
}
