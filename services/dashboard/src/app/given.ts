/** Without what is not given, so that addresses stay short. */
export function given<T extends Record<string, unknown>>(search: T): T {
  return Object.fromEntries(
    Object.entries(search).filter(([, value]) => value && (!Array.isArray(value) || value.length > 0)),
  ) as T;
}
