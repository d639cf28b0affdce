/** The parameters that are not what they would have been anyway, by the defaults in a kind's JSON schema. */
export function changedParams(params: Record<string, unknown>, schema: unknown): [string, unknown][] {
  return Object.entries(params).filter(([name, value]) => {
    const known = defaultOf(schema, name);
    return known === undefined || JSON.stringify(known.value) !== JSON.stringify(value);
  });
}

function defaultOf(schema: unknown, name: string): { value: unknown } | undefined {
  const property = field(field(schema, "properties"), name);
  return typeof property === "object" && property !== null && "default" in property
    ? { value: property.default }
    : undefined;
}

function field(value: unknown, name: string): unknown {
  return typeof value === "object" && value !== null ? (value as Record<string, unknown>)[name] : undefined;
}
