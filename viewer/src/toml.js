/** A value as TOML, tables in one line. */
export function toml(value) {
  if (Array.isArray(value)) return `[${value.map(toml).join(', ')}]`;
  if (value !== null && typeof value === 'object') {
    const fields = Object.entries(value).filter(([, field]) => field !== null && field !== undefined);
    return `{ ${fields.map(([key, field]) => `${/^[\w-]+$/.test(key) ? key : JSON.stringify(key)} = ${toml(field)}`).join(', ')} }`;
  }
  return JSON.stringify(value);
}
