// Light and dark: the colours live in the style sheet, the 3-D layers read them from there.

const listeners = [];

/** The colour that the style sheet gives to a name, such as `loaded`. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export function isDark() {
  return document.documentElement.dataset.theme === 'dark';
}

/** Calls `listener` now and after every change of the theme. */
export function onTheme(listener) {
  listeners.push(listener);
  listener();
}

export function setTheme(name) {
  document.documentElement.dataset.theme = name;
  for (const listener of listeners) listener();
}

export function toggleTheme() {
  setTheme(isDark() ? 'light' : 'dark');
}

/** The theme of the address, else the system's. */
export function startTheme(wanted) {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const follows = wanted !== 'light' && wanted !== 'dark';
  setTheme(follows ? (system.matches ? 'dark' : 'light') : wanted);
  if (follows) system.addEventListener('change', () => setTheme(system.matches ? 'dark' : 'light'));
}
