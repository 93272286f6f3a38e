// The support region from above, to scale.
import { svg } from './dom.js';

const [WIDTH, HEIGHT, PAD] = [308, 190, 16];
const BARS_M = [0.05, 0.1, 0.2, 0.5, 1, 2];

/** A drawing of the contacts, the support region and the CoM in the plane; W's x to the right. */
export function supportPlot(stance) {
  const [comX, comY] = stance.com_W;
  const all = [
    ...stance.contacts.flatMap((contact) => contact.vertices_W),
    ...(stance.support?.region ?? []),
    [comX, comY],
  ];
  const range = (k) => [Math.min(...all.map((p) => p[k])), Math.max(...all.map((p) => p[k]))];
  const [[x0, x1], [y0, y1]] = [range(0), range(1)];
  const scale = Math.min(
    (WIDTH - 2 * PAD) / Math.max(x1 - x0, 0.25),
    (HEIGHT - 2 * PAD - 14) / Math.max(y1 - y0, 0.25),
  );
  const at = ([x, y]) => [
    WIDTH / 2 + scale * (x - (x0 + x1) / 2),
    (HEIGHT - 14) / 2 - scale * (y - (y0 + y1) / 2),
  ];
  const outline = (points) => points.map((p) => at(p).map((v) => v.toFixed(2)).join()).join(' ');

  const bar = BARS_M.findLast((length) => length * scale < 0.4 * WIDTH) ?? BARS_M[0];
  const [cx, cy] = at([comX, comY]);
  const edge = stance.support?.com_edge_m;
  return svg('svg', {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: 'plot', role: 'img',
    'aria-label': stance.support
      ? `Support region from above; the centre of mass is ${Math.abs(1000 * edge).toFixed(0)} mm ${edge < 0 ? 'outside' : 'inside'} its edge`
      : 'Contacts from above; no support region',
  },
  stance.support && svg('polygon', { points: outline(stance.support.region), class: 'region' }),
  stance.contacts.map((contact) => svg('polygon', {
    points: outline(contact.vertices_W), class: contact.loaded ? 'patch loaded' : 'patch unloaded',
  })),
  stance.support?.kept && svg('polygon', { points: outline(stance.support.kept), class: 'kept' }),
  stance.contacts.filter((c) => c.centre_of_pressure_W).map((contact) => {
    const [x, y] = at(contact.centre_of_pressure_W);
    return svg('path', { d: `M${x - 3.5} ${y - 3.5}l7 7m0 -7l-7 7`, class: 'pressure' });
  }),
  svg('g', { class: 'com' },
    svg('circle', { cx, cy, r: 6 }),
    svg('path', { d: `M${cx} ${cy}V${cy - 6}A6 6 0 0 1 ${cx + 6} ${cy}zM${cx} ${cy}V${cy + 6}A6 6 0 0 1 ${cx - 6} ${cy}z` })),
  svg('g', { class: 'bar' },
    svg('path', { d: `M${PAD} ${HEIGHT - 12}v4h${bar * scale}v-4` }),
    svg('text', { x: PAD + bar * scale + 6, y: HEIGHT - 5 }, `${bar} m`),
    svg('path', { d: `M${WIDTH - 62} ${HEIGHT - 8}h26m-5 -3l5 3l-5 3` }),
    svg('text', { x: WIDTH - 32, y: HEIGHT - 5 }, 'x in W')));
}
