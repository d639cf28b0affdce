/** "side:left" → ["side", "left"]; null where it is no label. */
export function readLabel(text: string): [string, string] | null {
  const at = text.indexOf(":");
  const [name, value] = [text.slice(0, at).trim(), text.slice(at + 1).trim()];
  return at > 0 && name !== "" && name.length <= 64 && value.length <= 256 ? [name, value] : null;
}

/** Labels given as texts; those that are none are left out, and of two with one name the later one counts. */
export function readLabels(texts: readonly string[]): Record<string, string> {
  return Object.fromEntries(texts.map(readLabel).filter((label) => label !== null));
}

export function writeLabels(labels: Readonly<Record<string, string>>): string[] {
  return Object.entries(labels).map(([name, value]) => `${name}:${value}`);
}
