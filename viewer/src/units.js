// Numbers as they are shown: SI with the unit always beside them.

const minus = (text) => (/^-0\.?0*$/.test(text) ? text.slice(1) : text.replace('-', '\u2212'));

export const metres = (x, digits = 3) => `${minus(x.toFixed(digits))} m`;
export const millimetres = (x, digits = 1) => `${minus((1000 * x).toFixed(digits))} mm`;
export const degrees = (x, digits = 1) => `${minus(((180 / Math.PI) * x).toFixed(digits))}°`;
export const newtons = (x) => `${minus(x.toFixed(0))} N`;
export const percent = (x, digits = 1) => `${minus((100 * x).toFixed(digits))} %`;
export const count = (n) => n.toLocaleString('en').replaceAll(',', '\u202f');
export const scientific = (x) => (x === 0 ? '0' : minus(x.toExponential(1)));
